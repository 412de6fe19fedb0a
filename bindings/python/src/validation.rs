//! How far to trust an interpolant, and what to measure next.

use bsdfkit::DVec3;
use bsdfkit_fit::interpolant::Component;
use bsdfkit_fit::survey;
use bsdfkit_fit::validate::{LeftOut, Validated};
use bsdfkit_measure::Measurement;
use bsdfkit_represent::Watch;
use bytemuck::cast_slice;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::array::{Argument, Output, broadcast};
use crate::material::side_name;

/// Every measured incidence of one pair of sides, predicted from the others.
///
/// Attributes:
///     incident: Side of the incident directions, "front" or "back".
///     scattered: Side of the scattered directions.
#[pyclass(frozen, module = "bsdfkit")]
pub(crate) struct Validation {
    #[pyo3(get)]
    incident: &'static str,
    #[pyo3(get)]
    scattered: &'static str,
    validated: Validated,
}

impl Validation {
    /// Of a component, fitted to `m`.
    pub(crate) fn of(
        m: &Measurement,
        whole: &Component,
        watch: &Watch<'_>,
    ) -> bsdfkit::Result<Self> {
        let validated = Validated::of(m, whole, watch)?;
        Ok(Self { incident: side_name(m.incident), scattered: side_name(m.scattered), validated })
    }

    fn left_out(&self) -> &[LeftOut] {
        &self.validated.validation.incidences
    }

    /// One number for each incidence.
    fn each<'py>(
        &self,
        py: Python<'py>,
        of: impl Fn(&LeftOut) -> f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut output = Output::new(py, &[self.left_out().len()], None)?;
        for (out, i) in output.numbers()?.iter_mut().zip(self.left_out()) {
            *out = of(i);
        }
        output.finish()
    }
}

#[pymethods]
impl Validation {
    /// Incident directions, shape (N, 3).
    #[getter]
    fn wi<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut output = Output::new(py, &[self.left_out().len()], Some(3))?;
        for (out, i) in output.numbers()?.chunks_exact_mut(3).zip(self.left_out()) {
            out.copy_from_slice(&i.wi.to_array());
        }
        output.finish()
    }

    /// Share of the light that the others put in a wrong place, doubled: shape (N,).
    #[getter]
    fn l1<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.each(py, |i| i.l1)
    }

    /// The same of the fit at the incidence itself, shape (N,).
    #[getter]
    fn fit_l1<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.each(py, |i| i.fit_l1)
    }

    /// What of both is noise of the measurement, shape (N,).
    #[getter]
    fn noise_l1<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.each(py, |i| i.noise)
    }

    /// Relative error of the directional-hemispherical value, shape (N,).
    #[getter]
    fn hemispherical_error<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.each(py, |i| i.hemispherical_error)
    }

    /// How far the highest peak is missed, in degrees, shape (N,); NaN where there is none.
    #[getter]
    fn peak_offset_degrees<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.each(py, |i| i.peaks.first().map_or(f64::NAN, |p| p.offset_degrees))
    }

    /// The height of the highest peak over the measured one, shape (N,); NaN where there is none.
    #[getter]
    fn peak_height_ratio<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.each(py, |i| i.peaks.first().map_or(f64::NAN, |p| p.height_ratio))
    }

    /// Whether each incidence lies past the rim of the others: a list of N.
    #[getter]
    fn extrapolated(&self) -> Vec<bool> {
        self.left_out().iter().map(|i| i.extrapolated).collect()
    }

    /// The error to expect of the interpolant that has all incidences.
    ///
    /// Args:
    ///     wi: Incident directions, shape (..., 3).
    ///
    /// Returns:
    ///     L1, shape (...).
    fn expected<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let wi = Argument::directions("wi", wi)?;
        let shape = broadcast(&[("wi", &wi)])?;
        let mut output = Output::new(py, &shape, None)?;
        let wi = wi.expanded(&shape)?;
        let (wi, out): (&[f64], _) = (&wi, output.numbers()?);
        let wi: &[DVec3] = cast_slice(wi);
        let at = |(out, wi): (&mut f64, &DVec3)| *out = self.validated.model.at(*wi).l1;
        py.detach(|| out.par_iter_mut().zip(wi).for_each(at));
        output.finish()
    }

    fn __repr__(&self) -> String {
        let mean = |extrapolated| {
            let summary = self.validated.validation.summary(extrapolated);
            summary.map_or(f64::NAN, |s| s.l1)
        };
        format!(
            "<Validation {} to {}: {} incidences, mean L1 {:.4} inside, {:.4} past the rim>",
            self.incident,
            self.scattered,
            self.left_out().len(),
            mean(false),
            mean(true)
        )
    }
}

/// `bsdfkit.Proposal`.
pub(crate) fn proposal<'py>(py: Python<'py>, p: &survey::Proposal) -> PyResult<Bound<'py, PyAny>> {
    let regions: Vec<([f64; 3], f64)> =
        p.regions.iter().map(|r| (r.direction.to_array(), r.radius_degrees)).collect();
    let fields = (p.wi.to_array(), p.expected_l1, p.mean_l1, regions);
    py.import("bsdfkit._types")?.getattr("Proposal")?.call1(fields)
}
