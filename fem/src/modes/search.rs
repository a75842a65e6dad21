//! The search: how far the iteration goes, and the count at its end.

use super::lanczos::{Lanczos, Ritz};
use super::pencil::Pencil;
use super::{Modes, Search, Wanted, frequency};
use crate::FemError;
use crate::sparse::{Factor, SymmetricMatrix};
use faer::{MatRef, Side};
use std::f64::consts::PI;

/// Two neighbours further apart than this share of $\lambda - \sigma$ leave room for a count between them.
const GAP: f64 = 1e-5;

/// Ratio of eigenvalues above which round-off, $10^{-16}$ of the largest $\theta$, takes too many digits of the
/// higher modes.
const REACH: f64 = 1e7;

/// Searches for modes that the count shows to be missed.
const SEARCHES: usize = 5;

pub(super) fn run(
    stiffness: &SymmetricMatrix,
    mass: &SymmetricMatrix,
    groups: &[u32],
    wanted: Wanted,
    search: Search,
) -> Result<Modes, FemError> {
    let mut pencil = Pencil::new(stiffness, mass, groups, search.threads)?;
    match wanted {
        Wanted::Lowest(count) => lowest(&mut pencil, count, None, search),
        Wanted::Band { from, to } => {
            if !(from >= 0.0 && to > from && to.is_finite()) {
                return Err(FemError::Band { from, to });
            }
            let [low, high] = [from, to].map(|f| (2.0 * PI * f).powi(2));
            let (high, above) = count_near(&mut pencil, high, 1.0)?;
            if from == 0.0 {
                return lowest(&mut pencil, above, Some(high), search);
            }
            let (low, below) = count_near(&mut pencil, low, -1.0)?;
            within(&mut pencil, (low, high), above - below, search)
        }
    }
}

/// Count at a shift, or just beside it where the shift lies on an eigenvalue.
fn count_near(pencil: &mut Pencil, shift: f64, side: f64) -> Result<(f64, usize), FemError> {
    let mut moved = shift;
    let mut step = 1e-9 * side;
    loop {
        match pencil.count(moved) {
            Err(FemError::Unstable { .. } | FemError::Pivot { .. }) if step.abs() < 1e-5 => {
                moved = shift * (1.0 + step);
                step *= 4.0;
            }
            other => return Ok((moved, other?)),
        }
    }
}

/// The `count` lowest modes; `known` is a shift below which there are just so many.
fn lowest(pencil: &mut Pencil, count: usize, known: Option<f64>, search: Search) -> Result<Modes, FemError> {
    if count == 0 {
        return Ok(none(pencil, known.unwrap_or(0.0)));
    }
    if count > pencil.mass.size() {
        return Err(FemError::TooManyModes { asked: count, available: pencil.mass.size() });
    }
    match lowest_from(pencil, count, known, search, false) {
        // round-off of a nearly singular stiffness hides all modes but the nearly free ones
        Err(FemError::ModesNotConverged { .. }) => lowest_from(pencil, count, known, search, true),
        Ok(modes) if modes.shift == 0.0 && modes.value[count - 1] > REACH * modes.value[0] => {
            lowest_from(pencil, count, known, search, true)
        }
        other => other,
    }
}

fn lowest_from(
    pencil: &mut Pencil,
    count: usize,
    known: Option<f64>,
    search: Search,
    free: bool,
) -> Result<Modes, FemError> {
    let (shift, mut factor) = pencil.below_all(free)?;
    let mass = pencil.mass;
    let mut lanczos = Lanczos::new(mass, &mut factor, search.block);
    let mut target = if known.is_some() { count } else { count + 1 };
    let mut searches = 0;
    loop {
        let (ritz, _) = converge(&mut lanczos, target, search.tolerance, |theta| theta.len() >= target)?;
        if lanczos.exhausted() {
            target = target.min(lanczos.done());
            if target < count {
                return Err(FemError::TooManyModes { asked: count, available: target });
            }
        }
        let value: Vec<f64> = ritz.theta[..target].iter().map(|t| shift + 1.0 / t).collect();
        let Some((at, found)) = place_of_count(&value, shift, count, known, lanczos.exhausted()) else {
            target += search.block;
            continue;
        };
        let (at, counted) = match known {
            Some(at) => (at, count),
            None => count_between(pencil, at, &value, found)?,
        };
        if counted == found {
            let solves = lanczos.solves();
            let vectors = lanczos.vectors(&ritz, found);
            drop(lanczos);
            let modes = finish(pencil, &mut factor, shift, &ritz.theta[..found], vectors, at, solves)?;
            return Ok(modes.truncated(count));
        }
        searches += 1;
        if counted < found || searches == SEARCHES || lanczos.exhausted() {
            return Err(FemError::ModeCount { counted, found, frequency: frequency(at) });
        }
        target = target.max(counted + usize::from(known.is_none()));
        stir(&mut lanczos, &ritz, search);
    }
}

