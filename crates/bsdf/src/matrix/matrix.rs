//! A matrix of values over two Klems bases.

use std::sync::OnceLock;

use bsdfkit_sphere::hilbert;

use super::klems::KlemsBasis;
use super::many::{Samples, Totals, Values};
use super::sample::{Draw, RowTotals, Rows, RunningSums};
use crate::colour::Xyz;
use crate::distribution::{Distribution, LAMBERTIAN_THRESHOLD, Lanes, NEGLIGIBLE_TOTAL, Sense};
use crate::words::Words;
use crate::{DVec2, DVec3, Error, Result};
use bsdfkit_sphere::widest::widest;

/// f(wi, wo) constant on each pair of patches, 1/sr.
///
/// Convention: the incident basis is indexed by the *travel* direction of the incident light, so
/// that mirror reflection and straight transmission both lie on the diagonal of equal bases.
/// Shapes: row-major (incident, scattered): value number i · scattered.directions() + o.
/// Differs from: Radiance: values are returned as stored (not multiplied by 1 ± 3·10⁻⁴), colour
/// is not rounded, and exactly grazing directions have data.
#[derive(Debug)]
pub struct KlemsMatrix {
    incident: KlemsBasis,
    scattered: KlemsBasis,
    /// Photopic values.
    values: Words<f32>,
    /// CIE X and Z in the order of `values`.
    chromatic: Option<[Words<f32>; 2]>,
    /// By sense, made when first asked for: loading a matrix would take twice as long with them.
    totals: [OnceLock<RowTotals>; 2],
    sums: [OnceLock<RunningSums>; 2],
}

/// The role of a direction in a pair, which decides how it is numbered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Role {
    Incident,
    Scattered,
}

/// A vector pointing away from the surface ↔ the same in basis form (upper hemisphere).
///
/// Scattered light keeps (x, y); incident light is numbered by where it travels to, (−x, −y).
#[inline]
fn basis_form(w: DVec3, role: Role) -> DVec3 {
    DVec3::new(role.sign() * w.x, role.sign() * w.y, w.z.abs())
}

impl Role {
    #[inline]
    pub(super) fn sign(self) -> f64 {
        match self {
            Self::Scattered => 1.0,
            Self::Incident => -1.0,
        }
    }
}

impl KlemsMatrix {
    /// A colourless matrix.
    ///
    /// Errors: argument: a count that does not fit the bases, a value that is negative or not
    /// finite.
    pub fn new(incident: KlemsBasis, scattered: KlemsBasis, values: Vec<f32>) -> Result<Self> {
        Self::of_words(incident, scattered, values.into(), None)
    }

    /// The same of arrays that may lie in a file; `chromatic`: CIE X and Z.
    pub(crate) fn of_words(
        incident: KlemsBasis,
        scattered: KlemsBasis,
        values: Words<f32>,
        chromatic: Option<[Words<f32>; 2]>,
    ) -> Result<Self> {
        for channel in [&values].into_iter().chain(chromatic.iter().flatten()) {
            Self::check(&incident, &scattered, channel)?;
        }
        let (totals, sums) = Default::default();
        Ok(Self { incident, scattered, values, chromatic, totals, sums })
    }

    /// The same matrix with colour: CIE X and Z in the order of the photopic values.
    ///
    /// Errors: as [`KlemsMatrix::new`].
    pub fn with_colour(self, x: Vec<f32>, z: Vec<f32>) -> Result<Self> {
        let chromatic = Some([x.into(), z.into()]);
        Self::of_words(self.incident, self.scattered, self.values, chromatic)
    }

