//! What is known of an interpolant's errors, at its incidences and anywhere.

use bsdfkit::Result;

use super::error_model::ErrorModel;
use super::validation::Validation;
use crate::interpolant::Component;
use bsdfkit_measure::Measurement;
use bsdfkit_represent::Watch;

/// A component with its errors, left out and to expect.
#[derive(Clone, Debug)]
pub struct Validated {
    /// Every incidence predicted from the others.
    pub validation: Validation,
    /// The error to expect at any incident direction.
    pub model: ErrorModel,
}

impl Validated {
    /// Of `whole`, which was fitted to `m`.
    ///
    /// Errors: as [`Validation::of`].
    /// Cost: that of [`Validation::of`].
    pub fn of(m: &Measurement, whole: &Component, watch: &Watch<'_>) -> Result<Self> {
        let validation = Validation::of(m, whole, watch)?;
        let model = ErrorModel::of(whole, &validation);
        Ok(Self { validation, model })
    }
}