/// Keeps what converged and lets the iteration begin anew beside it.
fn stir(lanczos: &mut Lanczos, ritz: &Ritz, search: Search) {
    let keep = ritz.bound.iter().take_while(|b| **b <= search.tolerance).count();
    lanczos.stir(ritz, keep);
    for _ in 0..3 {
        lanczos.step();
    }
}

/// Where to count, and how many eigenvalues were found below: in the first gap behind the `count`-th.
fn place_of_count(
    value: &[f64],
    shift: f64,
    count: usize,
    known: Option<f64>,
    exhausted: bool,
) -> Option<(f64, usize)> {
    if let Some(at) = known {
        return Some((at, value.iter().filter(|v| **v < at).count()));
    }
    for found in count..value.len() {
        let (below, above) = (value[found - 1] - shift, value[found] - shift);
        if above - below > GAP * above {
            return Some((shift + (below * above).sqrt(), found));
        }
    }
    let last = value.last()? - shift;
    exhausted.then_some((shift + 2.0 * last, value.len()))
}

/// Count in the gap behind the `found`-th value; moved within it where the factor is not stable.
fn count_between(
    pencil: &mut Pencil,
    at: f64,
    value: &[f64],
    found: usize,
) -> Result<(f64, usize), FemError> {
    let below = value[found - 1];
    let mut result = pencil.count(at);
    for part in [0.7, 0.4, 0.9] {
        if let Err(FemError::Unstable { .. } | FemError::Pivot { .. }) = result {
            let moved = below + part * (at - below);
            if let Ok(count) = pencil.count(moved) {
                return Ok((moved, count));
            }
            result = pencil.count(moved);
        }
    }
    Ok((at, result?))
}

/// Modes of a band, around a shift in its middle.
fn within(
    pencil: &mut Pencil,
    (low, high): (f64, f64),
    count: usize,
    search: Search,
) -> Result<Modes, FemError> {
    if count == 0 {
        return Ok(none(pencil, high));
    }
    let (shift, mut factor) = middle(pencil, low, high)?;
    let inside = |theta: &f64| (low..high).contains(&(shift + 1.0 / theta));
    let (size, mass) = (pencil.mass.size(), pencil.mass);
    let mut lanczos = Lanczos::new(mass, &mut factor, search.block);
    let mut searches = 0;
    loop {
        // one beyond the band: all that lie nearer to the shift came before it
        let enough = |theta: &[f64]| theta.iter().any(|t| !inside(t));
        let (ritz, converged) = converge(&mut lanczos, count, search.tolerance, enough)?;
        let mut picked: Vec<usize> = (0..converged).filter(|&i| inside(&ritz.theta[i])).collect();
        if picked.len() == count {
            picked.sort_by(|&a, &b| (1.0 / ritz.theta[a]).total_cmp(&(1.0 / ritz.theta[b])));
            let all = lanczos.vectors(&ritz, converged);
            let vectors = picked.iter().flat_map(|&i| &all[i * size..(i + 1) * size]).copied().collect();
            let theta: Vec<f64> = picked.iter().map(|&i| ritz.theta[i]).collect();
            let solves = lanczos.solves();
            drop(lanczos);
            return finish(pencil, &mut factor, shift, &theta, vectors, high, solves);
        }
        searches += 1;
        if picked.len() > count || searches == SEARCHES || lanczos.exhausted() {
            let (counted, found) = (count, picked.len());
            return Err(FemError::ModeCount { counted, found, frequency: frequency(high) });
        }
        stir(&mut lanczos, &ritz, search);
    }
}

/// A stable factor about the middle of a band.
fn middle(pencil: &Pencil, low: f64, high: f64) -> Result<(f64, Factor), FemError> {
    for part in [0.5, 0.47, 0.53, 0.44] {
        let shift = low + part * (high - low);
        match pencil.at(shift) {
            Err(FemError::Unstable { .. } | FemError::Pivot { .. }) => {}
            other => return Ok((shift, other?)),
        }
    }
    let shift = low + 0.56 * (high - low);
    Ok((shift, pencil.at(shift)?))
}

