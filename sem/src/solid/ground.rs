//! What a solid consists of, before precision, step and order in memory are chosen.

use super::geometry::point;
use super::held::{BoundaryPlane, Held};
use super::material::Material;
use super::memory::{Distribution, Memory, PointLaw};
use crate::SemError;
use crate::gll::Gll;
use crate::mesh::{Locator, Mesh, Side, determinant, inverse};
use crate::numbering::Numbering;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What holds a boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Support {
    /// Nothing: no traction.
    Free,
    /// Displacement is zero.
    Fixed,
    /// Displacement across the boundary is zero, tractions along it are: a plane of symmetry.
    Symmetry,
    /// Displacement along the boundary is zero, traction across it is: a plane of antisymmetry, as for a double
    /// couple $M_{xy}$ on the planes x = 0 and y = 0. For plane boundaries: where sides of different
    /// directions meet, all components are held.
    Antisymmetry,
    /// Dashpots $\rho v_p$ across and $\rho v_s$ along the boundary (Lysmer & Kuhlemeyer 1969): exact for
    /// plane waves that leave at right angles; a few per cent come back at 45°, all of it at grazing angles.
    Absorbing,
}

/// Forces at points that share one time function: $f_i(t) = w_i\,a(t)$.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// Point and force per unit amplitude.
    pub forces: Vec<(u32, [f64; 3])>,
    /// Amplitude at the kicks, $t = n\Delta t$; zero afterwards. Loads of one time function share it.
    pub amplitude: Arc<Vec<f64>>,
}

/// A place where the field is looked at: the element's interpolation there.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// Element that holds it.
    pub element: usize,
    /// Local coordinates.
    pub local: [f64; 3],
    /// Where it truly lies, m.
    pub position: [f64; 3],
    /// Points and weights.
    pub weights: Vec<(u32, f64)>,
}

/// Mesh, materials, supports and loads of a solid, D = 2 or 3.
#[derive(Debug, Clone)]
pub struct Ground {
    mesh: Mesh,
    gll: Gll,
    numbering: Numbering,
    materials: Vec<Material>,
    pub(super) distribution: Distribution,
    mass: Vec<f64>,
    pub(super) held: BTreeMap<u32, Held>,
    pub(super) loads: Vec<Load>,
    pub(super) interfaces: Vec<Vec<u32>>,
}

impl Ground {
    /// Assembles a mesh at a polynomial order; `materials` are found by their names in the mesh.
    ///
    /// Errors: an order out of 1–10, a material missing or out of range. The mesh is taken to be valid
    /// ([`crate::mesh::check`]).
    pub fn new(mesh: Mesh, order: usize, materials: &[Material]) -> Result<Self, SemError> {
        let gll = Gll::new(order)?;
        let materials = (mesh.materials.iter())
            .map(|name| {
                let known = || materials.iter().map(|m| m.name.clone()).collect();
                let found = materials.iter().find(|m| m.name == *name);
                found.cloned().ok_or_else(|| SemError::UnknownMaterial { name: name.clone(), known: known() })
            })
            .collect::<Result<Vec<_>, _>>()?;
        materials.iter().try_for_each(Material::check)?;
        let numbering = Numbering::new(&mesh, order);
        let mut mass = vec![0.0; numbering.nodes];
        for e in 0..mesh.len() {
            let rho = materials[mesh.material[e] as usize].rho;
            for (p, &node) in numbering.element(e).iter().enumerate() {
                let (local, w) = point(&gll, mesh.dimension, p);
                mass[node as usize] += rho * w * determinant(&mesh.jacobian(e, local));
            }
        }
        let (held, loads, interfaces) = (BTreeMap::new(), vec![], vec![]);
        let distribution = Distribution::full(&materials, numbering.points);
        Ok(Self { mesh, gll, numbering, materials, distribution, mass, held, loads, interfaces })
    }

    /// Spreads the memory variables over the points; [`Memory::Full`] unless this is called.
    ///
    /// Errors: of [`Memory::Coarse`], an order of too few points for the mechanisms, and a damping so strong that
    /// points would lose their relaxed stiffness.
    pub fn set_memory(&mut self, memory: Memory) -> Result<(), SemError> {
        self.distribution = match memory {
            Memory::Full => Distribution::full(&self.materials, self.numbering.points),
            Memory::Coarse => Distribution::coarse(&self.materials, &self.gll, self.mesh.dimension)?,
        };
        Ok(())
    }

