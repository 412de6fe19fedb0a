//! The class `Measurement`: what a goniophotometer's files hold, looked at without a fit.

use bsdfkit_measure::{ReadOptions, SymmetryKind};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::Output;
use crate::error::raised;
use crate::fit::Paths;
use crate::look;
use crate::material::side_name;

/// One pair of sides of a specimen as measured: incident directions, and the points of each.
///
/// Attributes:
///     incident: Side of the incident directions, "front" or "back".
///     scattered: Side of the scattered directions.
///     name: As the files name the specimen; empty when they do not.
///     symmetry: Detected or given: "isotropic", "bilateral-x", …
///     colorimetry: What the values of a point are: "luminance", "CIE XYZ", …
///     luminance_channel: Which of the values of a point is, or steers as, the luminance.
///     notes: What the reader merged, dropped or skipped.
#[pyclass(frozen, module = "bsdfkit")]
pub(crate) struct Measurement(pub(crate) bsdfkit_measure::Measurement);

/// Reads goniophotometer files as they are, whatever they lack.
///
/// Args:
///     paths: A file, a folder, or a list of them: one specimen.
///     symmetry: As for `fit`.
///     reversed: The specimen was mounted back to front.
///
/// Returns:
///     A list of `Measurement`, one for each pair of sides.
///
/// Raises:
///     IoError: A file cannot be read.
///     FormatError: Its content is wrong.
///     ArgumentError: The data contradict the symmetry.
#[pyfunction]
#[pyo3(signature = (paths, *, symmetry = None, reversed = false))]
pub(crate) fn read(
    py: Python<'_>,
    paths: Paths,
    symmetry: Option<&str>,
    reversed: bool,
) -> PyResult<Vec<Measurement>> {
    let symmetry: Option<SymmetryKind> =
        symmetry.map(str::parse).transpose().map_err(|e| raised(&e))?;
    let options = ReadOptions { symmetry, reversed, incomplete: true, ..ReadOptions::default() };
    let paths: Vec<_> = paths.into();
    let read = py.detach(|| bsdfkit_measure::read(&paths, &options)).map_err(|e| raised(&e))?;
    Ok(read.into_iter().map(Measurement).collect())
}

#[pymethods]
impl Measurement {
    #[getter]
    fn incident(&self) -> &'static str {
        side_name(self.0.incident)
    }

    #[getter]
    fn scattered(&self) -> &'static str {
        side_name(self.0.scattered)
    }

    #[getter]
    fn name(&self) -> &str {
        self.0.sample_name.as_deref().unwrap_or_default()
    }

    #[getter]
    fn symmetry(&self) -> String {
        self.0.symmetry.to_string()
    }

    #[getter]
    fn colorimetry(&self) -> String {
        self.0.colorimetry.to_string()
    }

    #[getter]
    fn luminance_channel(&self) -> usize {
        self.0.colorimetry.luminance_channel()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.0.notes.clone()
    }

    /// Incident directions, shape (N, 3).
    #[getter]
    fn wi<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut output = Output::new(py, &[self.0.incidences.len()], Some(3))?;
        for (out, i) in output.numbers()?.chunks_exact_mut(3).zip(&self.0.incidences) {
            out.copy_from_slice(&i.wi.to_array());
        }
        output.finish()
    }

    /// The points of one incidence.
    ///
    /// Args:
    ///     incidence: Its row in `wi`.
    ///
    /// Returns:
    ///     (wo, f): scattered directions, shape (M, 3), and luminance in 1/sr without cosine, shape (M,); noise may be
    ///     negative.
    fn points<'py>(
        &self,
        py: Python<'py>,
        incidence: usize,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let Some(of) = self.0.incidences.get(incidence) else {
            let text =
                format!("incidence: expected below {}, found {incidence}", self.0.incidences.len());
            return Err(PyIndexError::new_err(text));
        };
        let mut wo = Output::new(py, &[of.wo.len()], Some(3))?;
        let mut f = Output::new(py, &[of.wo.len()], None)?;
        let points = of.points(self.0.colorimetry.luminance_channel());
        let rows = wo.numbers()?.chunks_exact_mut(3).zip(f.numbers()?);
        for ((wo, f), (w, value)) in rows.zip(points) {
            wo.copy_from_slice(&w.to_array());
            *f = value;
        }
        Ok((wo.finish()?, f.finish()?))
    }

    /// The incidence nearest to an incident direction, seen through the symmetry that brings it nearest.
    ///
    /// Args:
    ///     wi: An incident direction, (x, y, z).
    ///
    /// Returns:
    ///     (incidence, degrees, rows): its row in `wi`, how far its image is from `wi`, and what takes a measured direction
    ///     (x, y) there: [[a, b], [c, d]], x' = a x + b y, y' = c x + d y.
    fn nearest(&self, wi: [f64; 3]) -> (usize, f64, [[f64; 2]; 2]) {
        let wi = bsdfkit::DVec3::from_array(wi);
        let near = |k: usize| {
            let own = self.0.incidences[k].wi;
            let (_, image) = self.0.symmetry.nearest_image(own, wi);
            (image.apply(own).angle_between(wi).to_degrees(), k, image)
        };
        let all = (0..self.0.incidences.len()).map(near);
        let nearest = all.min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map_or((0, f64::NAN, [[1.0, 0.0], [0.0, 1.0]]), |(degrees, k, image)| {
            let rows = [[image.x.x, image.y.x], [image.x.y, image.y.y]];
            (k, degrees, rows)
        })
    }

    /// Coverage and noise of every incidence, as `bsdf info --json` has it: holes, spacing, seen share, noise, totals.
    ///
    /// Returns:
    ///     A dict; what is not known is None.
    fn quality<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let quality = py.detach(|| self.0.quality());
        let text = serde_json::to_string(&quality)
            .map_err(|e| raised(&bsdfkit::Error::argument(format!("quality: {e}"))))?;
        py.import("json")?.call_method1("loads", (text,))
    }

    /// Draws a picture on matplotlib (`pip install 'bsdfkit[plot]'`); `bsdfkit.plot.draw` says more.
    ///
    /// Args:
    ///     kind: One of `bsdfkit.plot.KINDS`.
    ///     options: What that kind takes (`bsdfkit.plot.options`), and output, a file to write.
    ///
    /// Returns:
    ///     The matplotlib figure.
    #[pyo3(signature = (kind = "hemisphere", **options))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        kind: &str,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        look::plot(slf.as_any(), kind, options)
    }

    fn __repr__(&self) -> String {
        let Self(m) = self;
        format!(
            "<Measurement {:?}, {} to {}: {} incidences, {} points>",
            self.name(),
            side_name(m.incident),
            side_name(m.scattered),
            m.incidences.len(),
            m.points()
        )
    }
}
