//! Exact constraints by elimination: $u = T q + S s + g$.
//!
//! `u` holds every freedom, `q` the free ones, `s` the supported ones (their prescribed motion), `g`
//! constants. No penalty stands anywhere: forces of constraint do no work on $q$.

use crate::FemError;
use std::fmt;

/// One of the six freedoms of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Component {
    /// Translation along x.
    X,
    /// Translation along y.
    Y,
    /// Translation along z.
    Z,
    /// Rotation about x.
    RotationX,
    /// Rotation about y.
    RotationY,
    /// Rotation about z.
    RotationZ,
}

impl Component {
    /// All six, in the order of the freedoms.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::RotationX, Self::RotationY, Self::RotationZ];
    /// The three translations.
    pub const TRANSLATIONS: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Place among the freedoms of a node.
    pub fn index(self) -> usize {
        self as usize
    }
}

impl fmt::Display for Component {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(["u_x", "u_y", "u_z", "θ_x", "θ_y", "θ_z"][self.index()])
    }
}

/// A freedom: a component of the motion of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Freedom {
    /// Node.
    pub node: usize,
    /// Component.
    pub component: Component,
}

impl Freedom {
    /// Freedom `component` of `node`.
    pub fn new(node: usize, component: Component) -> Self {
        Self { node, component }
    }
}

impl fmt::Display for Freedom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "node {} {}", self.node, self.component)
    }
}

/// Freedoms of all nodes, one after the other: 3 or 6 a node.
#[derive(Debug, Clone, PartialEq)]
pub struct Numbering {
    start: Vec<usize>,
}

impl Numbering {
    /// Numbering of nodes that have `counts` freedoms each.
    pub fn new(counts: impl IntoIterator<Item = usize>) -> Self {
        let mut start = vec![0];
        for count in counts {
            start.push(start[start.len() - 1] + count);
        }
        Self { start }
    }

    /// Number of freedoms.
    pub fn size(&self) -> usize {
        self.start[self.start.len() - 1]
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.start.len() - 1
    }

    /// Place of a node's first freedom.
    pub fn start(&self, node: usize) -> usize {
        self.start[node]
    }

    /// Number of freedoms of a node.
    pub fn count(&self, node: usize) -> usize {
        self.start[node + 1] - self.start[node]
    }

    /// Place of a freedom; `None` where the node has no such one.
    pub fn place(&self, freedom: Freedom) -> Option<usize> {
        let index = freedom.component.index();
        (freedom.node < self.nodes() && index < self.count(freedom.node))
            .then(|| self.start[freedom.node] + index)
    }

    /// The freedom at a place.
    pub fn freedom(&self, place: usize) -> Freedom {
        let node = self.start.partition_point(|&s| s <= place) - 1;
        Freedom::new(node, Component::ALL[place - self.start[node]])
    }
}

/// One dependent freedom: $u_d = \sum_i c_i u_i + c$.
#[derive(Debug, Clone, PartialEq)]
pub struct Relation {
    /// Freedom that is eliminated.
    pub dependent: Freedom,
    /// Freedoms that it follows, with their coefficients.
    pub terms: Vec<(Freedom, f64)>,
    /// Constant, m or rad.
    pub constant: f64,
    /// Name for messages.
    pub name: String,
}

/// The reduction $u = T q + S s + g$ of a model.
///
/// Columns below [`Reduction::free`] are those of $q$, the others those of $s$.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    start: Vec<usize>,
    column: Vec<usize>,
    coefficient: Vec<f64>,
    constant: Vec<f64>,
    freedoms: Vec<Freedom>,
    supports: Vec<Freedom>,
}