    fn check(incident: &KlemsBasis, scattered: &KlemsBasis, values: &[f32]) -> Result<()> {
        let (rows, columns) = (incident.directions(), scattered.directions());
        if rows.checked_mul(columns) != Some(values.len()) {
            let text =
                format!("matrix: expected {rows} × {columns} values, found {}", values.len());
            return Err(Error::argument(text));
        }
        // The highest bit of these is set for what is negative, infinite or NaN: no branch, as loops of
        // vector instructions want it. -0 is set too, and found to be sound below.
        let marks = |bits: u32| bits | f32::MAX.to_bits().wrapping_sub(bits);
        if values.iter().fold(0, |any, v| any | marks(v.to_bits())) >> 31 == 0 {
            return Ok(());
        }
        match values.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
            None => Ok(()),
            Some(at) => Err(Error::argument(format!(
                "matrix: expected finite values of at least 0, found {} at incident {}, scattered {}",
                values[at],
                at / columns,
                at % columns
            ))),
        }
    }

    /// The basis of incident directions.
    pub fn incident(&self) -> &KlemsBasis {
        &self.incident
    }

    /// The basis of scattered directions.
    pub fn scattered(&self) -> &KlemsBasis {
        &self.scattered
    }

    /// Photopic values, 1/sr, row-major (incident, scattered).
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// CIE X and Z, in the order of [`KlemsMatrix::values`].
    pub fn chromatic(&self) -> Option<[&[f32]; 2]> {
        self.chromatic.as_ref().map(|[x, z]| [&**x, &**z])
    }

    /// Patches of a pair of directions that point away from the surface.
    #[inline]
    fn entry(&self, wi: DVec3, wo: DVec3) -> Option<usize> {
        let i = self.incident.index(basis_form(wi, Role::Incident))?;
        let o = self.scattered.index(basis_form(wo, Role::Scattered))?;
        Some(i * self.scattered.directions() + o)
    }

    #[inline]
    fn xyz(&self, entry: usize) -> Xyz {
        let y = f64::from(self.values[entry]);
        match &self.chromatic {
            None => Xyz::grey(y),
            Some([x, z]) => Xyz::new(f64::from(x[entry]), y, f64::from(z[entry])),
        }
    }

    /// The bases and roles of the known and the other direction.
    pub(super) fn sides(&self, sense: Sense) -> [(&KlemsBasis, Role); 2] {
        let incident = (&self.incident, Role::Incident);
        let scattered = (&self.scattered, Role::Scattered);
        match sense {
            Sense::Forward => [incident, scattered],
            Sense::Reverse => [scattered, incident],
        }
    }

    /// Values with the known direction as row, the number of rows, and the basis of the other.
    fn seen(&self, sense: Sense) -> (Rows<'_>, usize, &KlemsBasis) {
        let [(known, _), (other, _)] = self.sides(sense);
        let columns = self.scattered.directions();
        let strides = match sense {
            Sense::Forward => [columns, 1],
            Sense::Reverse => [1, columns],
        };
        (Rows { values: &self.values, strides }, known.directions(), other)
    }

    /// Totals along the other direction.
    pub(super) fn totals_of(&self, sense: Sense) -> &RowTotals {
        let (values, rows, basis) = self.seen(sense);
        self.totals[sense as usize].get_or_init(|| RowTotals::new(values, rows, basis))
    }

    /// What the other direction is drawn from.
    pub(super) fn draw(&self, sense: Sense) -> Draw<'_> {
        let (values, rows, basis) = self.seen(sense);
        let new = || RunningSums::new(values, rows, basis);
        let sums = self.sums[sense as usize].get_or_init(new);
        Draw { values, totals: self.totals_of(sense), sums }
    }

    /// The row of the known direction.
    fn row(&self, known: DVec3, sense: Sense) -> Option<usize> {
        let [(basis, role), _] = self.sides(sense);
        basis.index(basis_form(known, role))
    }
}

