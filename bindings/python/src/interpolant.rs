//! The class `Interpolant`: a continuous BSDF made of measurements.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use bsdfkit::spectrum::View;
use bsdfkit::{Error, Result};
use bsdfkit_fit::deliver::Subject;
use bsdfkit_fit::interpolant::{self, Encoding, Part};
use bsdfkit_fit::survey;
use bsdfkit_measure::{Measurement, ReadOptions};
use bsdfkit_represent::tabulate::disagreement;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::bsdf::Bsdf;
use crate::error::{argument, raised};
use crate::fit::Paths;
use crate::look;
use crate::material::{Component, side_name};
use crate::tabulate::{Labels, Wanted, save_rgl, tabulated};
use crate::validation::{Validation, proposal};
use crate::watch::watched;

/// A continuous BSDF over all directions, made of measurements by displacement interpolation.
///
/// Answers all verbs of `Bsdf`, from the continuous function: 5 to 50 µs an incident direction and 0.5 µs a value of it,
/// totals, samples and pdf some ms more for each incident direction. Keep equal incident directions
/// together, or tabulate. Sides that were not measured are dark. The weights of samples vary, as they are
/// drawn from a table near f; `projected_solid_angle` is that of the table's cells.
#[pyclass(frozen, extends = Bsdf, module = "bsdfkit")]
pub(crate) struct Interpolant {
    interpolant: interpolant::Interpolant,
    /// The files that it was fitted to.
    measured: Option<Measured>,
}

/// Where measurements are, and how they are read.
#[derive(Clone)]
pub(crate) struct Measured {
    pub(crate) paths: Vec<PathBuf>,
    pub(crate) options: ReadOptions,
    pub(crate) grazing_limit_degrees: Option<f64>,
}

impl Measured {
    /// Reads them.
    pub(crate) fn read(&self) -> Result<Vec<Measurement>> {
        let read = bsdfkit_measure::read(&self.paths, &self.options)?;
        read.into_iter().map(|m| self.cut(m)).collect()
    }

    /// Without points beyond the limit.
    pub(crate) fn cut(&self, mut m: Measurement) -> Result<Measurement> {
        if let Some(degrees) = self.grazing_limit_degrees {
            m.cut_grazing(degrees)?;
        }
        Ok(m)
    }
}

/// The Python object of an interpolant.
pub(crate) fn object(
    py: Python<'_>,
    interpolant: interpolant::Interpolant,
    measured: Option<Measured>,
) -> PyResult<Py<Interpolant>> {
    let bsdf = Bsdf::from(interpolant.bsdf());
    Py::new(py, PyClassInitializer::from(bsdf).add_subclass(Interpolant { interpolant, measured }))
}

impl Interpolant {
    fn described(&self) -> bsdfkit::Metadata {
        let name = self.interpolant.name.clone().unwrap_or_default();
        bsdfkit::Metadata { name, ..bsdfkit::Metadata::default() }
    }

    /// A part that was fitted here.
    fn transported(
        &self,
        incident: &str,
        scattered: &str,
    ) -> PyResult<Arc<interpolant::Component>> {
        let pair = (look::side("incident", incident)?, look::side("scattered", scattered)?);
        match self.interpolant.part(pair.0, pair.1) {
            Some(Part::Transported(c)) => Ok(c.clone()),
            _ => Err(argument(format!(
                "expected sides that were fitted here, found {incident} to {scattered}"
            ))),
        }
    }

    /// Each part that was fitted here, with its measurement.
    fn measured(
        &self,
        paths: Option<Paths>,
    ) -> Result<Vec<(Arc<interpolant::Component>, Measurement)>> {
        let measured = match (paths, &self.measured) {
            (Some(paths), Some(known)) => Measured { paths: paths.into(), ..known.clone() },
            (Some(paths), None) => Measured {
                paths: paths.into(),
                options: ReadOptions::default(),
                grazing_limit_degrees: None,
            },
            (None, Some(known)) => known.clone(),
            (None, None) => {
                return Err(Error::argument(
                    "paths: expected the files that the interpolant was fitted to, found none",
                ));
            }
        };
        let mut found = Vec::new();
        for m in measured.read()? {
            let Some(Part::Transported(c)) = self.interpolant.part(m.incident, m.scattered) else {
                return Err(Error::argument(format!(
                    "paths: expected measurements of the interpolant's sides, found {} to {}",
                    side_name(m.incident),
                    side_name(m.scattered)
                )));
            };
            found.push((c.clone(), m));
        }
        Ok(found)
    }
}

