//! A tree of boxes: which of many caps on the sphere a direction may lie in.

use std::f64::consts::FRAC_PI_2;

use bsdfkit_sphere::DVec3;

/// Items in a leaf. Four boxes cost as much to test as one more level; a guess that no bench could tell from eight.
const LEAF: usize = 4;

/// An axis-parallel box.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoundingBox {
    min: DVec3,
    max: DVec3,
}

impl BoundingBox {
    /// Holds every unit vector within `radius` radians of unit vector `middle`; all of space from 90 degrees on.
    pub(super) fn of_cap(middle: DVec3, radius: f64) -> BoundingBox {
        let reach =
            if radius < FRAC_PI_2 { 2.0 * (radius * 0.5).sin() + 1e-9 } else { f64::INFINITY };
        BoundingBox { min: middle - reach, max: middle + reach }
    }

    fn union(self, other: BoundingBox) -> BoundingBox {
        BoundingBox { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    fn contains(&self, p: DVec3) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }
}

/// A balanced tree of boxes. Memory: O(items).
#[derive(Debug)]
pub(super) struct BoxTree {
    boxes: Vec<BoundingBox>,
    items: Vec<u32>,
    /// Depth first: the left child of a node follows it; halves of `items` belong to the children.
    nodes: Vec<Node>,
}

#[derive(Debug)]
struct Node {
    bounds: BoundingBox,
    right: usize,
}

impl BoxTree {
    pub(super) fn new(boxes: Vec<BoundingBox>) -> BoxTree {
        let mut items: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut nodes = Vec::new();
        build(&boxes, &mut items, &mut nodes);
        BoxTree { boxes, items, nodes }
    }

    /// Calls `hit` with every item whose box holds `p`. Cost: O(log n + hits) for boxes that overlap little.
    pub(super) fn visit(&self, p: DVec3, mut hit: impl FnMut(u32)) {
        self.descend(0, 0, self.items.len(), p, &mut hit);
    }

    fn descend(&self, node: usize, start: usize, end: usize, p: DVec3, hit: &mut impl FnMut(u32)) {
        if start == end || !self.nodes[node].bounds.contains(p) {
            return;
        }
        if end - start <= LEAF {
            self.items[start..end]
                .iter()
                .filter(|&&i| self.boxes[i as usize].contains(p))
                .for_each(|&i| hit(i));
            return;
        }
        let middle = start.midpoint(end);
        self.descend(node + 1, start, middle, p, hit);
        self.descend(self.nodes[node].right, middle, end, p, hit);
    }
}

fn build(boxes: &[BoundingBox], items: &mut [u32], nodes: &mut Vec<Node>) {
    let Some(all) = items.iter().map(|&i| boxes[i as usize]).reduce(BoundingBox::union) else {
        return;
    };
    let node = nodes.len();
    nodes.push(Node { bounds: all, right: 0 });
    if items.len() <= LEAF {
        return;
    }
    let centre = |i: u32| boxes[i as usize].min.clamp(DVec3::splat(-2.0), DVec3::splat(2.0));
    let low = items.iter().map(|&i| centre(i)).reduce(DVec3::min).unwrap_or_default();
    let high = items.iter().map(|&i| centre(i)).reduce(DVec3::max).unwrap_or_default();
    let axis = (high - low).max_position();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |&a, &b| centre(a)[axis].total_cmp(&centre(b)[axis]));
    let (left, right) = items.split_at_mut(middle);
    build(boxes, left, nodes);
    nodes[node].right = nodes.len();
    build(boxes, right, nodes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_sphere::direction::from_degrees;

    #[test]
    fn finds_what_a_linear_scan_finds() {
        // Caps of 1 to 120 degrees on a spiral over the sphere, asked at points of another spiral.
        let spiral = |k: usize, n: usize, turn: f64| {
            from_degrees(
                (1.0 - 2.0 * (k as f64 + 0.5) / n as f64).acos().to_degrees(),
                turn * k as f64,
            )
        };
        let caps: Vec<(DVec3, f64)> = (0..200)
            .map(|k| (spiral(k, 200, 137.5), (1.0 + (k * k % 97) as f64 * 1.2).to_radians()))
            .collect();
        let tree = BoxTree::new(caps.iter().map(|&(m, r)| BoundingBox::of_cap(m, r)).collect());
        for k in 0..500 {
            let p = spiral(k, 500, 222.5);
            let mut found = Vec::new();
            tree.visit(p, |i| found.push(i as usize));
            found.sort_unstable();
            assert!(found.windows(2).all(|w| w[0] != w[1]));
            for (i, (m, r)) in caps.iter().enumerate() {
                assert!(
                    m.angle_between(p) > *r || found.binary_search(&i).is_ok(),
                    "cap {i} misses point {k}"
                );
            }
            assert!(found.len() < 200);
        }
    }

    #[test]
    fn empty_is_no_fault() {
        BoxTree::new(Vec::new()).visit(DVec3::Z, |_| panic!("nothing to hit"));
    }
}
