//! `field.nc`: motion of the whole column on a regular depth grid, over time.

use std::path::Path;

use super::file::{MOTIONS, OutputFile, Storage, axis_words};
use super::{OutputError, Provenance};
use crate::results::{AXES, PeakProfile};

/// Rows of one chunk along `time`.
const CHUNK: usize = 256;
/// Depths of one chunk at most: 256 × 512 f32 values are 512 KiB.
const CHUNK_DEPTHS: usize = 512;

/// Rows to append for one component, each array `[time][depth]`, row-major.
#[derive(Debug, Clone, Copy)]
pub struct FieldChunk<'a> {
    /// Component: 0 = x, 1 = y, 2 = z.
    pub axis: usize,
    /// Displacement, m.
    pub displacement: &'a [f32],
    /// Velocity, m/s.
    pub velocity: &'a [f32],
    /// Acceleration, m/s².
    pub acceleration: &'a [f32],
}

/// Writer of `field.nc`.
///
/// Dimensions `time` (unlimited) and `depth` (m, positive down); `displacement_x(time, depth)` in m,
/// `velocity_x` in m s⁻¹, `acceleration_x` in m s⁻² for each active component, f32, deflate level 1 with
/// shuffle. Peak values over the run stand on a dimension of their own, `profile` (an interface has
/// two points, one for each layer), and are NaN until [`write_peaks`](Self::write_peaks).
///
/// Appends of a multiple of 256 rows cost least: a chunk that is half full is compressed again.
#[derive(Debug)]
pub struct FieldWriter {
    file: OutputFile,
    axes: Vec<usize>,
    depths: usize,
    profile: usize,
}

impl FieldWriter {
    /// Creates the file.
    ///
    /// - `axes`: active components; - `depth`: grid of the field, m, increasing;
    /// - `profile_depth`: depths of the peak profiles, m (empty: none).
    ///
    /// # Errors
    /// Unwritable folder, full disk, component above 2, empty `depth`.
    pub fn create(
        path: &Path,
        provenance: &Provenance,
        axes: &[usize],
        depth: &[f64],
        profile_depth: &[f64],
    ) -> Result<Self, OutputError> {
        let mut file =
            OutputFile::create(path, 8 * (depth.len() + (1 + 5 * axes.len()) * profile_depth.len()))?;
        let axes = file.checked_axes(axes)?;
        if depth.is_empty() {
            file.expect_length("depth", 0, 1)?;
        }
        provenance.write(&mut file, "motion of the soil column")?;
        file.define_time(provenance, CHUNK)?;
        file.dimension("depth", depth.len())?;
        define_depth(&mut file, "depth", "depth", depth, true)?;
        for &axis in &axes {
            for (motion, units) in MOTIONS {
                file.variable::<f32>(
                    &format!("{motion}_{}", AXES[axis]),
                    &["time", "depth"],
                    Storage { chunk: &[CHUNK, depth.len().min(CHUNK_DEPTHS)], compressed: true },
                    &[
                        ("long_name", &format!("total {motion} {}", axis_words(axis))),
                        ("units", units),
                        ("coordinates", "elapsed_time"),
                    ],
                )?;
            }
        }
        if !profile_depth.is_empty() {
            file.dimension("profile", profile_depth.len())?;
            define_depth(&mut file, "profile_depth", "profile", profile_depth, false)?;
            define_peaks(&mut file, &axes)?;
        }
        file.sync()?;
        Ok(Self { file, axes, depths: depth.len(), profile: profile_depth.len() })
    }

