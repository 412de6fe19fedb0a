//! What bands are seen as.

use bsdfkit::spectrum::{Bands, View};
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::error::raised;

/// Weights of bands in what an eye, the sun or the body's clock makes of them: `bands @ weights.T`.
///
/// Args:
///     view: "photopic", "melanopic", "xyz", "colour" or "rgb" (each alone, in daylight, or with "-d65", "-a", "-e"), "solar", "nir",
///         "mean", or a wavelength as "550nm". "colour" is CIE X, Y, Z adapted to equal energy: what is neutral has X = Y = Z; "rgb" the same
///         in linear RGB of sRGB's primaries.
///     wavelengths: Of the bands, in nm, rising: `Bsdf.wavelengths`.
///
/// Returns:
///     Shape (1, bands), or (3, bands) of X, Y, Z or R, G, B.
///
/// Raises:
///     ArgumentError: Another name, no row of wavelengths, or bands that do not reach as far as what the view weighs.
#[pyfunction]
pub(crate) fn view_weights<'py>(
    py: Python<'py>,
    view: &str,
    wavelengths: Vec<f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let view: View = view.parse().map_err(|e| raised(&e))?;
    let weights = Bands::new(wavelengths).and_then(|bands| view.weights(&bands));
    let weights = weights.map_err(|e| raised(&e))?;
    Ok(PyArray2::from_vec2(py, weights.rows())?)
}
