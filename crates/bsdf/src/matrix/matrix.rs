//! A matrix of values over two Klems bases.

use std::sync::OnceLock;

use super::sample::{Draw, RowTotals, Rows, RunningSums};
use crate::colour::Xyz;
use crate::klems::KlemsBasis;
use crate::lanes::Sense;
use crate::words::Words;
use crate::{DVec3, Error, Result};

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
pub(super) fn basis_form(w: DVec3, role: Role) -> DVec3 {
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
        // The highest bit of these is set for what is negative, infinite or NaN: no branch, as
        // loops of vector instructions want it. -0 is set too, and found to be sound below.
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
    pub(super) fn entry(&self, wi: DVec3, wo: DVec3) -> Option<usize> {
        let i = self.incident.index(basis_form(wi, Role::Incident))?;
        let o = self.scattered.index(basis_form(wo, Role::Scattered))?;
        Some(i * self.scattered.directions() + o)
    }

    #[inline]
    pub(super) fn xyz(&self, entry: usize) -> Xyz {
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
    pub(super) fn seen(&self, sense: Sense) -> (Rows<'_>, usize, &KlemsBasis) {
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
    pub(super) fn row(&self, known: DVec3, sense: Sense) -> Option<usize> {
        let [(basis, role), _] = self.sides(sense);
        basis.index(basis_form(known, role))
    }
}

/// What a direction without data gives: NaN for NaN, else 0.
pub(super) fn nan_or_zero(w: DVec3) -> f64 {
    if w.is_nan() { f64::NAN } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

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
