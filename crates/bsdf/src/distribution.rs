//! What a tree and a matrix have in common: a stored function of two directions.

use std::any::Any;
use std::fmt::Debug;

use bsdfkit_sphere::hilbert;

use crate::cell::Cell;
use crate::colour::Xyz;
use crate::klems::KlemsBasis;
use crate::lanes::{Lanes, Sense};
use crate::spectrum::Bands;
use crate::{DVec2, DVec3};

/// A component smaller than this (its largest total, dimensionless) is dropped from queries.
/// The reference library's constant: a larger one would lose visible light.
pub const NEGLIGIBLE_TOTAL: f64 = 0.001;

/// The smallest value (1/sr) that is worth a Lambertian part: 1 % reflectance.
/// The reference library's constant, kept so that parts have the same size there and here.
pub const LAMBERTIAN_THRESHOLD: f64 = 0.01 / std::f64::consts::PI;

/// f(wi, wo) ≥ 0 in 1/sr on one fixed pair of hemispheres, as a file stores it.
///
/// A distribution knows no sides: of a direction it reads x and y (and |z|), and it writes
/// the projection (x, y) of a sampled one; which sides the pair belongs to is its
/// [`Component`](crate::Component)'s business. `known` is one direction of the stored pair,
/// told apart by [`Sense`]; directions point away from the surface.
///
/// `floor` (1/sr) is a constant at most the minimum of f that is taken out: the queries then
/// concern f − floor. Taking it as an argument keeps the stored values those of the file.
///
/// Invalid: NaN in, NaN out ([`Distribution::sample`]: `None`); nothing panics.
pub trait Distribution: Any + Debug + Send + Sync {
    /// Photopic f(wi, wo), 1/sr.
    fn value(&self, wi: DVec3, wo: DVec3) -> f64;

    /// Appends the stored cells of the direction that is not known, on the front, see [`Bsdf::cells`](crate::Bsdf::cells); false where
    /// there are too many of them.
    fn cells(&self, _known: DVec3, _sense: Sense, _out: &mut Vec<Cell>) -> bool {
        true
    }

    /// [`Distribution::value`] of many pairs, bit for bit; one for each element of `out`.
    fn values(&self, wi: Lanes<'_>, wo: Lanes<'_>, out: &mut [f64]) {
        for (n, out) in out.iter_mut().enumerate() {
            *out = self.value(wi.at(n), wo.at(n));
        }
    }

    /// f(wi, wo) in colour, 1/sr; its Y equals [`Distribution::value`].
    fn value_xyz(&self, wi: DVec3, wo: DVec3) -> Xyz {
        Xyz::grey(self.value(wi, wo))
    }

    /// Whether [`Distribution::value_xyz`] is ever anything but grey.
    fn is_coloured(&self) -> bool {
        false
    }

    /// The wavelengths of [`Distribution::spectra`]; `None` where it knows no spectrum.
    fn wavelengths(&self) -> Option<&Bands> {
        None
    }

    /// f in 1/sr of every band, shortest wavelength first, of one direction and each of `other`; what bands weigh in light is
    /// [`Distribution::value`].
    ///
    /// Shapes: `out` is (`other.len()`, bands).
    fn spectra(&self, _known: DVec3, _other: &[DVec3], _sense: Sense, out: &mut [f64]) {
        out.fill(f64::NAN);
    }

    /// The constant part (1/sr) that the reference library would move to the Lambertian
    /// field; zero when the minimum lies outside the thresholds of the representation.
    fn constant_part(&self) -> Xyz;

    /// ∫ (f − floor) |cos θ| dω over the other direction: dimensionless.
    fn total(&self, known: DVec3, sense: Sense, floor: f64) -> f64;

    /// [`Distribution::total`] of many directions, bit for bit; one for each element of `out`.
    fn totals(&self, known: Lanes<'_>, sense: Sense, floor: f64, out: &mut [f64]) {
        for (n, out) in out.iter_mut().enumerate() {
            *out = self.total(known.at(n), sense, floor);
        }
    }

    /// The basis over each of whose patches [`Distribution::total`] is constant, and the sign of x
    /// and y with which it numbers known directions; `None` where there is no such basis.
    fn patches(&self, _sense: Sense) -> Option<(&KlemsBasis, f64)> {
        None
    }

    /// [`Distribution::total`] by patch of the basis of [`Distribution::patches`].
    fn totals_by_patch(&self, _sense: Sense, _floor: f64, out: &mut [f64]) {
        out.fill(f64::NAN);
    }

    /// The largest [`Distribution::total`] of the forward sense.
    fn max_total(&self, floor: f64) -> f64;

    /// Whether f − floor is too small to count: at most [`NEGLIGIBLE_TOTAL`] for any incidence.
    fn is_negligible(&self, floor: f64) -> bool {
        self.max_total(floor) <= NEGLIGIBLE_TOTAL
    }

    /// The projection (x, y) of the other direction, drawn with density (f − floor)/total per
    /// projected solid angle, or that of [`Distribution::drawn`]; `u` in \[0, 1) follows a Hilbert order, so that neighbouring `u`
    /// give neighbouring directions. `None` when the total is zero.
    fn sample(&self, known: DVec3, sense: Sense, floor: f64, u: f64) -> Option<DVec2>;

