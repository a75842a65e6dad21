//! Cross-sections of beams and bars.

use crate::FemError;
use std::f64::consts::PI;

/// Constants of a cross-section.
///
/// Axes of the section: x along the beam, y across (the width), z upwards in the section (the height).
/// The section is taken as doubly symmetric: its centroid is its shear centre, y and z are principal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Area $A$, m².
    pub area: f64,
    /// $I_y = \int z^2\,dA$, m⁴: bending in the x–z plane.
    pub iy: f64,
    /// $I_z = \int y^2\,dA$, m⁴: bending in the x–y plane.
    pub iz: f64,
    /// St Venant's torsion constant $J$, m⁴.
    pub torsion: f64,
    /// Timoshenko shear area along y, $\kappa_y A$, m²; `None`: no shear deformation (Bernoulli).
    pub shear_area_y: Option<f64>,
    /// Timoshenko shear area along z, $\kappa_z A$, m²; `None`: no shear deformation (Bernoulli).
    pub shear_area_z: Option<f64>,
}

impl Section {
    /// Section by its numbers. Errors: a number not above 0.
    pub fn general(
        area: f64,
        iy: f64,
        iz: f64,
        torsion: f64,
        shear_areas: [Option<f64>; 2],
    ) -> Result<Self, FemError> {
        let shape = "general";
        for (key, value) in [("area", area), ("iy", iy), ("iz", iz), ("torsion", torsion)] {
            positive(shape, key, value)?;
        }
        for (key, value) in [("shear_area_y", shear_areas[0]), ("shear_area_z", shear_areas[1])] {
            positive(shape, key, value.unwrap_or(1.0))?;
        }
        Ok(Self { area, iy, iz, torsion, shear_area_y: shear_areas[0], shear_area_z: shear_areas[1] })
    }

    /// Solid rectangle of `width` (along y) and `height` (along z), m.
    ///
    /// St Venant's series with the long side $a$ and the short side $b$,
    /// $J = a b^3 \left[\frac13 - \frac{64}{\pi^5}\frac{b}{a}
    /// \sum_{n=1,3,…} \frac{1}{n^5}\tanh\frac{n\pi a}{2b}\right]$ (Timoshenko & Goodier, Theory of
    /// Elasticity, §109); shear by Cowper (1966), $\kappa = 10(1+\nu)/(12+11\nu)$.
    pub fn rectangle(width: f64, height: f64, poisson: f64) -> Result<Self, FemError> {
        positive("rectangle", "width", width)?;
        positive("rectangle", "height", height)?;
        let area = width * height;
        let kappa = rectangle_shear(poisson);
        let (long, short) = (width.max(height), width.min(height));
        Ok(Self {
            area,
            iy: width * height.powi(3) / 12.0,
            iz: height * width.powi(3) / 12.0,
            torsion: rectangle_torsion(long, short),
            shear_area_y: Some(kappa * area),
            shear_area_z: Some(kappa * area),
        })
    }

    /// Solid round of `diameter`, m: $J = \pi d^4/32$; Cowper's $\kappa = 6(1+\nu)/(7+6\nu)$.
    pub fn round(diameter: f64, poisson: f64) -> Result<Self, FemError> {
        positive("round", "diameter", diameter)?;
        Ok(annulus(diameter / 2.0, 0.0, poisson))
    }

    /// Round tube of outer `diameter` and wall `thickness`, m: $J = \pi(R^4-r^4)/2$, exact; Cowper's
    /// $\kappa = \frac{6(1+\nu)(1+m^2)^2}{(7+6\nu)(1+m^2)^2+(20+12\nu)m^2}$, $m = r/R$.
    pub fn tube(diameter: f64, thickness: f64, poisson: f64) -> Result<Self, FemError> {
        positive("tube", "diameter", diameter)?;
        positive("tube", "thickness", thickness)?;
        wall("tube", thickness, diameter)?;
        Ok(annulus(diameter / 2.0, diameter / 2.0 - thickness, poisson))
    }