#[pymethods]
impl Interpolant {
    /// The same material, of which queries and tables have what `view` makes of its bands.
    ///
    /// Args:
    ///     view: "photopic", "melanopic", "xyz" or "colour" (each alone, in daylight, or with "-d65", "-a", "-e"), "solar", "nir", "mean", or a
    ///         wavelength as "550nm". Colour is adapted to equal energy: what is neutral has X = Y = Z.
    ///
    /// Returns:
    ///     An `Interpolant` that shares what was fitted.
    ///
    /// Raises:
    ///     ArgumentError: No bands, another name, or bands that do not reach as far.
    fn seen_as(&self, py: Python<'_>, view: &str) -> PyResult<Py<Interpolant>> {
        let view: View = view.parse().map_err(|e| raised(&e))?;
        let seen = self.interpolant.seen_as(view).map_err(|e| raised(&e))?;
        object(py, seen, self.measured.clone())
    }

    /// Predicts every measured incidence from the others: how far to trust what lies between.
    ///
    /// Args:
    ///     paths: The files that it was fitted to; None: those given to `fit`, which are read again.
    ///     progress: As for `fit`.
    ///
    /// Returns:
    ///     A list of `Validation`, one for each pair of sides.
    ///
    /// Raises:
    ///     ArgumentError: Fewer than three incidences, other files than those fitted, or none known.
    #[pyo3(signature = (paths = None, *, progress = None))]
    fn validate(
        &self,
        py: Python<'_>,
        paths: Option<Paths>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<Validation>> {
        watched(py, progress, "leave out", |watch| {
            let measured = self.measured(paths)?;
            measured.iter().map(|(c, m)| Validation::of(m, c, watch)).collect()
        })
    }

    /// Proposes the next incident directions to measure, most useful first.
    ///
    /// Args:
    ///     budget: How many, for each side that was lit.
    ///     paths: As for `validate`.
    ///     max_theta_degrees: Largest incident angle from the normal that the instrument reaches; None: the
    ///         largest measured.
    ///     spacing_degrees: Least distance between incident directions.
    ///     progress: As for `fit`.
    ///
    /// Returns:
    ///     A list of `Proposal`.
    ///
    /// Raises:
    ///     ArgumentError: As `validate`, or a setting makes no sense.
    #[pyo3(signature = (
        budget = 6, *, paths = None, max_theta_degrees = None, spacing_degrees = 4.0, progress = None
    ))]
    fn plan<'py>(
        &self,
        py: Python<'py>,
        budget: usize,
        paths: Option<Paths>,
        max_theta_degrees: Option<f64>,
        spacing_degrees: f64,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let proposals = watched(py, progress, "proposals", |watch| {
            let measured = self.measured(paths)?;
            survey::next(&measured, max_theta_degrees, spacing_degrees, budget, watch)
        })?;
        proposals.iter().map(|p| proposal(py, p)).collect()
    }

    /// Averages the continuous BSDF over the cells of a tensor tree or of a Klems matrix, or makes the render form of
    /// it; as `Bsdf.tabulate`.
    #[pyo3(signature = (
        kind = None, *, consumer = None, max_error = None, max_leaves = None, max_depth = None,
        reciprocity = None, name = None, manufacturer = None, thickness = None, width = None, height = None,
        properties = None, progress = None
    ))]
    fn tabulate(
        &self,
        py: Python<'_>,
        kind: Option<&str>,
        consumer: Option<&str>,
        max_error: Option<f64>,
        max_leaves: Option<usize>,
        max_depth: Option<u32>,
        reciprocity: Option<&str>,
        name: Option<String>,
        manufacturer: Option<String>,
        thickness: Option<f64>,
        width: Option<f64>,
        height: Option<f64>,
        properties: Option<BTreeMap<String, String>>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Bsdf> {
        let wanted = Wanted { kind, consumer, max_error, max_leaves, max_depth, reciprocity };
        let labels = Labels { name, manufacturer, thickness, width, height, properties };
        let subject = Subject::Continuous(&self.interpolant);
        tabulated(py, subject, &wanted, labels.over(self.described())?, progress)
    }

    /// What was fitted for one pair of sides: the measured incidences, how well each was met, and their mesh.
    ///
    /// Args:
    ///     incident: "front" or "back".
    ///     scattered: "front" or "back".
    ///
    /// Returns:
    ///     A dict. Of the N incidences: "wi" (N, 3), "points", "lobes", "fit_l1" (L1 distance of the model from the points), "seen" (share of the
    ///     projected hemisphere), "hemispherical", "limit_degrees" (largest measured polar angle). Of the mesh: "vertices" (V, 3), "incidence" (V,) (the
    ///     row of which each is an image), "triangles" (T, 3), "edges" (E, 2), "edge_paths" (E, 13, 3) (directions along each); an isotropic specimen has edges only. "symmetry", "expected_l1" (half-way between
    ///     incidences, or None), "extrapolated" and "incidence_extrapolated" (shares of all pairs, and of incident directions).
    ///
    /// Raises:
    ///     ArgumentError: That pair was not fitted here.
    fn fitted<'py>(
        &self,
        py: Python<'py>,
        incident: &str,
        scattered: &str,
    ) -> PyResult<Bound<'py, PyDict>> {
        look::fitted(py, &*self.transported(incident, scattered)?)
    }

    /// Where the families are, peaks that are followed over all incident directions; the brightest first.
    ///
    /// Args:
    ///     wi: Incident directions, shape (..., 3), on side `incident`.
    ///     incident: "front" or "back".
    ///     scattered: "front" or "back".
    ///
    /// Returns:
    ///     (centres, covariances): directions, shape (..., K, 3), and xx, xy, yy in the plane of direction cosines, (..., K, 3); NaN where a
    ///     family is below the horizon.
    ///
    /// Raises:
    ///     ArgumentError: That pair was not fitted here.
    fn families<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        incident: &str,
        scattered: &str,
    ) -> PyResult<Bound<'py, PyTuple>> {
        look::families(py, &*self.transported(incident, scattered)?, wi)
    }

    /// How the values of pairs of directions were come by: 0 measured, 1 interpolated, 2 extrapolated.
    ///
    /// Args:
    ///     wi: Incident directions, shape (..., 3), all on one side.
    ///     wo: Scattered directions, shape (..., 3), all on one side.
    ///     incident: That of `wi`.
    ///     scattered: That of `wo`.
    ///
    /// Raises:
    ///     ArgumentError: That pair of sides was not fitted here.
    fn coverage<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
        incident: &str,
        scattered: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        look::coverage(py, &*self.transported(incident, scattered)?, wi, wo)
    }

    /// As `Bsdf.reciprocity_defect`, over measured directions.
    fn reciprocity_defect(
        &self,
        py: Python<'_>,
        incident: &str,
        scattered: &str,
    ) -> PyResult<Option<f64>> {
        let pair = (look::side("incident", incident)?, look::side("scattered", scattered)?);
        let Some(part) = self.interpolant.part(pair.0, pair.1) else { return Ok(None) };
        Ok(py.detach(|| disagreement(part)))
    }

    /// Writes the interpolant; an existing file is replaced whole or not at all.
    ///
    /// Args:
    ///     path: Ends in .safetensors, or in _rgb.bsdf or _spec.bsdf (as `Bsdf.save`); for XML, `tabulate` first.
    ///     compact: A tenth to a half of the space, values within 2 %.
    ///
    /// Raises:
    ///     ArgumentError: Another suffix.
    ///     IoError: The file cannot be written.
    #[pyo3(signature = (path, *, compact = false))]
    fn save(&self, py: Python<'_>, path: PathBuf, compact: bool) -> PyResult<()> {
        if path.extension().is_some_and(|s| s.eq_ignore_ascii_case("bsdf")) {
            let subject = Subject::Continuous(&self.interpolant);
            return save_rgl(py, subject, &self.described(), &path);
        }
        if path.extension().is_none_or(|s| !s.eq_ignore_ascii_case("safetensors")) {
            return Err(argument(format!(
                "{}: expected a name ending in .safetensors, _rgb.bsdf or _spec.bsdf; for XML, tabulate first",
                path.display()
            )));
        }
        let encoding = if compact { Encoding::Compact } else { Encoding::Plain };
        py.detach(|| self.interpolant.save(&path, encoding)).map_err(|e| raised(&e))
    }

    fn __repr__(&self) -> String {
        let parts = self
            .interpolant
            .bsdf()
            .components()
            .iter()
            .map(|c| {
                let Component { incident, scattered, representation, .. } = c.into();
                format!("{incident} to {scattered}: {representation}")
            })
            .collect::<Vec<_>>();
        let name = self.interpolant.name.as_deref().unwrap_or_default();
        format!("<Interpolant {name:?}, {}>", parts.join(", "))
    }
}