impl Reduction {
    /// Reduction of the freedoms of `numbering` by `relations`, with `supports` prescribed.
    ///
    /// Chains are followed to their end, whatever the order of the relations. Errors: a freedom that
    /// does not exist, is bound twice, or follows itself through a ring.
    pub fn new(
        numbering: &Numbering,
        relations: &[Relation],
        supports: &[(Freedom, String)],
    ) -> Result<Self, FemError> {
        let bound = bind(numbering, relations, supports)?;
        let rows =
            Resolver { numbering, relations, bound: &bound, rows: vec![None; numbering.size()] }.all()?;
        let mut column_of = vec![usize::MAX; numbering.size()];
        let (mut freedoms, mut supported) = (vec![], vec![]);
        for place in 0..numbering.size() {
            if bound[place] == Binding::Free {
                column_of[place] = freedoms.len();
                freedoms.push(numbering.freedom(place));
            }
        }
        for place in 0..numbering.size() {
            if matches!(bound[place], Binding::Support(_)) {
                column_of[place] = freedoms.len() + supported.len();
                supported.push(numbering.freedom(place));
            }
        }
        let mut reduction = Self {
            start: vec![0],
            column: vec![],
            coefficient: vec![],
            constant: vec![],
            freedoms,
            supports: supported,
        };
        for row in rows {
            for (place, coefficient) in row.terms {
                reduction.column.push(column_of[place]);
                reduction.coefficient.push(coefficient);
            }
            reduction.start.push(reduction.column.len());
            reduction.constant.push(row.constant);
        }
        Ok(reduction)
    }

    /// Number of all freedoms.
    pub fn full(&self) -> usize {
        self.constant.len()
    }

    /// Number of free freedoms, the length of $q$.
    pub fn free(&self) -> usize {
        self.freedoms.len()
    }

    /// The free freedoms in their order; those of one node stand together.
    pub fn freedoms(&self) -> &[Freedom] {
        &self.freedoms
    }

    /// The supported freedoms, in the order of $s$.
    pub fn supports(&self) -> &[Freedom] {
        &self.supports
    }

    /// Node of each free freedom: the graph of nodes orders a factor better than that of freedoms.
    pub fn node_groups(&self) -> Vec<u32> {
        // more nodes than 2³² fit into no memory
        self.freedoms.iter().map(|f| u32::try_from(f.node).unwrap_or(u32::MAX)).collect()
    }

    /// Constants $g$.
    pub fn constants(&self) -> &[f64] {
        &self.constant
    }

    /// Columns and coefficients of a row of $(T\;S)$.
    pub fn row(&self, place: usize) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        let range = self.start[place]..self.start[place + 1];
        self.column[range.clone()].iter().copied().zip(self.coefficient[range].iter().copied())
    }

    /// $u = T q + S s + g$. Errors: lengths that do not fit.
    pub fn expand(&self, free: &[f64], support: &[f64]) -> Result<Vec<f64>, FemError> {
        let mut u = self.expand_linear(free, support)?;
        for (value, constant) in u.iter_mut().zip(&self.constant) {
            *value += constant;
        }
        Ok(u)
    }

    /// $T q + S s$ without the constants: for velocities, accelerations and modes.
    pub fn expand_linear(&self, free: &[f64], support: &[f64]) -> Result<Vec<f64>, FemError> {
        fits("free motion", free.len(), self.free())?;
        fits("motion of supports", support.len(), self.supports.len())?;
        let value = |k: usize| if k < free.len() { free[k] } else { support[k - free.len()] };
        Ok((0..self.full()).map(|place| self.row(place).map(|(k, c)| c * value(k)).sum()).collect())
    }

    /// $(T^T f, S^T f)$ of a load on all freedoms. Errors: a length that does not fit.
    pub fn reduce(&self, load: &[f64]) -> Result<(Vec<f64>, Vec<f64>), FemError> {
        fits("load", load.len(), self.full())?;
        let mut reduced = vec![0.0; self.free() + self.supports.len()];
        for (place, force) in load.iter().enumerate() {
            for (k, c) in self.row(place) {
                reduced[k] += c * force;
            }
        }
        let support = reduced.split_off(self.free());
        Ok((reduced, support))
    }
}

