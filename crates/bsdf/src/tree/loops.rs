//! Loops over many directions side by side.

use std::f64::consts::PI;

use super::cumulative::{ABREAST, Slices};
use super::lookup::{Cell, Incidence};
use super::node::{Rank, TensorTree};
use super::walk::Walk;
use crate::DVec2;
use crate::lanes::{Lanes, Sense};
use crate::unit::BELOW_ONE;
use bsdfkit_sphere::concentric::disk_to_square;
use bsdfkit_sphere::widest::Loop;

/// Cells of up to [`ABREAST`] known directions.
#[inline(always)]
fn cells(rank: Rank, sense: Sense, known: Lanes<'_>) -> [Cell; ABREAST] {
    let mut cells = [Cell::default(); ABREAST];
    for k in 0..known.len().min(ABREAST) {
        let w = known.at(k);
        cells[k] = match sense {
            Sense::Forward => Incidence::new(rank, w).cell(),
            Sense::Reverse => Cell::of(disk_to_square(w.truncate())),
        };
    }
    cells
}

/// The same loop for each rank: with the rank known it has no branch.
#[inline(always)]
fn cells_of(rank: Rank, sense: Sense, known: Lanes<'_>) -> [Cell; ABREAST] {
    match rank {
        Rank::Three => cells(Rank::Three, Sense::Forward, known),
        Rank::Four => cells(Rank::Four, sense, known),
    }
}

/// The loop of [`Distribution::totals`].
pub(super) struct Totals<'a> {
    pub(super) rank: Rank,
    pub(super) slices: &'a Slices,
    pub(super) known: Lanes<'a>,
    pub(super) sense: Sense,
    pub(super) floor: f64,
    pub(super) out: &'a mut [f64],
}

impl Loop for Totals<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { rank, slices, known, sense, floor, out } = self;
        for (n, out) in out.chunks_mut(ABREAST).enumerate() {
            let known = known.part(n * ABREAST..n * ABREAST + out.len());
            let slices = slices.at_abreast(&cells_of(rank, sense, known));
            for (k, out) in out.iter_mut().enumerate() {
                let total = PI * (f64::from(slices[k].mean) - floor).max(0.0);
                *out = if (known.x[k] + known.y[k]).is_finite() { total } else { f64::NAN };
            }
        }
    }
}

/// One or two numbers, kept within \[0, 1).
pub(super) trait Numbers: Copy {
    fn inside(self) -> Self;
    fn is_finite(self) -> bool;
}

impl Numbers for f64 {
    #[inline(always)]
    fn inside(self) -> Self {
        let u = if self > 0.0 { self } else { 0.0 };
        if u < BELOW_ONE { u } else { BELOW_ONE }
    }

    fn is_finite(self) -> bool {
        self.is_finite()
    }
}

impl Numbers for DVec2 {
    #[inline(always)]
    fn inside(self) -> Self {
        Self::new(self.x.inside(), self.y.inside())
    }

    fn is_finite(self) -> bool {
        (self.x + self.y).is_finite()
    }
}

/// The loop of [`Distribution::samples`] and of [`Distribution::samples2`].
pub(super) struct Samples<'a, W: Walk> {
    pub(super) tree: &'a TensorTree,
    pub(super) slices: &'a Slices,
    pub(super) known: Lanes<'a>,
    pub(super) sense: Sense,
    pub(super) floor: f64,
    pub(super) u: &'a [W::Numbers],
    pub(super) out: &'a mut [Option<DVec2>],
}

impl<W: Walk<Numbers: Numbers>> Loop for Samples<'_, W> {
    #[inline(always)]
    fn run(self) {
        let Self { tree, slices, known, sense, floor, u, out } = self;
        for (n, out) in out.chunks_mut(ABREAST).enumerate() {
            let lanes = n * ABREAST..n * ABREAST + out.len();
            let (known, u) = (known.part(lanes.clone()), &u[lanes]);
            let found = slices.at_abreast(&cells_of(tree.rank(), sense, known));
            let mut inside = [W::Numbers::default(); ABREAST];
            for (inside, u) in inside.iter_mut().zip(u) {
                *inside = u.inside();
            }
            let squares = slices.sample_abreast::<W>(tree, &found, floor, &inside);
            match tree.rank() {
                Rank::Three => disks(Rank::Three, known, &squares, out),
                Rank::Four => disks(Rank::Four, known, &squares, out),
            }
            for (k, out) in out.iter_mut().enumerate() {
                let valid = (known.x[k] + known.y[k]).is_finite() && u[k].is_finite();
                if !valid || f64::from(found[k].mean) <= floor {
                    *out = None;
                }
            }
        }
    }
}

/// Points of the square as each known direction sees them.
#[inline(always)]
fn disks(rank: Rank, known: Lanes<'_>, squares: &[DVec2; ABREAST], out: &mut [Option<DVec2>]) {
    let (mut x, mut y) = ([0.0; ABREAST], [0.0; ABREAST]);
    for k in 0..known.len().min(ABREAST) {
        let d = Incidence::new(rank, known.at(k)).disk_of(squares[k]);
        (x[k], y[k]) = (d.x, d.y);
    }
    for (k, out) in out.iter_mut().enumerate().take(ABREAST) {
        *out = Some(DVec2::new(x[k], y[k]));
    }
}
