//! A structure: nodes, elements in named groups, supports and constraints.

use crate::{
    FemError,
    constraint::{Component, Freedom, Numbering, Reduction, Relation},
    element::Element,
};
use nalgebra::{Matrix3, Vector3};

/// Dependent freedoms, each with the freedoms that it follows and their coefficients.
type Rows = Vec<(Freedom, Vec<(Freedom, f64)>)>;

/// A group of elements by its number, from [`Model::group`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct GroupId(pub(crate) usize);

/// A constraint as it was asked for; it becomes relations once every node's freedoms are known.
#[derive(Debug)]
pub(crate) enum Constraint {
    Rigid { leader: usize, followers: Vec<usize> },
    Distribute { reference: usize, nodes: Vec<usize>, weights: Vec<f64> },
    Tie { dependent: usize, leader: usize, components: Vec<Component> },
    Relation { dependent: Freedom, terms: Vec<(Freedom, f64)>, constant: f64 },
}

#[derive(Debug)]
struct Support {
    node: usize,
    /// `None`: every freedom that the node has.
    components: Option<Vec<Component>>,
    name: String,
}

/// A structure. Nodes are named by their number, from 0.
///
/// A node has six freedoms where an element with rotations meets it, where it leads a rigid link, or
/// where a distributing coupling gives it a motion; else three. Solids and beams may thus share a
/// node: the beam's rotation is then carried by the beam alone, a hinge, unless a link holds it.
#[derive(Debug, Default)]
pub struct Model {
    nodes: Vec<[f64; 3]>,
    elements: Vec<Box<dyn Element>>,
    group_of: Vec<usize>,
    groups: Vec<String>,
    constraints: Vec<(String, Constraint)>,
    supports: Vec<Support>,
}

impl Model {
    /// Empty structure.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a node at `position`, m; returns its number.
    pub fn add_node(&mut self, position: [f64; 3]) -> usize {
        self.nodes.push(position);
        self.nodes.len() - 1
    }

    /// Adds nodes; returns their numbers.
    pub fn add_nodes(&mut self, positions: &[[f64; 3]]) -> Vec<usize> {
        positions.iter().map(|&x| self.add_node(x)).collect()
    }

    /// The group called `name`, made when it is new.
    pub fn group(&mut self, name: &str) -> GroupId {
        let known = self.groups.iter().position(|g| g == name);
        GroupId(known.unwrap_or_else(|| {
            self.groups.push(name.to_string());
            self.groups.len() - 1
        }))
    }

    /// Adds an element to a group; returns its number.
    pub fn add(&mut self, group: GroupId, element: impl Element + 'static) -> usize {
        self.elements.push(Box::new(element));
        self.group_of.push(group.0);
        self.elements.len() - 1
    }

    /// Supports `components` of a node: their motion is prescribed (zero, or the base's).
    pub fn support(&mut self, name: &str, node: usize, components: &[Component]) {
        self.supports.push(Support { node, components: Some(components.to_vec()), name: name.into() });
    }

    /// Supports every freedom that a node has.
    pub fn fix(&mut self, name: &str, node: usize) {
        self.supports.push(Support { node, components: None, name: name.into() });
    }

    /// Rigid link: `followers` move as one body with `leader`, $u = u_l + \theta_l \times r$,
    /// $\theta = \theta_l$ (where the follower has rotations); $r$ from leader to follower.
    pub fn rigid_link(&mut self, name: &str, leader: usize, followers: &[usize]) {
        self.constraints.push((name.into(), Constraint::Rigid { leader, followers: followers.to_vec() }));
    }

    /// Distributing coupling: the node `reference` follows the mean motion of `nodes`; they stay
    /// free to deform, and a force on the reference is spread over them.
    ///
    /// With weights $w_i$ (of sum 1), centre $x_c = \sum w_i x_i$, arms $r_i = x_i - x_c$ and
    /// $J = \sum w_i (r_i\cdot r_i I - r_i r_i^T)$: $\theta = J^{-1}\sum w_i\, r_i \times u_i$,
    /// $u = \sum w_i u_i + \theta \times (x - x_c)$. Exact for rigid motion.
    pub fn distribute(&mut self, name: &str, reference: usize, nodes: &[usize], weights: &[f64]) {
        let (nodes, weights) = (nodes.to_vec(), weights.to_vec());
        self.constraints.push((name.into(), Constraint::Distribute { reference, nodes, weights }));
    }