    /// Appends rows for every active component and flushes them.
    ///
    /// # Errors
    /// A missing or unknown component, an array of another length than `elapsed_time.len() * depth.len()`,
    /// full disk.
    pub fn append(&mut self, elapsed_time: &[f64], chunks: &[FieldChunk<'_>]) -> Result<(), OutputError> {
        let rows = elapsed_time.len();
        self.file.expect_length("the list of components", chunks.len(), self.axes.len())?;
        for chunk in chunks {
            self.expect_axis(chunk.axis)?;
            for (motion, values) in motions(chunk) {
                let name = format!("{motion}_{}", letter(chunk.axis));
                self.file.expect_length(&name, values.len(), rows * self.depths)?;
            }
        }
        if rows == 0 {
            return Ok(());
        }
        self.file.expect_room(rows)?;
        self.file.put_time(elapsed_time)?;
        for chunk in chunks {
            for (motion, values) in motions(chunk) {
                let name = format!("{motion}_{}", letter(chunk.axis));
                self.file.put_rows(&name, values, rows, Some(self.depths))?;
            }
        }
        self.file.commit(rows)
    }

    /// Writes the peak profiles; may be called again as peaks grow.
    ///
    /// # Errors
    /// A component or a length that the file was not created with, full disk.
    pub fn write_peaks(&mut self, peaks: &[PeakProfile]) -> Result<(), OutputError> {
        self.file.expect_room_for(5 * 8 * self.profile * peaks.len())?;
        for peak in peaks {
            self.expect_axis(peak.axis)?;
            for (name, values) in peak_values(peak) {
                let name = format!("{name}_{}", letter(peak.axis));
                self.file.expect_length(&name, values.len(), self.profile)?;
                if self.profile > 0 {
                    self.file.put_all(&name, values)?;
                }
            }
        }
        self.file.sync()
    }

    fn expect_axis(&self, axis: usize) -> Result<(), OutputError> {
        if self.axes.contains(&axis) {
            return Ok(());
        }
        Err(OutputError::Axis { path: self.file.path().to_path_buf(), axis, available: self.axes.clone() })
    }

    /// Rows written so far.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.file.rows()
    }

    /// Flushes and closes the file.
    ///
    /// # Errors
    /// Full disk, or a fault of the library.
    pub fn finish(self) -> Result<(), OutputError> {
        self.file.close()
    }
}

fn letter(axis: usize) -> char {
    AXES.get(axis).copied().unwrap_or('?')
}

fn motions<'a>(chunk: &FieldChunk<'a>) -> [(&'static str, &'a [f32]); 3] {
    [(MOTIONS[0].0, chunk.displacement), (MOTIONS[1].0, chunk.velocity), (MOTIONS[2].0, chunk.acceleration)]
}

fn peak_values(peak: &PeakProfile) -> [(&'static str, &[f64]); 5] {
    [
        ("peak_displacement", &peak.displacement),
        ("peak_velocity", &peak.velocity),
        ("peak_acceleration", &peak.acceleration),
        ("peak_strain", &peak.strain),
        ("peak_stress", &peak.stress),
    ]
}

fn define_depth(
    file: &mut OutputFile,
    name: &str,
    dimension: &str,
    depth: &[f64],
    is_axis: bool,
) -> Result<(), OutputError> {
    let mut attributes = vec![
        ("standard_name", "depth"),
        ("long_name", "depth below the ground surface"),
        ("units", "m"),
        ("positive", "down"),
    ];
    if is_axis {
        attributes.push(("axis", "Z"));
    }
    file.variable::<f64>(name, &[dimension], Storage::PLAIN, &attributes)?;
    file.put_all(name, depth)
}

fn define_peaks(file: &mut OutputFile, axes: &[usize]) -> Result<(), OutputError> {
    for &axis in axes {
        let (strain, stress) = if axis == 2 {
            ("axial strain", "axial stress")
        } else {
            ("engineering shear strain", "shear stress")
        };
        let lines = [
            ("displacement", "displacement relative to the base", "m"),
            ("velocity", "velocity", "m s-1"),
            ("acceleration", "acceleration", "m s-2"),
            ("strain", strain, "1"),
            ("stress", stress, "Pa"),
        ];
        for (name, words, units) in lines {
            file.variable::<f64>(
                &format!("peak_{name}_{}", AXES[axis]),
                &["profile"],
                Storage::PLAIN,
                &[
                    ("long_name", &format!("largest absolute {words} over the run, {}", axis_words(axis))),
                    ("units", units),
                    ("coordinates", "profile_depth"),
                ],
            )?;
        }
    }
    Ok(())
}
