//! Many values side by side.

use super::super::lookup::{Incidence, Key};
use super::super::node::{BRANCH, Rank, leaf_value};
use super::shaped::{Known, Shaped};
use crate::lanes::Lanes;
use bsdfkit_sphere::widest::{Loop, widest};

/// Queries that descend side by side: enough to hide the latency of memory.
const ABREAST: usize = 64;

/// f of many pairs; one for each element of `out`.
pub(super) fn values(shaped: Shaped<'_>, wi: Lanes<'_>, wo: Lanes<'_>, out: &mut [f64]) {
    widest(Values { shaped, wi, wo, out });
}

struct Values<'a> {
    shaped: Shaped<'a>,
    wi: Lanes<'a>,
    wo: Lanes<'a>,
    out: &'a mut [f64],
}

impl Loop for Values<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { shaped, wi, wo, out } = self;
        for (n, out) in out.chunks_mut(ABREAST).enumerate() {
            let lanes = n * ABREAST..n * ABREAST + out.len();
            let (wi, wo) = (wi.part(lanes.clone()), wo.part(lanes));
            // Twice the same loops: with the rank known they have no branch.
            match shaped.tree.rank {
                Rank::Three => block(Rank::Three, shaped, wi, wo, out),
                Rank::Four => block(Rank::Four, shaped, wi, wo, out),
            }
        }
    }
}

/// Up to [`ABREAST`] queries.
#[inline(always)]
fn block(rank: Rank, shaped: Shaped<'_>, wi: Lanes<'_>, wo: Lanes<'_>, out: &mut [f64]) {
    let count = out.len().min(ABREAST);
    let (wi, wo, out) = (wi.part(0..count), wo.part(0..count), &mut out[..count]);
    let (mut s, mut t) = ([Known::default(); ABREAST], [Known::default(); ABREAST]);
    let mut keys = [Key::default(); ABREAST];
    for k in 0..count {
        let incidence = Incidence::new(rank, wi.at(k));
        s[k] = Known::new(incidence.point);
        t[k] = Known::new(incidence.square_of(wo.at(k)));
        keys[k] = Key::of_cells(s[k].cell, t[k].cell);
    }
    let slots = &*shaped.tree.slots;
    let (mut slot, mut at, mut levels) = ([shaped.tree.root; ABREAST], [0; ABREAST], [0; ABREAST]);
    for level in 0..shaped.tree.depth {
        for k in 0..ABREAST {
            // A leaf reads the first slot, in vain: cheaper than a branch that is not foreseen.
            let branch = slot[k] & BRANCH != 0;
            let below = (slot[k] ^ BRANCH) as usize * rank.children() + keys[k].slot(level);
            at[k] = if branch { below } else { at[k] };
            levels[k] += u32::from(branch);
            let found = slots.get(if branch { below } else { 0 }).copied().unwrap_or(0);
            slot[k] = if branch { found } else { slot[k] };
        }
    }
    for (k, out) in out.iter_mut().enumerate() {
        let finite = (wi.x[k] + wi.y[k] + wo.x[k] + wo.y[k]).is_finite();
        let (s, t) = (s[k].place(levels[k]), t[k].place(levels[k]));
        *out = match levels[k] {
            _ if !finite => f64::NAN,
            0 => leaf_value(shaped.tree.root).into(),
            _ => shaped.value(at[k], s, t),
        };
    }
}