impl Distribution for KlemsMatrix {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        match self.entry(wi, wo) {
            Some(entry) => f64::from(self.values[entry]),
            None => nan_or_zero(wi + wo),
        }
    }

    fn values(&self, wi: Lanes<'_>, wo: Lanes<'_>, out: &mut [f64]) {
        widest(Values { matrix: self, wi, wo, out });
    }

    fn value_xyz(&self, wi: DVec3, wo: DVec3) -> Xyz {
        match self.entry(wi, wo) {
            Some(entry) => self.xyz(entry),
            None => Xyz::grey(nan_or_zero(wi + wo)),
        }
    }

    fn is_coloured(&self) -> bool {
        self.chromatic.is_some()
    }

    /// The smallest value (of each sharp RGB channel), if it is worth a Lambertian part.
    fn constant_part(&self) -> Xyz {
        // The bits of positive numbers are in the order of the numbers.
        let bits = self.values.iter().map(|v| v.abs().to_bits());
        let least = f32::from_bits(bits.fold(f32::INFINITY.to_bits(), u32::min));
        let mut floor = Xyz::grey(f64::from(least));
        if self.is_coloured() {
            let mut channels = [f64::INFINITY; 3];
            for entry in 0..self.values.len() {
                for (least, c) in channels.iter_mut().zip(self.xyz(entry).to_sharp_rgb()) {
                    *least = least.min(c);
                }
            }
            floor = Xyz::from_sharp_rgb(channels.map(|c| c.max(0.0)));
            floor.y = floor.y.min(f64::from(least));
        }
        // Directions beyond an incomplete basis have no data, hence no constant either.
        let complete = self.incident.is_complete() && self.scattered.is_complete();
        if complete && floor.y > LAMBERTIAN_THRESHOLD { floor } else { Xyz::ZERO }
    }

    fn total(&self, known: DVec3, sense: Sense, floor: f64) -> f64 {
        match self.row(known, sense) {
            Some(row) => self.totals_of(sense).total(row, floor),
            None => nan_or_zero(known),
        }
    }

    fn totals(&self, known: Lanes<'_>, sense: Sense, floor: f64, out: &mut [f64]) {
        widest(Totals { matrix: self, known, sense, floor, out });
    }

    fn patches(&self, sense: Sense) -> Option<(&KlemsBasis, f64)> {
        let [(basis, role), _] = self.sides(sense);
        Some((basis, role.sign()))
    }

    fn totals_by_patch(&self, sense: Sense, floor: f64, out: &mut [f64]) {
        let totals = self.totals_of(sense);
        for (row, out) in out.iter_mut().enumerate() {
            *out = totals.total(row, floor);
        }
    }

    /// Needs no running sums, which take longer.
    fn max_total(&self, floor: f64) -> f64 {
        let omega = self.scattered.projected_solid_angles();
        let rows = self.values.chunks_exact(omega.len());
        rows.map(|row| weighted_sum(row, &omega, floor)).fold(0.0, f64::max)
    }

    /// Asks no more rows than it takes.
    fn is_negligible(&self, floor: f64) -> bool {
        let omega = self.scattered.projected_solid_angles();
        let mut rows = self.values.chunks_exact(omega.len());
        rows.all(|row| weighted_sum(row, &omega, floor) <= NEGLIGIBLE_TOTAL)
    }

    /// Patches follow each other in index order; inside a patch `u` follows the Hilbert curve.
    fn sample(&self, known: DVec3, sense: Sense, floor: f64, u: f64) -> Option<DVec2> {
        let (draw, row) = (self.draw(sense), self.row(known, sense)?);
        let (patch, rest) = draw.sample(row, floor, u)?;
        let [_, (_, role)] = self.sides(sense);
        Some(role.sign() * draw.sums.patch(patch).at(hilbert::unfold(rest)))
    }

    /// A ring by the first number, a patch of it by the second.
    fn sample2(&self, known: DVec3, sense: Sense, floor: f64, u: DVec2) -> Option<DVec2> {
        let (draw, row) = (self.draw(sense), self.row(known, sense)?);
        let (patch, point) = draw.sample2(row, floor, u)?;
        let [_, (_, role)] = self.sides(sense);
        Some(role.sign() * draw.sums.patch(patch).at(point))
    }

    fn samples2(
        &self,
        known: Lanes<'_>,
        sense: Sense,
        floor: f64,
        u: &[DVec2],
        out: &mut [Option<DVec2>],
    ) {
        widest(Samples { matrix: self, known, sense, floor, u, out });
    }

    fn samples(
        &self,
        known: Lanes<'_>,
        sense: Sense,
        floor: f64,
        u: &[f64],
        out: &mut [Option<DVec2>],
    ) {
        widest(Samples { matrix: self, known, sense, floor, u, out });
    }

    /// Of the two patches that a pair hits; with `known` alone, of its own patch.
    fn projected_solid_angle(
        &self,
        known: DVec3,
        other: Option<DVec3>,
        sense: Sense,
    ) -> Option<(f64, f64)> {
        let [known_side, other_side] = self.sides(sense);
        let omega = |(basis, role): (&KlemsBasis, Role), w| {
            basis.index(basis_form(w, role)).map(|k| basis.projected_solid_angle(k))
        };
        let known = omega(known_side, known)?;
        let Some(other) = other else { return Some((known, known)) };
        let other = omega(other_side, other)?;
        Some((known.min(other), known.max(other)))
    }

    fn min_projected_solid_angle(&self) -> f64 {
        let least = |basis: &KlemsBasis| basis.projected_solid_angle_range().0;
        least(&self.incident).min(least(&self.scattered))
    }
}