pub(crate) fn fits(what: &'static str, found: usize, expected: usize) -> Result<(), FemError> {
    if found == expected { Ok(()) } else { Err(FemError::Length { what, found, expected }) }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Binding {
    Free,
    Support(usize),
    Relation(usize),
}

fn bind(
    numbering: &Numbering,
    relations: &[Relation],
    supports: &[(Freedom, String)],
) -> Result<Vec<Binding>, FemError> {
    let mut bound = vec![Binding::Free; numbering.size()];
    let name = |binding: Binding| match binding {
        Binding::Free => String::new(),
        Binding::Support(i) => supports[i].1.clone(),
        Binding::Relation(i) => relations[i].name.clone(),
    };
    let all = supports.iter().enumerate().map(|(i, s)| (s.0, Binding::Support(i)));
    let all = all.chain(relations.iter().enumerate().map(|(i, r)| (r.dependent, Binding::Relation(i))));
    for (freedom, binding) in all {
        let place = place_of(numbering, freedom, &name(binding))?;
        if bound[place] != Binding::Free {
            return Err(FemError::Overdetermined {
                freedom,
                first: name(bound[place]),
                second: name(binding),
            });
        }
        bound[place] = binding;
    }
    Ok(bound)
}

fn place_of(numbering: &Numbering, freedom: Freedom, name: &str) -> Result<usize, FemError> {
    if freedom.node >= numbering.nodes() {
        let count = numbering.nodes();
        return Err(FemError::UnknownNode {
            item: format!("constraint `{name}`"),
            node: freedom.node,
            count,
        });
    }
    let item = || format!("constraint `{name}`");
    numbering.place(freedom).ok_or_else(|| FemError::NoRotation { item: item(), freedom })
}

/// A row of (T S g) over the places of free and supported freedoms.
#[derive(Debug, Clone)]
struct Row {
    terms: Vec<(usize, f64)>,
    constant: f64,
}

struct Resolver<'a> {
    numbering: &'a Numbering,
    relations: &'a [Relation],
    bound: &'a [Binding],
    rows: Vec<Option<Row>>,
}

