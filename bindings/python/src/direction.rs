//! Directions from and to angles.

use bsdfkit_sphere::direction::{from_degrees, to_degrees};
use glam::DVec3;
use pyo3::prelude::*;

use crate::array::{Argument, Output, broadcast};

/// Unit vectors from polar angles: (sin θ cos φ, sin θ sin φ, cos θ).
///
/// Convention: θ counts from the front normal +Z, φ from +X toward +Y.
///
/// Args:
///     theta_degrees: Polar angle in degrees, 0 to 180; shape (...).
///     phi_degrees: Azimuth in degrees; shape (...), broadcast with `theta_degrees`.
///
/// Returns:
///     Array of shape (..., 3).
#[pyfunction]
pub(crate) fn direction<'py>(
    py: Python<'py>,
    theta_degrees: &Bound<'py, PyAny>,
    phi_degrees: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let (theta, phi) = (Argument::numbers(theta_degrees)?, Argument::numbers(phi_degrees)?);
    let shape = broadcast(&[("theta_degrees", &theta), ("phi_degrees", &phi)])?;
    let mut output = Output::new(py, &shape, Some(3))?;
    let (theta, phi) = (theta.expanded(&shape)?, phi.expanded(&shape)?);
    let angles = theta.iter().cycle().zip(phi.iter().cycle());
    for (w, (&theta, &phi)) in output.numbers()?.chunks_exact_mut(3).zip(angles) {
        w.copy_from_slice(&from_degrees(theta, phi).to_array());
    }
    output.finish()
}

/// Polar angles of directions, the inverse of `direction`.
///
/// Args:
///     w: Directions, shape (..., 3).
///
/// Returns:
///     (theta_degrees, phi_degrees), each of shape (...): θ in [0, 180], φ in [0, 360).
#[pyfunction]
pub(crate) fn angles<'py>(
    py: Python<'py>,
    w: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let w = Argument::directions("w", w)?;
    let shape = broadcast(&[("w", &w)])?;
    let (mut theta, mut phi) = (Output::new(py, &shape, None)?, Output::new(py, &shape, None)?);
    let w = w.expanded(&shape)?;
    let angles = theta.numbers()?.iter_mut().zip(phi.numbers()?);
    for ((theta, phi), w) in angles.zip(w.chunks_exact(3)) {
        (*theta, *phi) = to_degrees(DVec3::from_slice(w));
    }
    Ok((theta.finish()?, phi.finish()?))
}