    /// Rectangular box of outer `width` and `height` with two flanges (horizontal walls) and two webs
    /// (upright walls), m.
    ///
    /// Area and second moments exact. Torsion by Bredt, $J = 4A_m^2/\oint ds/t$, $A_m$ inside the
    /// centre line: good for thin walls (1 % at a thickness of about a tenth of the side), no part for
    /// the walls' own torsion. Shear by Cowper's thin-walled box with centre-line sizes,
    /// see [`Section::shear_area_z`]; along y with flanges and webs in each other's place.
    pub fn hollow_box(
        width: f64,
        height: f64,
        flange_thickness: f64,
        web_thickness: f64,
        poisson: f64,
    ) -> Result<Self, FemError> {
        let shape = "box";
        for (key, value) in [
            ("width", width),
            ("height", height),
            ("flange_thickness", flange_thickness),
            ("web_thickness", web_thickness),
        ] {
            positive(shape, key, value)?;
        }
        wall(shape, flange_thickness, height)?;
        wall(shape, web_thickness, width)?;
        let (b, h) = (width - web_thickness, height - flange_thickness);
        let (inner_b, inner_h) = (width - 2.0 * web_thickness, height - 2.0 * flange_thickness);
        let area = width * height - inner_b * inner_h;
        let torsion = 2.0 * (b * h).powi(2) / (b / flange_thickness + h / web_thickness);
        Ok(Self {
            area,
            iy: (width * height.powi(3) - inner_b * inner_h.powi(3)) / 12.0,
            iz: (height * width.powi(3) - inner_h * inner_b.powi(3)) / 12.0,
            torsion,
            shear_area_y: Some(area * box_shear(h, b, web_thickness, flange_thickness, poisson)),
            shear_area_z: Some(area * box_shear(b, h, flange_thickness, web_thickness, poisson)),
        })
    }

    /// I section of `width` and total `height` with two equal flanges, web upright, m.
    ///
    /// Area and second moments exact (no fillets). $J = \sum s t^3/3$ over flanges and web; no warping
    /// stiffness: a member whose twist is held at its ends is stiffer. Shear along z by Cowper's
    /// thin-walled I with centre-line sizes; along y the flanges alone, as two rectangles.
    pub fn i_section(
        width: f64,
        height: f64,
        flange_thickness: f64,
        web_thickness: f64,
        poisson: f64,
    ) -> Result<Self, FemError> {
        let shape = "I";
        for (key, value) in [
            ("width", width),
            ("height", height),
            ("flange_thickness", flange_thickness),
            ("web_thickness", web_thickness),
        ] {
            positive(shape, key, value)?;
        }
        wall(shape, flange_thickness, height)?;
        if web_thickness >= width {
            let range = "less than the width";
            return Err(FemError::Section { shape, key: "web_thickness", value: web_thickness, range });
        }
        let web = height - 2.0 * flange_thickness;
        let flanges = 2.0 * width * flange_thickness;
        let area = flanges + web * web_thickness;
        let h = height - flange_thickness;
        Ok(Self {
            area,
            iy: (width * height.powi(3) - (width - web_thickness) * web.powi(3)) / 12.0,
            iz: (2.0 * flange_thickness * width.powi(3) + web * web_thickness.powi(3)) / 12.0,
            torsion: (2.0 * width * flange_thickness.powi(3) + h * web_thickness.powi(3)) / 3.0,
            shear_area_y: Some(rectangle_shear(poisson) * flanges),
            shear_area_z: Some(area * i_shear(width, h, flange_thickness, web_thickness, poisson)),
        })
    }

    /// Polar second moment $I_p = I_y + I_z$, m⁴: the rotary inertia of twist is $\rho I_p$ per length.
    pub fn polar(&self) -> f64 {
        self.iy + self.iz
    }

    /// Mass per length $\rho A$, kg/m.
    pub fn mass_per_length(&self, density: f64) -> f64 {
        density * self.area
    }

    /// Whether all constants are above 0, as a beam needs them.
    pub(crate) fn check(&self) -> Result<(), FemError> {
        let shear_areas = [self.shear_area_y, self.shear_area_z];
        Self::general(self.area, self.iy, self.iz, self.torsion, shear_areas).map(|_| ())
    }
}

fn positive(shape: &'static str, key: &'static str, value: f64) -> Result<(), FemError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(FemError::Section { shape, key, value, range: "above 0" })
}

fn wall(shape: &'static str, thickness: f64, outer: f64) -> Result<(), FemError> {
    if 2.0 * thickness < outer {
        return Ok(());
    }
    Err(FemError::SectionWall { shape, thickness, outer })
}