/// Σ (f − floor) Ω of a row, in eight sums side by side.
fn weighted_sum(row: &[f32], omega: &[f64], floor: f64) -> f64 {
    let term = |v: f32, omega: f64| (f64::from(v) - floor) * omega;
    let (rows, row_end) = row.as_chunks::<8>();
    let (omegas, omega_end) = omega.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (row, omega) in rows.iter().zip(omegas) {
        for k in 0..8 {
            sums[k] += term(row[k], omega[k]);
        }
    }
    let end = row_end.iter().zip(omega_end).map(|(v, omega)| term(*v, *omega));
    sums.iter().sum::<f64>() + end.sum::<f64>()
}

/// What a direction without data gives: NaN for NaN, else 0.
pub(super) fn nan_or_zero(w: DVec3) -> f64 {
    if w.is_nan() { f64::NAN } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_sphere::direction::from_degrees;

    /// Value = its own number, so that a lookup tells which entry it found.
    fn numbered() -> KlemsMatrix {
        let basis = KlemsBasis::full();
        let values = (0..145 * 145).map(|n| n as f32).collect();
        KlemsMatrix::new(basis.clone(), basis, values).unwrap()
    }

    #[test]
    fn mirror_and_straight_lie_on_the_diagonal() {
        let m = numbered();
        let wi = from_degrees(70.0, 10.0);
        assert_eq!(m.value(wi, from_degrees(70.0, 190.0)), f64::from(125 * 145 + 125));
        assert_eq!(m.value(wi, -wi), f64::from(125 * 145 + 125));
        // Travel direction of (20°, 45°) is column 19, the scattered direction row 65.
        let (wi, wo) = (from_degrees(20.0, 45.0), from_degrees(40.0, 300.0));
        assert_eq!(m.value(wi, wo), f64::from(19 * 145 + 65));
    }

    #[test]
    fn nan_gives_nan_and_grazing_has_data() {
        let m = numbered();
        assert!(m.value(DVec3::NAN, DVec3::Z).is_nan());
        assert!(m.total(DVec3::NAN, Sense::Forward, 0.0).is_nan());
        assert_eq!(m.sample(DVec3::NAN, Sense::Forward, 0.0, 0.5), None);
        assert!(m.value(DVec3::X, DVec3::Y) > 0.0);
    }

    #[test]
    fn counts_and_values_are_checked() {
        let basis = KlemsBasis::quarter();
        let error = |values| {
            KlemsMatrix::new(basis.clone(), basis.clone(), values).unwrap_err().to_string()
        };
        assert_eq!(error(vec![0.0; 40]), "matrix: expected 41 × 41 values, found 40");
        let mut values = vec![0.0; 1681];
        values[42] = -1.0;
        assert!(error(values).ends_with("found -1 at incident 1, scattered 1"));
    }
}