/// Steps, with restarts, until those that converged are enough; returns the pairs and how many of the first
/// converged, in the order of $|\theta|$, so that none that belongs before the last is left out.
fn converge(
    lanczos: &mut Lanczos,
    asked: usize,
    tolerance: f64,
    enough: impl Fn(&[f64]) -> bool,
) -> Result<(Ritz, usize), FemError> {
    let limit = lanczos.solves() + 300 + 20 * asked;
    loop {
        lanczos.step();
        let ritz = lanczos.ritz()?;
        if lanczos.exhausted() {
            let all = ritz.theta.len();
            return Ok((ritz, all));
        }
        let converged = ritz.bound.iter().take_while(|b| **b <= tolerance).count();
        if enough(&ritz.theta[..converged]) {
            return Ok((ritz, converged));
        }
        if lanczos.solves() > limit {
            let solves = lanczos.solves();
            return Err(FemError::ModesNotConverged { asked, converged, tolerance, solves });
        }
        let keep = asked.max(converged) + 20;
        if lanczos.done() >= 2 * keep + 20 {
            lanczos.restart(&ritz, keep);
        }
    }
}

/// Vectors cleared of parts without mass by the operator itself, with what the two differ by; orthonormal,
/// signed.
fn finish(
    pencil: &Pencil,
    factor: &mut Factor,
    shift: f64,
    theta: &[f64],
    vectors: Vec<f64>,
    counted_at: f64,
    solves: usize,
) -> Result<Modes, FemError> {
    let (size, count, mass) = (pencil.mass.size(), theta.len(), pencil.mass);
    let times = |x: &[f64]| {
        let mut y = vec![0.0; x.len()];
        x.chunks(size).zip(y.chunks_mut(size)).for_each(|(x, y)| mass.multiply(x, y));
        y
    };
    let mut shape = times(&vectors);
    factor.solve(&mut shape);
    let mut bound = vec![];
    for (j, t) in theta.iter().enumerate() {
        let range = j * size..(j + 1) * size;
        shape[range.clone()].iter_mut().for_each(|v| *v /= t);
        let difference: Vec<f64> =
            shape[range.clone()].iter().zip(&vectors[range]).map(|(a, b)| a - b).collect();
        bound.push(mass.quadratic(&difference).max(0.0).sqrt());
    }
    orthonormalise(&mut shape, &times, size, count)?;
    let value: Vec<f64> = theta.iter().map(|t| shift + 1.0 / t).collect();
    let mut residual = vec![];
    let (mut r, mut p) = (vec![0.0; size], vec![0.0; size]);
    for (x, value) in shape.chunks_mut(size).zip(&value) {
        let top = x.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let sign = x.iter().find(|v| v.abs() >= (1.0 - 1e-6) * top).map_or(1.0, |v| v.signum());
        x.iter_mut().for_each(|v| *v *= sign);
        mass.multiply(x, &mut p);
        pencil.stiffness.multiply(x, &mut r);
        r.iter_mut().zip(&p).for_each(|(r, p)| *r -= value * p);
        residual.push(norm(&r) / ((value - shift).abs() * norm(&p)));
    }
    let solves = solves + count;
    Ok(Modes { size, value, shape, bound, residual, shift, counted_at, solves })
}

/// $M$-orthonormal by the Cholesky factor of their products, twice; the first vectors change least.
fn orthonormalise(
    shape: &mut Vec<f64>,
    times: &impl Fn(&[f64]) -> Vec<f64>,
    size: usize,
    count: usize,
) -> Result<(), FemError> {
    for _ in 0..2 {
        let product = times(shape);
        let [a, b] = [&*shape, &product].map(|v| MatRef::from_column_major_slice(v, size, count));
        let gram = a.transpose() * b;
        let lower = gram.llt(Side::Lower).map_err(|_| FemError::NotFinite {
            row: count,
            column: count,
            value: f64::NAN,
        })?;
        let mut rows = a.transpose().to_owned();
        let par = faer::Par::Seq;
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(lower.L(), rows.as_mut(), par);
        *shape = (0..count).flat_map(|j| (0..size).map(move |i| (j, i))).map(|(j, i)| rows[(j, i)]).collect();
    }
    Ok(())
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|a| a * a).sum::<f64>().sqrt()
}

fn none(pencil: &Pencil, counted_at: f64) -> Modes {
    Modes {
        size: pencil.mass.size(),
        value: vec![],
        shape: vec![],
        bound: vec![],
        residual: vec![],
        shift: 0.0,
        counted_at,
        solves: 0,
    }
}