    /// Ties `components` of `dependent` to those of `leader`, whatever lies between them: for nodes in
    /// one place (a rigid rotation would be resisted otherwise).
    pub fn tie(&mut self, name: &str, dependent: usize, leader: usize, components: &[Component]) {
        let components = components.to_vec();
        self.constraints.push((name.into(), Constraint::Tie { dependent, leader, components }));
    }

    /// General linear constraint $u_d = \sum_i c_i u_i + c$.
    pub fn relation(&mut self, name: &str, dependent: Freedom, terms: &[(Freedom, f64)], constant: f64) {
        let terms = terms.to_vec();
        self.constraints.push((name.into(), Constraint::Relation { dependent, terms, constant }));
    }

    /// Positions of the nodes, m.
    pub fn nodes(&self) -> &[[f64; 3]] {
        &self.nodes
    }

    /// Elements in their order.
    pub fn elements(&self) -> &[Box<dyn Element>] {
        &self.elements
    }

    /// Names of the groups.
    pub fn groups(&self) -> &[String] {
        &self.groups
    }

    /// Group of an element.
    pub fn group_of(&self, element: usize) -> GroupId {
        GroupId(self.group_of[element])
    }

    pub(crate) fn constraints(&self) -> &[(String, Constraint)] {
        &self.constraints
    }

    /// Freedoms of every node. Errors: a node that is not there; a position not finite.
    pub fn numbering(&self) -> Result<Numbering, FemError> {
        self.check_nodes()?;
        let mut counts = vec![3; self.nodes.len()];
        for element in &self.elements {
            for &node in element.nodes() {
                counts[node] = element.freedoms_per_node().max(counts[node]);
            }
        }
        for (_, constraint) in &self.constraints {
            match constraint {
                Constraint::Rigid { leader: node, .. } | Constraint::Distribute { reference: node, .. } => {
                    counts[*node] = 6;
                }
                Constraint::Tie { .. } | Constraint::Relation { .. } => {}
            }
        }
        Ok(Numbering::new(counts))
    }

    fn check_nodes(&self) -> Result<(), FemError> {
        if let Some(node) = self.nodes.iter().position(|x| x.iter().any(|v| !v.is_finite())) {
            return Err(FemError::Coordinate { node, position: self.nodes[node] });
        }
        let count = self.nodes.len();
        let known = |item: &dyn Fn() -> String, nodes: &[usize]| match nodes.iter().find(|&&n| n >= count) {
            Some(&node) => Err(FemError::UnknownNode { item: item(), node, count }),
            None => Ok(()),
        };
        for (i, element) in self.elements.iter().enumerate() {
            let item = || format!("{} {i} of group `{}`", element.kind(), self.groups[self.group_of[i]]);
            known(&item, element.nodes())?;
        }
        for support in &self.supports {
            known(&|| format!("support `{}`", support.name), &[support.node])?;
        }
        for (name, constraint) in &self.constraints {
            known(&|| format!("constraint `{name}`"), &constraint.nodes())?;
        }
        Ok(())
    }

    /// The constraints as relations.
    pub(crate) fn relations(&self, numbering: &Numbering) -> Result<Vec<Relation>, FemError> {
        let mut relations = vec![];
        for (name, constraint) in &self.constraints {
            let mut push = |dependent, mut terms: Vec<(Freedom, f64)>, constant: f64| {
                terms.retain(|&(_, c)| c != 0.0);
                if !(constant.is_finite() && terms.iter().all(|(_, c)| c.is_finite())) {
                    let what = "its coefficients must be finite";
                    return Err(FemError::Constraint { name: name.clone(), what });
                }
                relations.push(Relation { dependent, terms, constant, name: name.clone() });
                Ok(())
            };
            match constraint {
                Constraint::Relation { dependent, terms, constant } => {
                    push(*dependent, terms.clone(), *constant)?;
                }
                Constraint::Tie { dependent, leader, components } => {
                    for &c in components {
                        push(Freedom::new(*dependent, c), vec![(Freedom::new(*leader, c), 1.0)], 0.0)?;
                    }
                }
                Constraint::Rigid { leader, followers } => {
                    for &follower in followers {
                        let arm = self.arm(*leader, follower);
                        for (dependent, terms) in
                            rigid_terms(*leader, follower, arm, numbering.count(follower))
                        {
                            push(dependent, terms, 0.0)?;
                        }
                    }
                }
                Constraint::Distribute { reference, nodes, weights } => {
                    for (dependent, terms) in self.distribute_terms(name, *reference, nodes, weights)? {
                        push(dependent, terms, 0.0)?;
                    }
                }
            }
        }
        Ok(relations)
    }