    /// How the memory variables are spread.
    pub fn memory(&self) -> Memory {
        self.distribution.memory
    }

    /// Law of a local point of an element.
    pub fn law(&self, element: usize, point: usize) -> &PointLaw {
        let class = usize::from(self.distribution.class[point]);
        &self.distribution.laws[self.mesh.material[element] as usize][class]
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The rule of the polynomial order.
    pub fn gll(&self) -> &Gll {
        &self.gll
    }

    /// Points of the elements.
    pub fn numbering(&self) -> &Numbering {
        &self.numbering
    }

    /// Materials in the order of the mesh.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Material of an element.
    pub fn material(&self, element: usize) -> &Material {
        &self.materials[self.mesh.material[element] as usize]
    }

    /// Lumped mass of every point, kg (kg/m at D = 2).
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// Position of every point, m. Cost: one map per point of an element.
    pub fn positions(&self) -> Vec<[f64; 3]> {
        let mut positions = vec![[0.0; 3]; self.numbering.nodes];
        for e in 0..self.mesh.len() {
            for (p, &node) in self.numbering.element(e).iter().enumerate() {
                let (local, _) = point(&self.gll, self.mesh.dimension, p);
                positions[node as usize] = self.mesh.position(e, local);
            }
        }
        positions
    }

    /// Holds a boundary. At points of several boundaries all supports act; [`Support::Free`] adds nothing.
    ///
    /// A plane of symmetry or antisymmetry has one normal, the mean of its sides' ([`Self::boundary_plane`]), where
    /// theirs differ by no more than [`super::FLAT`]: round-off in coordinates is no second direction to hold.
    ///
    /// Errors: no boundary of that name.
    pub fn support(&mut self, boundary: &str, support: Support) -> Result<(), SemError> {
        let sides = self.sides(boundary)?;
        let plane = match support {
            Support::Symmetry | Support::Antisymmetry => Some(self.boundary_plane(boundary)?),
            _ => None,
        };
        let mean = plane.filter(BoundaryPlane::is_flat).map(|p| p.normal);
        for side in sides {
            let material = self.material(side.element as usize).clone();
            for (node, area) in self.side_areas(side) {
                let size = norm(area);
                let n = mean.unwrap_or_else(|| area.map(|a| a / size));
                let held = match support {
                    Support::Free => continue,
                    _ => self.held.entry(node).or_default(),
                };
                match support {
                    Support::Fixed => {
                        (0..3).for_each(|c| held.hold(std::array::from_fn(|x| f64::from(x == c))));
                    }
                    Support::Symmetry => held.hold(n),
                    Support::Antisymmetry => held.hold_across(n),
                    _ => {
                        let (across, along) = (material.rho * material.vp, material.rho * material.vs);
                        for (i, row) in held.dashpot.iter_mut().enumerate() {
                            for (j, c) in row.iter_mut().enumerate() {
                                let same = if i == j { along } else { 0.0 };
                                *c += size * (same + (across - along) * n[i] * n[j]);
                            }
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Holds the components of all points without y-motion or with nothing else, and the like: `axis` of
    /// every point is fixed. For plane problems in one component.
    pub fn hold_component(&mut self, axis: usize) {
        for node in 0..self.numbering.nodes as u32 {
            self.held.entry(node).or_default().hold(std::array::from_fn(|x| f64::from(x == axis)));
        }
    }

    /// Adds a load; see [`Self::point_force`], [`Self::moment`], [`Self::traction`], [`Self::gaussian`].
    pub fn add_load(&mut self, forces: Vec<(u32, [f64; 3])>, amplitude: Vec<f64>) {
        self.add_shared_load(forces, Arc::new(amplitude));
    }

    /// Adds a load whose amplitude others may share.
    pub fn add_shared_load(&mut self, forces: Vec<(u32, [f64; 3])>, amplitude: Arc<Vec<f64>>) {
        self.loads.push(Load { forces, amplitude });
    }

    /// The loads.
    pub fn loads(&self) -> &[Load] {
        &self.loads
    }

    /// Bytes of the loads, an amplitude that several share counted once.
    pub fn load_bytes(&self) -> usize {
        let mut amplitudes: Vec<&Arc<Vec<f64>>> = self.loads.iter().map(|l| &l.amplitude).collect();
        amplitudes.sort_unstable_by_key(|a| Arc::as_ptr(a));
        amplitudes.dedup_by(|a, b| Arc::ptr_eq(a, b));
        let forces: usize = self.loads.iter().map(|l| l.forces.len()).sum();
        amplitudes.iter().map(|a| 8 * a.len()).sum::<usize>() + forces * size_of::<(u32, [f64; 3])>()
    }

    /// Adds an interface: points whose three components are its freedoms; returns its number.
    pub fn add_interface(&mut self, points: Vec<u32>) -> usize {
        self.interfaces.push(points);
        self.interfaces.len() - 1
    }

    /// A place to look at. Errors: outside of the mesh.
    pub fn probe(&self, locator: &Locator<'_>, position: [f64; 3]) -> Result<Probe, SemError> {
        let found = locator.find(position)?;
        Ok(self.probe_in(found.element, found.local))
    }

    /// The probe at local coordinates of an element.
    pub fn probe_in(&self, element: usize, local: [f64; 3]) -> Probe {
        let along = |a: usize| self.gll.interpolation(local[a]);
        let (x, y) = (along(0), along(1));
        let z = if self.mesh.dimension == 3 { along(2) } else { vec![1.0] };
        let n = self.gll.len();
        let weights = (self.numbering.element(element).iter().enumerate())
            .map(|(p, &node)| (node, x[p % n] * y[p / n % n] * z[p / (n * n)]))
            .filter(|(_, w)| *w != 0.0)
            .collect();
        Probe { element, local, position: self.mesh.position(element, local), weights }
    }

    /// Forces of a point force, N: consistent with the basis, $f_i = F\,\ell_i(\xi)$.
    pub fn point_force(
        &self,
        locator: &Locator<'_>,
        position: [f64; 3],
        force: [f64; 3],
    ) -> Result<Vec<(u32, [f64; 3])>, SemError> {
        let probe = self.probe(locator, position)?;
        Ok(probe.weights.iter().map(|&(node, w)| (node, force.map(|f| f * w))).collect())
    }

    /// Forces of a moment tensor, N·m: $f_{ic} = M_{cx}\,\partial\ell_i/\partial x$ at the place.
    ///
    /// On a face or edge the derivative is that of the element which [`Locator::find`] gives; inside an
    /// element it is smooth.
    pub fn moment(
        &self,
        locator: &Locator<'_>,
        position: [f64; 3],
        moment: [[f64; 3]; 3],
    ) -> Result<Vec<(u32, [f64; 3])>, SemError> {
        let found = locator.find(position)?;
        let gradients = self.basis_gradients(found.element, found.local);
        Ok((self.numbering.element(found.element).iter().zip(gradients))
            .map(|(&node, g)| (node, moment.map(|row| row[0] * g[0] + row[1] * g[1] + row[2] * g[2])))
            .collect())
    }

    /// Gradients $\partial\ell_i/\partial x$ of an element's basis at a local point, 1/m.
    pub fn basis_gradients(&self, element: usize, local: [f64; 3]) -> Vec<[f64; 3]> {
        let (n, d) = (self.gll.len(), self.mesh.dimension);
        let axes = crate::mesh::axes(d);
        let (jacobian, _) = inverse(&self.mesh.jacobian(element, local));
        let value: Vec<Vec<f64>> = (0..d).map(|a| self.gll.interpolation(local[a])).collect();
        let slope: Vec<Vec<f64>> = (0..d).map(|a| self.gll.interpolation_slope(local[a])).collect();
        (0..self.numbering.points)
            .map(|p| {
                let mut gradient = [0.0; 3];
                for a in 0..d {
                    let factor: f64 = (0..d)
                        .map(|b| {
                            let i = p / n.pow(b as u32) % n;
                            if a == b { slope[b][i] } else { value[b][i] }
                        })
                        .product();
                    (0..3).for_each(|x| gradient[x] += factor * jacobian[axes[a]][x]);
                }
                if d == 2 {
                    gradient[1] = 0.0;
                }
                gradient
            })
            .collect()
    }

    /// Forces of a traction field on a boundary, Pa: $f_i = \int t(x)\,\ell_i\,dA$ by the side's GLL rule.
    ///
    /// For fields that the basis resolves; one of any width is [`Self::gaussian`].
    pub fn traction(
        &self,
        boundary: &str,
        traction: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Result<Vec<(u32, [f64; 3])>, SemError> {
        let mut sum: BTreeMap<u32, [f64; 3]> = BTreeMap::new();
        for side in self.sides(boundary)? {
            let points = self.numbering.side_points(side.side);
            for ((node, area), p) in self.side_areas(side).into_iter().zip(points) {
                let (local, _) = point(&self.gll, self.mesh.dimension, p);
                let t = traction(self.mesh.position(side.element as usize, local));
                let f = sum.entry(node).or_default();
                (0..3).for_each(|c| f[c] += norm(area) * t[c]);
            }
        }
        Ok(sum.into_iter().filter(|(_, f)| *f != [0.0; 3]).collect())
    }

    pub(super) fn sides(&self, boundary: &str) -> Result<Vec<Side>, SemError> {
        let known = || self.mesh.boundaries.iter().map(|b| b.name.clone()).collect();
        let found = self.mesh.boundary(boundary);
        let found = found.ok_or_else(|| SemError::NoBoundary { name: boundary.into(), known: known() })?;
        Ok(found.sides.clone())
    }

    /// Points of a boundary, each once, in the order of the numbering.
    pub fn boundary_points(&self, boundary: &str) -> Result<Vec<u32>, SemError> {
        let mut points: Vec<u32> = (self.sides(boundary)?.into_iter())
            .flat_map(|s| {
                let element = self.numbering.element(s.element as usize);
                self.numbering.side_points(s.side).into_iter().map(|p| element[p])
            })
            .collect();
        points.sort_unstable();
        points.dedup();
        Ok(points)
    }

    /// Local coordinates of a side's points, in the order of [`Self::side_areas`].
    pub(super) fn side_locals(&self, side: Side) -> Vec<[f64; 3]> {
        let points = self.numbering.side_points(side.side);
        points.into_iter().map(|p| point(&self.gll, self.mesh.dimension, p).0).collect()
    }

    /// Points of a side with their outward area vectors, quadrature weight included, m² (m at D = 2).
    pub fn side_areas(&self, side: Side) -> Vec<(u32, [f64; 3])> {
        let (d, e) = (self.mesh.dimension, side.element as usize);
        let (axis, sign) = (usize::from(side.side / 2), if side.side % 2 == 1 { 1.0 } else { -1.0 });
        let nodes = self.numbering.element(e);
        (self.numbering.side_points(side.side).into_iter())
            .map(|p| {
                let (local, w) = point(&self.gll, d, p);
                let i = p / self.gll.len().pow(axis as u32) % self.gll.len();
                let j = self.mesh.jacobian(e, local);
                let (inverse, det) = inverse(&j);
                // Nanson: n dA = |J| J⁻ᵀ N dA₀, without the weight across the side
                let scale = sign * det * w / self.gll.weights[i];
                let row = inverse[crate::mesh::axes(d)[axis]];
                let mut area = row.map(|x| scale * x);
                if d == 2 {
                    area[1] = 0.0;
                }
                (nodes[p], area)
            })
            .collect()
    }

    /// Points that loads, supports, dashpots or interfaces act on.
    pub(super) fn special(&self) -> Vec<bool> {
        let mut special = vec![false; self.numbering.nodes];
        let loaded = self.loads.iter().flat_map(|l| l.forces.iter().map(|f| f.0));
        let joined = self.interfaces.iter().flatten().copied();
        self.held.keys().copied().chain(loaded).chain(joined).for_each(|p| special[p as usize] = true);
        special
    }

    /// Estimate of an element's highest frequency, rad/s, up to a factor common to all elements of an
    /// order: $v_p^\infty\max_p(\sum_a|\nabla\xi_a|^2)^{1/2}$, with the unrelaxed
    /// speed of its stiffest point.
    pub fn rate(&self, element: usize) -> f64 {
        let d = self.mesh.dimension;
        let axes = crate::mesh::axes(d);
        let steep = (0..self.numbering.points)
            .map(|p| {
                let (inverse, _) = inverse(&self.mesh.jacobian(element, point(&self.gll, d, p).0));
                axes.iter().map(|a| norm(inverse[*a]).powi(2)).sum::<f64>()
            })
            .fold(0.0, f64::max);
        let material = self.mesh.material[element] as usize;
        let stiffest = self.distribution.laws[material].iter().map(|law| {
            let (lambda, mu) = law.unrelaxed();
            lambda + 2.0 * mu
        });
        (stiffest.fold(0.0, f64::max) / self.materials[material].rho * steep).sqrt()
    }

    /// The element whose size and speed bound the step.
    pub fn limiting_element(&self) -> usize {
        let rates: Vec<f64> = (0..self.mesh.len()).map(|e| self.rate(e)).collect();
        (0..rates.len()).max_by(|&a, &b| rates[a].total_cmp(&rates[b])).unwrap_or(0)
    }
}

fn norm(x: [f64; 3]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}