fn annulus(outer: f64, inner: f64, poisson: f64) -> Section {
    let area = PI * (outer.powi(2) - inner.powi(2));
    let moment = PI / 4.0 * (outer.powi(4) - inner.powi(4));
    let m2 = (inner / outer).powi(2);
    let square = (1.0 + m2).powi(2);
    let kappa =
        6.0 * (1.0 + poisson) * square / ((7.0 + 6.0 * poisson) * square + (20.0 + 12.0 * poisson) * m2);
    let shear = Some(kappa * area);
    Section { area, iy: moment, iz: moment, torsion: 2.0 * moment, shear_area_y: shear, shear_area_z: shear }
}

fn rectangle_torsion(long: f64, short: f64) -> f64 {
    // the terms fall as n⁻⁵: 60 of them leave less than 1e-9 of the sum, hence of J
    let sum: f64 = (0..60)
        .map(|k| f64::from(2 * k + 1))
        .map(|n| (n * PI * long / (2.0 * short)).tanh() / n.powi(5))
        .sum();
    long * short.powi(3) * (1.0 / 3.0 - 64.0 / PI.powi(5) * short / long * sum)
}

fn rectangle_shear(poisson: f64) -> f64 {
    10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson)
}

/// Cowper (1966), thin-walled box: $m = b t_f/(h t_w)$, $n = b/h$; shear along $h$.
fn box_shear(b: f64, h: f64, flange: f64, web: f64, poisson: f64) -> f64 {
    let (m, n2) = (b * flange / (h * web), (b / h).powi(2));
    cowper_walls(m, poisson, 10.0 * n2 * ((3.0 + poisson) * m + 3.0 * m * m))
}

/// Cowper (1966), thin-walled I: $m = 2 b t_f/(h t_w)$, $n = b/h$; shear along the web.
fn i_shear(b: f64, h: f64, flange: f64, web: f64, poisson: f64) -> f64 {
    let (m, n2) = (2.0 * b * flange / (h * web), (b / h).powi(2));
    let across = 30.0 * n2 * (m + m * m) + 5.0 * poisson * n2 * (8.0 * m + 9.0 * m * m);
    cowper_walls(m, poisson, across)
}

