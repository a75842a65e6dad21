//! Points in a box, found through a k-d tree: sizes of elements may differ by any factor.

/// Points with their numbers; the middle of every stretch divides it along one axis after another.
pub(super) struct Tree(Vec<([f64; 3], u32)>);

impl Tree {
    pub(super) fn new(mut points: Vec<([f64; 3], u32)>) -> Self {
        divide(&mut points, 0);
        Self(points)
    }

    /// Calls `found` with every point of the closed box.
    pub(super) fn within(&self, low: [f64; 3], high: [f64; 3], found: &mut impl FnMut([f64; 3], u32)) {
        let mut open = vec![(&self.0[..], 0)];
        while let Some((points, axis)) = open.pop() {
            let middle = points.len() / 2;
            let Some(&(place, number)) = points.get(middle) else { continue };
            if (0..3).all(|c| low[c] <= place[c] && place[c] <= high[c]) {
                found(place, number);
            }
            let next = (axis + 1) % 3;
            if low[axis] <= place[axis] {
                open.push((&points[..middle], next));
            }
            if place[axis] <= high[axis] {
                open.push((&points[middle + 1..], next));
            }
        }
    }
}

fn divide(points: &mut [([f64; 3], u32)], axis: usize) {
    if points.len() < 2 {
        return;
    }
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    let (low, high) = points.split_at_mut(middle);
    divide(low, (axis + 1) % 3);
    divide(&mut high[1..], (axis + 1) % 3);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_holds_what_a_search_through_all_points_finds() {
        // Points of a spiral, with many equal coordinates.
        let point = |i: u32| {
            let t = f64::from(i);
            [(t * 0.7).sin().round(), (t * 0.9).cos(), f64::from(i % 7)]
        };
        let points: Vec<([f64; 3], u32)> = (0..500).map(|i| (point(i), i)).collect();
        let tree = Tree::new(points.clone());
        for i in 0..50 {
            let low = [-1.0, f64::from(i) / 30.0 - 1.0, f64::from(i % 5)];
            let high = [f64::from(i % 3) - 1.0, low[1] + 0.3, low[2] + 2.0];
            let mut found = Vec::new();
            tree.within(low, high, &mut |_, number| found.push(number));
            found.sort_unstable();
            let inside = |p: &[f64; 3]| (0..3).all(|c| low[c] <= p[c] && p[c] <= high[c]);
            let expected: Vec<u32> = points.iter().filter(|(p, _)| inside(p)).map(|(_, n)| *n).collect();
            assert_eq!(found, expected);
        }
    }
}