    /// The reduction $u = T q + S s + g$ by supports and constraints. Errors: those of
    /// [`Reduction::new`], nodes that are not there, a coupling that spans no rotation.
    pub fn reduction(&self, numbering: &Numbering) -> Result<Reduction, FemError> {
        let mut supports = vec![];
        for support in &self.supports {
            let all = &Component::ALL[..numbering.count(support.node)];
            for &component in support.components.as_deref().unwrap_or(all) {
                supports.push((Freedom::new(support.node, component), support.name.clone()));
            }
        }
        Reduction::new(numbering, &self.relations(numbering)?, &supports)
    }

    fn arm(&self, from: usize, to: usize) -> Vector3<f64> {
        Vector3::from(self.nodes[to]) - Vector3::from(self.nodes[from])
    }

    fn distribute_terms(
        &self,
        name: &str,
        reference: usize,
        nodes: &[usize],
        weights: &[f64],
    ) -> Result<Rows, FemError> {
        let total: f64 = weights.iter().sum();
        let usable = total > 0.0 && total.is_finite() && weights.iter().all(|&w| w >= 0.0);
        if weights.len() != nodes.len() || !usable {
            let what = "it needs one weight of 0 or more a node, not all 0";
            return Err(FemError::Constraint { name: name.into(), what });
        }
        let position = |node: usize| Vector3::from(self.nodes[node]);
        let centre: Vector3<f64> = nodes.iter().zip(weights).map(|(&n, w)| position(n) * (w / total)).sum();
        let arms: Vec<Vector3<f64>> = nodes.iter().map(|&n| position(n) - centre).collect();
        let spread: Matrix3<f64> = arms
            .iter()
            .zip(weights)
            .map(|(r, w)| (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * (w / total))
            .sum();
        let size = spread.trace();
        let spans = size > 0.0 && spread.symmetric_eigenvalues().min() > 1e-10 * size;
        let Some(inverse) = spread.try_inverse().filter(|_| spans) else {
            return Err(FemError::Coupling { name: name.into(), nodes: nodes.to_vec() });
        };
        let lever = position(reference) - centre;
        let mut terms = vec![vec![]; 6];
        for ((&node, r), weight) in nodes.iter().zip(&arms).zip(weights) {
            // θ by u_i, and u by u_i: θ × lever = -[lever]× θ
            let rotation = inverse * r.cross_matrix() * (weight / total);
            let translation = Matrix3::identity() * (weight / total) - lever.cross_matrix() * rotation;
            for i in 0..3 {
                for (j, &component) in Component::TRANSLATIONS.iter().enumerate() {
                    let freedom = Freedom::new(node, component);
                    terms[i].push((freedom, translation[(i, j)]));
                    terms[i + 3].push((freedom, rotation[(i, j)]));
                }
            }
        }
        let freedoms = Component::ALL.map(|c| Freedom::new(reference, c));
        Ok(freedoms.into_iter().zip(terms).collect())
    }
}

fn rigid_terms(leader: usize, follower: usize, arm: Vector3<f64>, count: usize) -> Rows {
    let turn = -arm.cross_matrix();
    let mut rows = vec![];
    for (i, &component) in Component::ALL[..count].iter().enumerate() {
        let mut terms = vec![(Freedom::new(leader, component), 1.0)];
        if i < 3 {
            terms.extend((0..3).map(|j| (Freedom::new(leader, Component::ALL[j + 3]), turn[(i, j)])));
        }
        rows.push((Freedom::new(follower, component), terms));
    }
    rows
}

impl Constraint {
    /// Nodes that the constraint joins.
    pub(crate) fn nodes(&self) -> Vec<usize> {
        match self {
            Self::Rigid { leader, followers } => [&[*leader], &followers[..]].concat(),
            Self::Distribute { reference, nodes, .. } => [&[*reference], &nodes[..]].concat(),
            Self::Tie { dependent, leader, .. } => vec![*dependent, *leader],
            Self::Relation { dependent, terms, .. } => {
                [dependent.node].into_iter().chain(terms.iter().map(|(f, _)| f.node)).collect()
            }
        }
    }
}
