//! The descent to a leaf's value, of one query or of many side by side.

use super::lookup::{Key, TOP};
use super::node::{BRANCH, Rank, TensorTree, leaf_value};
use crate::DVec3;
use crate::lanes::Lanes;
use bsdfkit_sphere::widest::{Loop, widest};

/// Queries that descend side by side: enough to hide the latency of memory.
const ABREAST: usize = 64;

/// What the cells [`TOP`] levels below the root hold: where descents begin.
#[derive(Debug)]
pub(super) struct Top(Box<[u32; 1 << (4 * TOP)]>);

/// Where the slot of a branch lies for the part `part` of it. The shift drops the mark of a branch.
#[inline(always)]
fn below(branch: u32, rank: Rank, part: usize) -> u32 {
    branch << rank.dimensions() | part as u32
}

impl Top {
    pub(super) fn new(tree: &TensorTree) -> Self {
        let mut top = Box::new([0; 1 << (4 * TOP)]);
        let slots = &*tree.slots;
        for (path, top) in top.iter_mut().enumerate() {
            let mut slot = tree.root;
            for level in 0..TOP.min(tree.depth) {
                if slot & BRANCH != 0 {
                    let part = path >> (4 * (TOP - 1 - level)) & (tree.rank.children() - 1);
                    let at = below(slot, tree.rank, part);
                    slot = slots.get(at as usize).copied().unwrap_or(0);
                }
            }
            *top = slot;
        }
        Self(top)
    }

    /// The value stored for a pair of directions, as [`TensorTree::leaf_at`] finds it.
    #[inline]
    pub(super) fn value(&self, tree: &TensorTree, wi: DVec3, wo: DVec3) -> f32 {
        if !(wi.x + wi.y + wo.x + wo.y).is_finite() {
            return f32::NAN;
        }
        let key = Key::of(tree.rank, wi, wo);
        let slots = &*tree.slots;
        let mut slot = self.0[key.top()];
        for level in TOP..tree.depth {
            if slot & BRANCH == 0 {
                break;
            }
            let at = below(slot, tree.rank, key.slot(level));
            slot = slots.get(at as usize).copied().unwrap_or(0);
        }
        leaf_value(slot)
    }

    /// [`Top::value`] of many pairs: [`ABREAST`] go down side by side, so that their cache misses
    /// overlap.
    pub(super) fn values(&self, tree: &TensorTree, wi: Lanes<'_>, wo: Lanes<'_>, out: &mut [f64]) {
        widest(Values { top: self, tree, wi, wo, out });
    }
}

/// The loop of [`Top::values`].
struct Values<'a> {
    top: &'a Top,
    tree: &'a TensorTree,
    wi: Lanes<'a>,
    wo: Lanes<'a>,
    out: &'a mut [f64],
}

impl Loop for Values<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { top, tree, wi, wo, out } = self;
        let slots = &*tree.slots;
        for (n, out) in out.chunks_mut(ABREAST).enumerate() {
            let lanes = n * ABREAST..n * ABREAST + out.len();
            let (wi, wo) = (wi.part(lanes.clone()), wo.part(lanes));
            // Twice the same loops: with the rank known they have no branch.
            match tree.rank {
                Rank::Three => block(Rank::Three, (top, slots, tree.depth), wi, wo, out),
                Rank::Four => block(Rank::Four, (top, slots, tree.depth), wi, wo, out),
            }
        }
    }
}

