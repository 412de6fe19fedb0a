//! What decides a sample: one number, which follows a Hilbert curve, or two, which are warped.

use bsdfkit_sphere::hilbert;

use crate::distribution::Distribution;
use crate::lanes::{Lanes, Sense};
use crate::unit::BELOW_ONE;
use crate::{DVec2, DVec3};

/// One or two canonical random numbers, each in \[0, 1).
pub(crate) trait Canonical: Copy + Default + Send + Sync {
    fn has_nan(self) -> bool;

    /// The number that chooses the part of the BSDF.
    fn first(self) -> f64;

    /// The same with what the choice has left of it.
    fn with_first(self, rest: f64) -> Self;

    /// A point of the unit square, each as likely.
    fn point(self) -> DVec2;

    /// One number, each as likely: neighbours on the Hilbert curve.
    fn folded(self) -> f64;

    /// [`Distribution::sample`] or [`Distribution::sample2`].
    fn sample(self, of: &dyn Distribution, known: DVec3, sense: Sense, floor: f64)
    -> Option<DVec2>;

    /// [`Distribution::samples`] or [`Distribution::samples2`].
    fn samples(
        numbers: &[Self],
        of: &dyn Distribution,
        known: Lanes<'_>,
        sense: Sense,
        floor: f64,
        out: &mut [Option<DVec2>],
    );
}

impl Canonical for f64 {
    fn has_nan(self) -> bool {
        self.is_nan()
    }

    fn first(self) -> f64 {
        self
    }

    fn with_first(self, rest: f64) -> Self {
        rest
    }

    fn point(self) -> DVec2 {
        hilbert::unfold(self)
    }

    fn folded(self) -> f64 {
        self
    }

    fn sample(
        self,
        of: &dyn Distribution,
        known: DVec3,
        sense: Sense,
        floor: f64,
    ) -> Option<DVec2> {
        of.sample(known, sense, floor, self)
    }

    fn samples(
        numbers: &[Self],
        of: &dyn Distribution,
        known: Lanes<'_>,
        sense: Sense,
        floor: f64,
        out: &mut [Option<DVec2>],
    ) {
        of.samples(known, sense, floor, numbers, out);
    }
}

impl Canonical for DVec2 {
    fn has_nan(self) -> bool {
        self.is_nan()
    }

    fn first(self) -> f64 {
        self.x
    }

    fn with_first(self, rest: f64) -> Self {
        Self::new(rest, self.y)
    }

    fn point(self) -> DVec2 {
        self.clamp(DVec2::ZERO, DVec2::splat(BELOW_ONE))
    }

    fn folded(self) -> f64 {
        hilbert::fold(self.point())
    }

    fn sample(
        self,
        of: &dyn Distribution,
        known: DVec3,
        sense: Sense,
        floor: f64,
    ) -> Option<DVec2> {
        of.sample2(known, sense, floor, self)
    }

    fn samples(
        numbers: &[Self],
        of: &dyn Distribution,
        known: Lanes<'_>,
        sense: Sense,
        floor: f64,
        out: &mut [Option<DVec2>],
    ) {
        of.samples2(known, sense, floor, numbers, out);
    }
}
