//! `fit`: measurements in, an interpolant out.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use bsdfkit::Error;
use bsdfkit::component::name_of_sides;
use bsdfkit_fit::Cache;
use bsdfkit_fit::interpolant::{FitSettings, Part};
use bsdfkit_fit::specular::Signature;
use bsdfkit_fit::validate::doubt;
use bsdfkit_measure::{ReadOptions, SymmetryKind, components, scant};
use pyo3::prelude::*;

use crate::error::{argument, raised};
use crate::interpolant::{Interpolant, Measured, object};
use crate::watch::watched;

/// One path, or several.
#[derive(FromPyObject)]
pub(crate) enum Paths {
    One(PathBuf),
    Several(Vec<PathBuf>),
}

impl From<Paths> for Vec<PathBuf> {
    fn from(paths: Paths) -> Self {
        match paths {
            Paths::One(path) => vec![path],
            Paths::Several(paths) => paths,
        }
    }
}

/// Fits a continuous BSDF to goniophotometer files.
///
/// Reads Mountain files (pab-opto) and tables with columns theta_i, phi_i, theta_o, phi_o, value, sorts
/// them into reflection and transmission, front and back, and fits each. What the reader merged or
/// left out goes to the logger "bsdfkit"; as warnings, too, where little of the hemisphere was measured, and where the
/// error to expect between incidences (`Component.expected_error`) is large or unknown. Ctrl-C stops the fit.
///
/// Args:
///     paths: A file, a folder, or a list of them: one specimen.
///     symmetry: "isotropic", "quadrilateral", "bilateral", "bilateral-x", "bilateral-y",
///         "rotational180" or "none"; None: what the incidences show.
///     grazing_limit_degrees: Leave out points further than this from the normal; None: keep all.
///     reversed: The specimen was mounted back to front.
///     cache: A folder for finished stages, 2 GB at most: a fit that was stopped, however, goes on where it was, to the same bits.
///     aperture_degrees: Diameter of the cone that the detector sees at once: peaks that are no wider are separated
///         as specular components, which have no width (`Bsdf.specular`). None: nothing is.
///     signature: The same, with a measurement file of the empty beam instead of the aperture.
///     memory: Most gigabytes that the fit may take: components are read and fitted one after the other, and a set of which one
///         does not fit is refused before anything is fitted.
///     progress: None: a tqdm bar on a terminal, if tqdm is installed; True: a bar in any case; False:
///         none; or a function of (done, total).
///
/// Returns:
///     `Interpolant`.
///
/// Raises:
///     IoError: A file cannot be read.
///     FormatError: Its content is wrong, or the incidences cover less than the symmetry needs.
///     LimitError: A component's points do not fit into `memory`.
///     ArgumentError: The data contradict the symmetry, or a setting makes no sense.
#[pyfunction]
#[pyo3(signature = (
    paths, *, symmetry = None, grazing_limit_degrees = None, reversed = false, cache = None, aperture_degrees = None,
    signature = None, memory = 4.0, progress = None
))]
pub(crate) fn fit(
    py: Python<'_>,
    paths: Paths,
    symmetry: Option<&str>,
    grazing_limit_degrees: Option<f64>,
    reversed: bool,
    cache: Option<PathBuf>,
    aperture_degrees: Option<f64>,
    signature: Option<PathBuf>,
    memory: f64,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Py<Interpolant>> {
    let symmetry: Option<SymmetryKind> =
        symmetry.map(str::parse).transpose().map_err(|e| raised(&e))?;
    if grazing_limit_degrees.is_some_and(|d| !(d > 0.0 && d <= 90.0)) {
        return Err(argument("grazing_limit_degrees: expected above 0 and at most 90"));
    }
    let signature = match (aperture_degrees, signature) {
        (Some(_), Some(_)) => {
            return Err(argument("expected aperture_degrees or signature, found both"));
        }
        (Some(degrees), None) => Some(Signature::of_aperture(degrees)),
        (None, Some(file)) => Some(Signature::read(&file)),
        (None, None) => None,
    };
    let signature = signature.transpose().map_err(|e| raised(&e))?;
    let options = ReadOptions { symmetry, reversed, ..ReadOptions::default() };
    let options = options.within((memory * 1e9) as u64).map_err(|e| raised(&e))?;
    let cache = cache.map(|folder| Cache::open(&folder, Cache::USUAL_BYTES));
    let cache = cache.transpose().map_err(|e| raised(&e))?.map(Arc::new);
    let settings = FitSettings { cache, signature, ..FitSettings::default() };
    let measured = Measured { paths: paths.into(), options, grazing_limit_degrees };
    let (interpolant, notes) = watched(py, progress, "fit", |watch| {
        let mut fitted = bsdfkit_fit::interpolant::Interpolant::default();
        let (mut notes, mut doubts) = (Vec::new(), Vec::new());
        let heard = |_, _| match watch.cancel {
            Some(flag) if flag.load(Ordering::Relaxed) => Err(Error::limit("cancelled")),
            _ => Ok(()),
        };
        for m in components(&measured.paths, &measured.options, &heard)? {
            let m = measured.cut(m?)?;
            let place = name_of_sides(m.incident, m.scattered);
            notes.extend(m.notes.iter().cloned());
            doubts.extend(scant(&m.sights()).iter().map(|s| format!("{place}: {s}")));
            let one = bsdfkit_fit::interpolant::Interpolant::fit_owned(vec![m], &settings, watch)?;
            if let Some(Part::Transported(c)) = one.components.first() {
                doubts.extend(doubt(c).map(|d| format!("{place}: {d}")));
            }
            fitted.join(one);
        }
        Ok((fitted, (notes, doubts)))
    })?;
    let (notes, doubts) = notes;
    let logger = py.import("logging")?.call_method1("getLogger", ("bsdfkit",))?;
    for note in notes {
        logger.call_method1("info", ("%s", note))?;
    }
    for doubt in doubts {
        logger.call_method1("warning", ("%s", doubt))?;
    }
    object(py, interpolant, Some(measured))
}