/// Up to [`ABREAST`] queries.
#[inline(always)]
fn block(
    rank: Rank,
    (top, slots, depth): (&Top, &[u32], u32),
    wi: Lanes<'_>,
    wo: Lanes<'_>,
    out: &mut [f64],
) {
    let count = out.len().min(ABREAST);
    let (wi, wo, out) = (wi.part(0..count), wo.part(0..count), &mut out[..count]);
    let mut keys = [Key::default(); ABREAST];
    for k in 0..count {
        keys[k] = Key::of(rank, wi.at(k), wo.at(k));
    }
    let mut reached = keys.map(|key| top.0[key.top()]);
    for level in TOP..depth {
        let mut at = [0; ABREAST];
        for k in 0..ABREAST {
            // A leaf reads the first slot, in vain: cheaper than a branch that is not foreseen.
            let inner = below(reached[k], rank, keys[k].slot(level));
            at[k] = if reached[k] & BRANCH != 0 { inner } else { 0 };
        }
        let mut found = [0; ABREAST];
        for k in 0..ABREAST {
            found[k] = slots.get(at[k] as usize).copied().unwrap_or(0);
        }
        for k in 0..ABREAST {
            reached[k] = if reached[k] & BRANCH != 0 { found[k] } else { reached[k] };
        }
    }
    for (k, out) in out.iter_mut().enumerate() {
        let finite = (wi.x[k] + wi.y[k] + wo.x[k] + wo.y[k]).is_finite();
        let value = f64::from(leaf_value(reached[k]));
        *out = if finite { value } else { f64::NAN };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Result;
    use crate::tree::TreeBuilder;
    use bsdfkit_sphere::{DVec2, Side, concentric::square_to_hemisphere};

    /// Every third child is a leaf, down to `depth`.
    fn grow(b: &mut TreeBuilder, rank: Rank, depth: u32, next: &mut f32) -> Result<()> {
        b.open_branch()?;
        for child in 0..rank.children() {
            *next += 1.0;
            if depth > 1 && child % 3 == 0 {
                grow(b, rank, depth - 1, next)?;
            } else {
                b.leaf(*next)?;
            }
        }
        b.close_branch()
    }

    /// The plain descent is the oracle, above, at and below the level where the table ends.
    #[test]
    fn the_table_of_the_first_levels_changes_nothing() {
        for (rank, depth) in
            [Rank::Three, Rank::Four].into_iter().flat_map(|r| (0..6).map(move |d| (r, d)))
        {
            let mut b = TreeBuilder::new(rank);
            if depth == 0 {
                b.leaf(3.0).unwrap();
            } else {
                grow(&mut b, rank, depth, &mut 0.0).unwrap();
            }
            let tree = b.finish().unwrap();
            let top = Top::new(&tree);
            let at = |k: u32, step: f64| (f64::from(k) * step).fract();
            for k in 0..5000 {
                let w = |a, b| square_to_hemisphere(DVec2::new(at(k, a), at(k, b)), Side::Front);
                let (wi, wo) = (w(0.754_877_666, 0.569_840_291), w(0.618_033_989, 0.414_213_562));
                assert_eq!(
                    top.value(&tree, wi, wo),
                    tree.leaf_at(wi, wo).0,
                    "{rank:?}, depth {depth}"
                );
            }
        }
    }

    /// Branches that a damaged file has where none can be.
    #[test]
    fn damaged_trees_are_read_inside_their_bounds() {
        let slots = vec![BRANCH | 0x7fff_ffff, BRANCH | 77, BRANCH, 0x3f80_0000];
        let slots: Vec<u32> = slots.into_iter().cycle().take(64).collect();
        for depth in 0..9 {
            let tree = TensorTree::unchecked(Rank::Four, BRANCH, slots.clone().into(), depth);
            let top = Top::new(&tree);
            let mut out = [f64::NAN];
            for k in 0..100 {
                let w = bsdfkit_sphere::direction::from_degrees(
                    0.9 * f64::from(k),
                    77.0 * f64::from(k),
                );
                let one = top.value(&tree, w, w);
                let (x, y, z) = ([w.x], [w.y], [w.z]);
                let lanes = Lanes { x: &x, y: &y, z: &z };
                top.values(&tree, lanes, lanes, &mut out);
                assert!(f64::from(one) == out[0] && one.is_finite());
            }
        }
    }
}
