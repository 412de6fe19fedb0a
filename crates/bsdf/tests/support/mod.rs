//! Random numbers and random trees for tests: reproducible, with hard values planted.

use bsdfkit::tree::{Rank, TensorTree, TreeBuilder};
use bsdfkit::{DVec3, Side};
use bsdfkit_sphere::concentric::square_to_hemisphere;

/// SplitMix64. [Steele, Lea, Flood 2014]
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in projected solid angle.
    pub(crate) fn direction(&mut self, side: Side) -> DVec3 {
        let square = bsdfkit::DVec2::new(self.unit(), self.unit());
        square_to_hemisphere(square, side)
    }
}

/// Branches at random down to `depth`, never at `depth`, always at the root; a third of the leaves are 0,
/// the others differ by a factor of 100. `floor` is added to all.
pub(crate) fn random_tree(rank: Rank, depth: u32, floor: f32, random: &mut Random) -> TensorTree {
    fn node(b: &mut TreeBuilder, children: u32, left: u32, floor: f32, random: &mut Random) {
        b.open_branch().unwrap();
        for _ in 0..children {
            if left > 1 && random.unit() < 0.4 {
                node(b, children, left - 1, floor, random);
            } else {
                let value = random.unit();
                b.leaf(floor + if value < 0.33 { 0.0 } else { value.powi(4) as f32 }).unwrap();
            }
        }
        b.close_branch().unwrap();
    }
    let mut b = TreeBuilder::new(rank);
    node(&mut b, 1 << rank.dimensions(), depth, floor, random);
    b.finish().unwrap()
}