impl Resolver<'_> {
    fn all(mut self) -> Result<Vec<Row>, FemError> {
        for place in 0..self.bound.len() {
            self.resolve(place)?;
        }
        Ok(self.rows.into_iter().flatten().collect())
    }

    /// Follows a freedom down to those that nothing binds; a walk with its own stack, since a chain
    /// may be as long as the model.
    fn resolve(&mut self, place: usize) -> Result<(), FemError> {
        let mut path = vec![place];
        while let Some(&top) = path.last() {
            if self.rows[top].is_some() {
                path.pop();
                continue;
            }
            let Binding::Relation(index) = self.bound[top] else {
                self.rows[top] = Some(Row { terms: vec![(top, 1.0)], constant: 0.0 });
                path.pop();
                continue;
            };
            let relation = &self.relations[index];
            let mut places = vec![];
            for &(freedom, coefficient) in &relation.terms {
                places.push((place_of(self.numbering, freedom, &relation.name)?, coefficient));
            }
            match places.iter().find(|(p, _)| self.rows[*p].is_none()) {
                None => {
                    self.rows[top] = Some(self.combine(&places, relation.constant));
                    path.pop();
                }
                Some(&(next, _)) => {
                    if let Some(first) = path.iter().position(|&p| p == next) {
                        let chain = path[first..].iter().chain([&next]);
                        return Err(FemError::Cycle {
                            chain: chain.map(|&p| self.numbering.freedom(p)).collect(),
                        });
                    }
                    path.push(next);
                }
            }
        }
        Ok(())
    }

    fn combine(&self, places: &[(usize, f64)], constant: f64) -> Row {
        let mut row = Row { terms: vec![], constant };
        for &(place, coefficient) in places {
            let Some(source) = &self.rows[place] else { continue };
            row.constant += coefficient * source.constant;
            row.terms.extend(source.terms.iter().map(|&(p, c)| (p, c * coefficient)));
        }
        row.terms.sort_by_key(|&(p, _)| p);
        row.terms.dedup_by(|later, first| {
            let same = later.0 == first.0;
            if same {
                first.1 += later.1;
            }
            same
        });
        row.terms.retain(|&(_, c)| c != 0.0);
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn free(node: usize) -> Freedom {
        Freedom::new(node, Component::X)
    }

    fn relation(dependent: usize, terms: &[(usize, f64)], constant: f64) -> Relation {
        let terms = terms.iter().map(|&(n, c)| (free(n), c)).collect();
        Relation { dependent: free(dependent), terms, constant, name: format!("r{dependent}") }
    }

    #[test]
    fn a_chain_is_followed_to_its_end_in_any_order() {
        let numbering = Numbering::new([3; 4]);
        // u0 = 2 u1 + 1, u1 = 3 u2 - u3 + 2, u3 supported
        let relations = [relation(0, &[(1, 2.0)], 1.0), relation(1, &[(2, 3.0), (3, -1.0)], 2.0)];
        let supports = [(free(3), "base".to_string())];
        for order in [[0, 1], [1, 0]] {
            let list = order.map(|i| relations[i].clone());
            let reduction = Reduction::new(&numbering, &list, &supports).unwrap();
            assert_eq!(reduction.free(), 9);
            let mut q = vec![0.0; 9];
            let at = reduction.freedoms().iter().position(|f| *f == free(2)).unwrap();
            q[at] = 5.0;
            let u = reduction.expand(&q, &[7.0]).unwrap();
            assert_eq!((u[0], u[3], u[6], u[9]), (2.0 * (15.0 - 7.0 + 2.0) + 1.0, 10.0, 5.0, 7.0));
        }
    }

    #[test]
    fn a_ring_is_refused_and_named() {
        let relations =
            [relation(0, &[(1, 1.0)], 0.0), relation(1, &[(2, 1.0)], 0.0), relation(2, &[(0, 1.0)], 0.0)];
        let error = Reduction::new(&Numbering::new([3; 3]), &relations, &[]).unwrap_err();
        assert_eq!(error, FemError::Cycle { chain: vec![free(0), free(1), free(2), free(0)] });
        assert!(error.to_string().contains("node 0 u_x ← node 1 u_x ← node 2 u_x ← node 0 u_x"));
    }

    #[test]
    fn a_freedom_bound_twice_is_refused_and_named() {
        let relations = [relation(0, &[(1, 1.0)], 0.0)];
        let supports = [(free(0), "foot".to_string())];
        let error = Reduction::new(&Numbering::new([3; 2]), &relations, &supports).unwrap_err();
        let first = "foot".to_string();
        assert_eq!(error, FemError::Overdetermined { freedom: free(0), first, second: "r0".into() });
    }

    #[test]
    fn rotations_that_are_not_there_and_unknown_nodes_are_refused() {
        let numbering = Numbering::new([3, 6]);
        let rotation = |node| vec![(Freedom::new(node, Component::RotationY), "s".to_string())];
        assert!(matches!(Reduction::new(&numbering, &[], &rotation(0)), Err(FemError::NoRotation { .. })));
        assert!(Reduction::new(&numbering, &[], &rotation(1)).is_ok());
        assert!(matches!(Reduction::new(&numbering, &[], &rotation(2)), Err(FemError::UnknownNode { .. })));
    }

    #[test]
    fn reduce_is_the_transpose_of_expand() {
        let relations = [relation(0, &[(1, 2.0), (2, -0.5)], 0.0)];
        let supports = [(free(2), "base".to_string())];
        let reduction = Reduction::new(&Numbering::new([3; 3]), &relations, &supports).unwrap();
        let q: Vec<f64> = (0..reduction.free()).map(|i| 1.0 + i as f64).collect();
        let f: Vec<f64> = (0..9).map(|i| (i as f64).sin()).collect();
        let u = reduction.expand_linear(&q, &[3.0]).unwrap();
        let (fq, fs) = reduction.reduce(&f).unwrap();
        let work: f64 = u.iter().zip(&f).map(|(a, b)| a * b).sum();
        let reduced: f64 = q.iter().zip(&fq).map(|(a, b)| a * b).sum::<f64>() + 3.0 * fs[0];
        assert!((work - reduced).abs() < 1e-13);
    }
}
