//! The nearest points of a direction set: a k-d tree over unit vectors.

use bsdfkit::DVec3;

use super::Directions;

/// Points in a leaf: below this a scan beats another level.
const LEAF: usize = 8;

/// An implicit balanced k-d tree: `order` is split at its middle, level by level, along the widest axis.
pub(super) struct Neighbours<'a> {
    points: &'a Directions,
    order: Vec<u32>,
    axes: Vec<u8>,
}

impl<'a> Neighbours<'a> {
    /// Builds over `points`. Cost: O(n log n); 5 bytes a point.
    pub(super) fn new(points: &'a Directions) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        let mut axes = vec![0; points.len()];
        split(points, &mut order, &mut axes);
        Self { points, order, axes }
    }

    /// The `K` nearest points to `w` other than `except`, as (squared chord, index), nearest first; fewer
    /// where there are not as many.
    pub(super) fn nearest<const K: usize>(&self, w: DVec3, except: Option<usize>) -> Nearest<K> {
        let mut found = Nearest { items: [(f64::INFINITY, usize::MAX); K], len: 0 };
        self.visit(0, self.order.len(), w, except, &mut found);
        found
    }

    fn visit<const K: usize>(
        &self,
        from: usize,
        to: usize,
        w: DVec3,
        except: Option<usize>,
        found: &mut Nearest<K>,
    ) {
        if to - from <= LEAF {
            for &index in &self.order[from..to] {
                self.offer(index, w, except, found);
            }
            return;
        }
        let middle = from.midpoint(to);
        let index = self.order[middle];
        let axis = usize::from(self.axes[middle]);
        let offset = w[axis] - self.points.at(index as usize)[axis];
        self.offer(index, w, except, found);
        let (near, far) = ((from, middle), (middle + 1, to));
        let (near, far) = if offset < 0.0 { (near, far) } else { (far, near) };
        self.visit(near.0, near.1, w, except, found);
        if offset * offset < found.worst() {
            self.visit(far.0, far.1, w, except, found);
        }
    }

    fn offer<const K: usize>(
        &self,
        index: u32,
        w: DVec3,
        except: Option<usize>,
        found: &mut Nearest<K>,
    ) {
        let index = index as usize;
        if Some(index) != except {
            found.offer(self.points.at(index).distance_squared(w), index);
        }
    }
}

fn split(points: &Directions, order: &mut [u32], axes: &mut [u8]) {
    if order.len() <= LEAF {
        return;
    }
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    for &i in order.iter() {
        let w = points.at(i as usize);
        (low, high) = (low.min(w), high.max(w));
    }
    let extent = high - low;
    let axis = extent.max_position();
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&a, &b| {
        points.at(a as usize)[axis].total_cmp(&points.at(b as usize)[axis])
    });
    axes[middle] = axis as u8;
    let (left, right) = order.split_at_mut(middle);
    let (left_axes, right_axes) = axes.split_at_mut(middle);
    rayon::join(
        || split(points, left, left_axes),
        || split(points, &mut right[1..], &mut right_axes[1..]),
    );
}

/// Up to `K` points, nearest first.
pub(super) struct Nearest<const K: usize> {
    items: [(f64, usize); K],
    len: usize,
}

impl<const K: usize> Nearest<K> {
    /// (squared chord, index), nearest first.
    pub(super) fn items(&self) -> &[(f64, usize)] {
        &self.items[..self.len]
    }

    fn worst(&self) -> f64 {
        self.items[K - 1].0
    }

    fn offer(&mut self, distance: f64, index: usize) {
        if distance >= self.worst() {
            return;
        }
        self.len = (self.len + 1).min(K);
        let mut at = self.len - 1;
        while at > 0 && self.items[at - 1].0 > distance {
            self.items[at] = self.items[at - 1];
            at -= 1;
        }
        self.items[at] = (distance, index);
    }
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::direction;

    use super::*;

    #[test]
    fn finds_what_a_scan_finds() {
        // very uneven: a dense spiral, a sparse ring, and repeated points
        let mut points: Directions = (0..400)
            .map(|i| direction::from_degrees(f64::from(i) * 0.02, f64::from(i) * 7.0))
            .collect();
        points.extend((0..50).map(|i| direction::from_degrees(60.0, f64::from(i) * 7.2)));
        points.extend((0..30).map(|_| direction::from_degrees(20.0, 20.0)));
        let tree = Neighbours::new(&points);
        for i in 0..200 {
            let w = direction::from_degrees(f64::from(i) * 0.45, f64::from(i) * 31.0);
            let except = (i % 2 == 0).then_some(i as usize);
            let mut scan: Vec<f64> = (0..points.len())
                .filter(|&k| Some(k) != except)
                .map(|k| points.at(k).distance_squared(w))
                .collect();
            scan.sort_by(f64::total_cmp);
            let found = tree.nearest::<5>(w, except);
            let distances: Vec<f64> = found.items().iter().map(|&(d, _)| d).collect();
            assert_eq!(distances, scan[..5]);
        }
    }

    #[test]
    fn few_points_give_few_neighbours() {
        let points = [DVec3::X, DVec3::Z].into_iter().collect();
        let tree = Neighbours::new(&points);
        assert_eq!(tree.nearest::<4>(DVec3::Z, Some(1)).items(), &[(2.0, 0)]);
        assert!(
            Neighbours::new(&Directions::new()).nearest::<4>(DVec3::Z, None).items().is_empty()
        );
    }
}
