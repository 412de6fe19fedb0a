//! Loops over many directions side by side.

use bsdfkit_sphere::hilbert;

use super::matrix::{KlemsMatrix, Role, nan_or_zero};
use super::sample::Draw;
use crate::DVec2;
use crate::klems::{CHUNK, NO_PATCH, Patch};
use crate::lanes::{Lanes, Sense};
use bsdfkit_sphere::widest::Loop;

/// The loop of [`Distribution::values`].
pub(super) struct Values<'a> {
    pub(super) matrix: &'a KlemsMatrix,
    pub(super) wi: Lanes<'a>,
    pub(super) wo: Lanes<'a>,
    pub(super) out: &'a mut [f64],
}

impl Loop for Values<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { matrix, wi, wo, out } = self;
        let columns = matrix.scattered().directions();
        for (n, out) in out.chunks_mut(CHUNK).enumerate() {
            let lanes = n * CHUNK..n * CHUNK + out.len();
            let (wi, wo) = (wi.part(lanes.clone()), wo.part(lanes));
            let (mut i, mut o) = ([0; CHUNK], [0; CHUNK]);
            matrix.incident().indices(wi, Role::Incident.sign(), &mut i[..out.len()]);
            matrix.scattered().indices(wo, Role::Scattered.sign(), &mut o[..out.len()]);
            for (k, out) in out.iter_mut().enumerate() {
                *out = if (i[k] == NO_PATCH) | (o[k] == NO_PATCH) {
                    nan_or_zero(wi.at(k) + wo.at(k))
                } else {
                    f64::from(matrix.values()[i[k] as usize * columns + o[k] as usize])
                };
            }
        }
    }
}

/// The loop of [`Distribution::totals`].
pub(super) struct Totals<'a> {
    pub(super) matrix: &'a KlemsMatrix,
    pub(super) known: Lanes<'a>,
    pub(super) sense: Sense,
    pub(super) floor: f64,
    pub(super) out: &'a mut [f64],
}

impl Loop for Totals<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { matrix, known, sense, floor, out } = self;
        let [(basis, role), _] = matrix.sides(sense);
        let totals = matrix.totals_of(sense);
        for (n, out) in out.chunks_mut(CHUNK).enumerate() {
            let known = known.part(n * CHUNK..n * CHUNK + out.len());
            let mut rows = [0; CHUNK];
            basis.indices(known, role.sign(), &mut rows[..out.len()]);
            for (k, out) in out.iter_mut().enumerate() {
                *out = if rows[k] == NO_PATCH {
                    nan_or_zero(known.at(k))
                } else {
                    totals.total(rows[k] as usize, floor)
                };
            }
        }
    }
}

/// One or two numbers that choose among the patches of rows.
pub(super) trait Numbers: Copy {
    /// [`Draw::sample`] or [`Draw::sample2`] of [`CHUNK`] rows: patches, and x and y of points in
    /// them, NaN where there is none.
    fn choose(
        numbers: &[Self],
        draw: Draw<'_>,
        rows: &[u32; CHUNK],
        floor: f64,
    ) -> ([u32; CHUNK], [[f64; CHUNK]; 2]);
}

impl Numbers for f64 {
    #[inline(always)]
    fn choose(
        numbers: &[Self],
        draw: Draw<'_>,
        rows: &[u32; CHUNK],
        floor: f64,
    ) -> ([u32; CHUNK], [[f64; CHUNK]; 2]) {
        let (mut drawn, mut rest) = ([0; CHUNK], [f64::NAN; CHUNK]);
        draw.sample_abreast(rows, floor, numbers, (&mut drawn, &mut rest));
        let (mut x, mut y) = ([0.0; CHUNK], [0.0; CHUNK]);
        for k in 0..CHUNK {
            let point = hilbert::unfold(rest[k]);
            (x[k], y[k]) = (point.x, point.y);
        }
        (drawn, [x, y])
    }
}

impl Numbers for DVec2 {
    #[inline(always)]
    fn choose(
        numbers: &[Self],
        draw: Draw<'_>,
        rows: &[u32; CHUNK],
        floor: f64,
    ) -> ([u32; CHUNK], [[f64; CHUNK]; 2]) {
        let (mut drawn, mut x, mut y) = ([0; CHUNK], [f64::NAN; CHUNK], [f64::NAN; CHUNK]);
        for (k, u) in numbers.iter().enumerate().take(CHUNK) {
            if rows[k] != NO_PATCH
                && let Some((patch, point)) = draw.sample2(rows[k] as usize, floor, *u)
            {
                (drawn[k], x[k], y[k]) = (patch as u32, point.x, point.y);
            }
        }
        (drawn, [x, y])
    }
}

/// The loop of [`Distribution::samples`] and of [`Distribution::samples2`].
pub(super) struct Samples<'a, U> {
    pub(super) matrix: &'a KlemsMatrix,
    pub(super) known: Lanes<'a>,
    pub(super) sense: Sense,
    pub(super) floor: f64,
    pub(super) u: &'a [U],
    pub(super) out: &'a mut [Option<DVec2>],
}

impl<U: Numbers> Loop for Samples<'_, U> {
    #[inline(always)]
    fn run(self) {
        let Self { matrix, known, sense, floor, u, out } = self;
        let [(basis, known_role), (_, role)] = matrix.sides(sense);
        let draw = matrix.draw(sense);
        for (n, out) in out.chunks_mut(CHUNK).enumerate() {
            let lanes = n * CHUNK..n * CHUNK + out.len();
            let (known, u) = (known.part(lanes.clone()), &u[lanes]);
            let mut rows = [NO_PATCH; CHUNK];
            basis.indices(known, known_role.sign(), &mut rows[..out.len()]);
            let (drawn, [mut x, mut y]) = U::choose(u, draw, &rows, floor);
            let mut patches = [Patch::default(); CHUNK];
            for k in 0..CHUNK {
                patches[k] = draw.sums.patch(drawn[k] as usize);
            }
            for k in 0..CHUNK {
                let d = role.sign() * patches[k].at(DVec2::new(x[k], y[k]));
                (x[k], y[k]) = (d.x, d.y);
            }
            for (k, out) in out.iter_mut().enumerate() {
                *out = (!x[k].is_nan()).then_some(DVec2::new(x[k], y[k]));
            }
        }
    }
}