    /// [`Distribution::sample`] of many directions, bit for bit; one for each element of `out`.
    fn samples(
        &self,
        known: Lanes<'_>,
        sense: Sense,
        floor: f64,
        u: &[f64],
        out: &mut [Option<DVec2>],
    ) {
        for (n, out) in out.iter_mut().enumerate() {
            *out = self.sample(known.at(n), sense, floor, u[n]);
        }
    }

    /// [`Distribution::sample`] by two numbers, each in \[0, 1): points stratified in the square
    /// give stratified directions. Unless overridden, the two are folded into one along a Hilbert
    /// curve.
    fn sample2(&self, known: DVec3, sense: Sense, floor: f64, u: DVec2) -> Option<DVec2> {
        self.sample(known, sense, floor, hilbert::fold(u))
    }

    /// [`Distribution::sample2`] of many directions, bit for bit; one for each element of `out`.
    fn samples2(
        &self,
        known: Lanes<'_>,
        sense: Sense,
        floor: f64,
        u: &[DVec2],
        out: &mut [Option<DVec2>],
    ) {
        for (n, out) in out.iter_mut().enumerate() {
            *out = self.sample2(known.at(n), sense, floor, u[n]);
        }
    }

    /// Whether samples are drawn with another density than f − floor, though one near it: that of
    /// [`Distribution::drawn`]. Then the weights of samples vary.
    fn draws_apart(&self) -> bool {
        false
    }

    /// The density per projected solid angle with which [`Distribution::sample`] draws `other`, times the total: near
    /// f, 1/sr, and nowhere 0 where f is not. Asked only where samples are drawn apart.
    fn drawn(&self, _known: DVec3, _other: DVec3, _sense: Sense) -> f64 {
        f64::NAN
    }

    /// [`Distribution::value`] of the stored pair and [`Distribution::drawn`] together, for less than both cost.
    fn value_and_drawn(&self, known: DVec3, other: DVec3, sense: Sense) -> (f64, f64) {
        let (wi, wo) = match sense {
            Sense::Forward => (known, other),
            Sense::Reverse => (other, known),
        };
        let value = self.value(wi, wo);
        (value, if self.draws_apart() { self.drawn(known, other, sense) } else { value })
    }

    /// [`Distribution::value_and_drawn`] of many pairs, bit for bit; one for each element of `values` and `drawn`.
    fn values_and_drawn(
        &self,
        known: Lanes<'_>,
        other: Lanes<'_>,
        sense: Sense,
        values: &mut [f64],
        drawn: &mut [f64],
    ) {
        for (n, (value, drawn)) in values.iter_mut().zip(drawn).enumerate() {
            (*value, *drawn) = self.value_and_drawn(known.at(n), other.at(n), sense);
        }
    }

    /// Projected solid angle (sr) of the stored cell: smallest and largest.
    ///
    /// With both directions: of the cells that the pair hits; with `known` alone: of all cells
    /// of the other direction. `None` where there is no data.
    fn projected_solid_angle(
        &self,
        known: DVec3,
        other: Option<DVec3>,
        sense: Sense,
    ) -> Option<(f64, f64)>;

    /// The smallest projected solid angle of any cell, sr.
    fn min_projected_solid_angle(&self) -> f64;

    /// Whether [`Distribution::prepare`] has anything.
    fn prepares(&self) -> bool {
        false
    }

    /// What many questions about one known direction share; `None` for tables, which have all of
    /// it.
    ///
    /// A distribution that prepares has no constant part, and answers each verb as what it prepares
    /// does.
    fn prepare(&self, _known: DVec3, _sense: Sense) -> Option<Box<dyn Prepared + '_>> {
        None
    }

    /// The distribution as a file stores it, of which this one is another reading.
    fn stored(&self) -> Option<&dyn Distribution> {
        None
    }
}

/// A distribution seen from one known direction of its stored pair.
///
/// For functions that take long to set up for a direction and answer fast from then on. They are
/// drawn from by a table that is near f, so that the weights of samples vary; of a table of f
/// itself they do not.
///
/// Invalid: as [`Distribution`].
pub trait Prepared: Sync {
    /// f of the known direction and each of `other`, 1/sr, in colour; one for each element of
    /// `out`.
    fn values_xyz(&self, other: &[DVec3], out: &mut [Xyz]);

    /// Photopic f of the known direction and one other, 1/sr.
    fn value(&self, other: DVec3) -> f64 {
        let mut value = [Xyz::ZERO];
        self.values_xyz(&[other], &mut value);
        value[0].y
    }

    /// ∫ f |cos θ| dω over the other direction: dimensionless.
    fn total(&self) -> f64;

    /// The density per projected solid angle with which [`Prepared::sample`] draws `other`, times
    /// the total: near f, 1/sr, and nowhere 0 where f is not.
    fn drawn(&self, other: DVec3) -> f64;

    /// The projection (x, y) of the other direction, as [`Distribution::sample`].
    fn sample(&self, u: f64) -> Option<DVec2>;

    /// Projected solid angle (sr) of the cells that are drawn from, as
    /// [`Distribution::projected_solid_angle`].
    fn projected_solid_angle(&self, other: Option<DVec3>) -> (f64, f64);
}

impl dyn Distribution {
    /// The concrete representation, however read, if it is `T`: for writers.
    pub fn downcast_ref<T: Distribution>(&self) -> Option<&T> {
        (self.stored().unwrap_or(self) as &dyn Any).downcast_ref()
    }
}
