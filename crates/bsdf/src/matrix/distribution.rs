//! A matrix as a distribution.

use bsdfkit_sphere::hilbert;
use bsdfkit_sphere::widest::widest;

use super::loops::{Samples, Totals, Values};
use super::matrix::{KlemsMatrix, Role, basis_form, nan_or_zero};
use crate::cell::Cell;
use crate::colour::Xyz;
use crate::distribution::{Distribution, LAMBERTIAN_THRESHOLD, NEGLIGIBLE_TOTAL};
use crate::klems::KlemsBasis;
use crate::lanes::{Lanes, Sense};
use crate::{DVec2, DVec3};

impl Distribution for KlemsMatrix {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        match self.entry(wi, wo) {
            Some(entry) => f64::from(self.values()[entry]),
            None => nan_or_zero(wi + wo),
        }
    }

    fn cells(&self, known: DVec3, sense: Sense, out: &mut Vec<Cell>) -> bool {
        self.patches_of(known, sense, out);
        true
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
        self.chromatic().is_some()
    }

    /// The smallest value (of each sharp RGB channel), if it is worth a Lambertian part.
    fn constant_part(&self) -> Xyz {
        // The bits of positive numbers are in the order of the numbers.
        let bits = self.values().iter().map(|v| v.abs().to_bits());
        let least = f32::from_bits(bits.fold(f32::INFINITY.to_bits(), u32::min));
        let mut floor = Xyz::grey(f64::from(least));
        if self.is_coloured() {
            let mut channels = [f64::INFINITY; 3];
            for entry in 0..self.values().len() {
                for (least, c) in channels.iter_mut().zip(self.xyz(entry).to_sharp_rgb()) {
                    *least = least.min(c);
                }
            }
            floor = Xyz::from_sharp_rgb(channels.map(|c| c.max(0.0)));
            floor.y = floor.y.min(f64::from(least));
        }
        // Directions beyond an incomplete basis have no data, hence no constant either.
        let complete = self.incident().is_complete() && self.scattered().is_complete();
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
        let omega = self.scattered().projected_solid_angles();
        let rows = self.values().chunks_exact(omega.len());
        rows.map(|row| weighted_sum(row, &omega, floor)).fold(0.0, f64::max)
    }

    /// Asks no more rows than it takes.
    fn is_negligible(&self, floor: f64) -> bool {
        let omega = self.scattered().projected_solid_angles();
        let mut rows = self.values().chunks_exact(omega.len());
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
        least(self.incident()).min(least(self.scattered()))
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
}