fn cowper_walls(m: f64, poisson: f64, flange_term: f64) -> f64 {
    let (m2, m3) = (m * m, m * m * m);
    10.0 * (1.0 + poisson) * (1.0 + 3.0 * m).powi(2)
        / (12.0
            + 72.0 * m
            + 150.0 * m2
            + 90.0 * m3
            + poisson * (11.0 + 66.0 * m + 135.0 * m2 + 90.0 * m3)
            + flange_term)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_square_twists_with_the_tabulated_constant() {
        // J = 0.1405770 a⁴ for a square, 0.3333 a b³ (1 - 0.630 b/a) for a strip
        let square = Section::rectangle(2.0, 2.0, 0.3).unwrap();
        assert_relative_eq!(square.torsion, 0.140_577_0 * 16.0, max_relative = 1e-6);
        let strip = Section::rectangle(10.0, 1.0, 0.3).unwrap();
        assert_relative_eq!(strip.torsion, 10.0 / 3.0 * (1.0 - 0.063_025), max_relative = 1e-5);
        assert_relative_eq!(strip.torsion, Section::rectangle(1.0, 10.0, 0.3).unwrap().torsion);
    }

    #[test]
    fn a_thick_tube_without_hole_is_round() {
        let round = Section::round(0.5, 0.3).unwrap();
        let tube = Section::tube(0.5, 0.25 - 1e-9, 0.3).unwrap();
        assert_relative_eq!(tube.area, round.area, max_relative = 1e-8);
        assert_relative_eq!(tube.iy, round.iy, max_relative = 1e-8);
        assert_relative_eq!(tube.shear_area_y.unwrap(), round.shear_area_y.unwrap(), max_relative = 1e-8);
        assert_relative_eq!(round.torsion, PI * 0.5f64.powi(4) / 32.0, max_relative = 1e-14);
    }

    #[test]
    fn a_thin_tube_and_a_thin_square_box_follow_bredt() {
        let tube = Section::tube(1.0, 0.001, 0.3).unwrap();
        let mean: f64 = 0.999 / 2.0;
        assert_relative_eq!(tube.torsion, 2.0 * PI * mean.powi(3) * 0.001, max_relative = 1e-5);
        let hollow = Section::hollow_box(1.0, 1.0, 0.001, 0.001, 0.3).unwrap();
        assert_relative_eq!(hollow.torsion, 0.001 * 0.999f64.powi(3), max_relative = 1e-12);
    }

    /// Without Poisson's effect Cowper's coefficient is that of the shear flow's energy,
    /// $\kappa = I^2 / (A \int (S/t)^2\,t\,ds)$, here summed along the walls of half a section.
    fn shear_flow_kappa(b: f64, h: f64, flange: f64, web: f64, webs: f64) -> f64 {
        let steps = 4000;
        let area = 2.0 * b * flange + webs * web * h;
        let inertia = webs * web * h.powi(3) / 12.0 + b * flange * h * h / 2.0;
        let middle = |k: i32, length: f64| (f64::from(k) + 0.5) * length / f64::from(steps);
        let energy_flange: f64 =
            (0..steps).map(|k| (flange * middle(k, b / 2.0) * h / 2.0).powi(2) / flange).sum::<f64>()
                * (b / 2.0 / f64::from(steps))
                * 4.0;
        let per_web = b * flange * h / 2.0 / webs;
        let energy_web: f64 = (0..steps)
            .map(|k| {
                let z = middle(k, h) - h / 2.0;
                (per_web + web / 2.0 * (h * h / 4.0 - z * z)).powi(2) / web
            })
            .sum::<f64>()
            * (h / f64::from(steps))
            * webs;
        inertia * inertia / (area * (energy_flange + energy_web))
    }

    #[test]
    fn cowper_without_poisson_is_the_energy_of_the_shear_flow() {
        let (b, h, flange, web) = (0.6, 1.3, 0.014, 0.008);
        let hollow = box_shear(b, h, flange, web, 0.0);
        assert_relative_eq!(hollow, shear_flow_kappa(b, h, flange, web, 2.0), max_relative = 1e-6);
        let i = i_shear(b, h, flange, web, 0.0);
        assert_relative_eq!(i, shear_flow_kappa(b, h, flange, web, 1.0), max_relative = 1e-6);
        assert_relative_eq!(rectangle_shear(0.0), 5.0 / 6.0);
    }

    #[test]
    fn the_crane_girder_has_its_tabulated_constants() {
        // case A of the synthetic cranes: 0.6 × 1.3 m, flanges 14 mm, webs 8 mm
        let girder = Section::hollow_box(0.6, 1.3, 0.014, 0.008, 0.3).unwrap();
        assert_relative_eq!(girder.area, 0.03715, max_relative = 2e-4);
        assert_relative_eq!(girder.iy, 0.009_690, max_relative = 2e-4);
        assert_relative_eq!(girder.iz, 0.002_287, max_relative = 2e-4);
        assert_relative_eq!(girder.torsion, 0.005_709, max_relative = 2e-4);
        assert_relative_eq!(girder.mass_per_length(7850.0), 291.6, max_relative = 1e-3);
    }

    #[test]
    fn the_i_section_is_three_rectangles() {
        let i = Section::i_section(0.3, 0.5, 0.02, 0.01, 0.3).unwrap();
        let flange = 0.3 * 0.02f64.powi(3) / 12.0 + 0.3 * 0.02 * 0.24f64.powi(2);
        assert_relative_eq!(i.iy, 2.0 * flange + 0.01 * 0.46f64.powi(3) / 12.0, max_relative = 1e-12);
        assert_relative_eq!(i.area, 2.0 * 0.3 * 0.02 + 0.46 * 0.01, max_relative = 1e-12);
    }

    #[test]
    fn sections_that_are_none_are_refused() {
        assert!(matches!(Section::rectangle(0.0, 1.0, 0.3), Err(FemError::Section { key: "width", .. })));
        assert!(matches!(Section::tube(0.1, -0.01, 0.3), Err(FemError::Section { key: "thickness", .. })));
        assert!(matches!(Section::tube(0.1, 0.05, 0.3), Err(FemError::SectionWall { .. })));
        assert!(matches!(Section::hollow_box(0.1, 0.2, 0.01, 0.06, 0.3), Err(FemError::SectionWall { .. })));
        assert!(matches!(
            Section::i_section(0.1, 0.2, 0.01, 0.1, 0.3),
            Err(FemError::Section { key: "web_thickness", .. })
        ));
        assert!(matches!(
            Section::general(0.0, 1.0, 1.0, 1.0, [None, None]),
            Err(FemError::Section { key: "area", .. })
        ));
    }
}
