//! `simulate`: measurements without an instrument.

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use bsdfkit::Error;
use bsdfkit_represent::Progress;
use bsdfkit_simulate::{Goniophotometer, every, write_measurements};
use pyo3::prelude::*;

use crate::watch::watched;

/// Names of the analytic materials.
#[pyfunction]
pub(crate) fn materials() -> Vec<&'static str> {
    every().iter().map(|m| m.name()).collect()
}

/// Measures an analytic material with a virtual goniophotometer.
///
/// Writes one Mountain file an incidence, the truth's parameters among its comments, into a new or
/// empty folder: sweeps over the hemisphere, spirals round the peaks, a hole where the detector
/// would stand in the light, nothing beyond the grazing limit. Settings left out are those of a
/// laboratory's instrument (about 50,000 points an incidence). Ctrl-C stops it after the incidence at hand.
///
/// Args:
///     material: One of `materials()`.
///     folder: Where to write.
///     azimuth_step_degrees: Between incident azimuths.
///     sweeps: Great circles that the detector moves on.
///     points_per_sweep: Points on each.
///     spiral_points: Points of the spiral round the brightest peak.
///     relative_noise: Standard deviation of the noise, as a fraction of the value.
///     absolute_noise: Standard deviation of the noise where there is no light, 1/sr.
///     retro_hole_degrees: Radius of the hole around the light.
///     grazing_limit_degrees: Largest scattered angle from the normal.
///     aperture_degrees: Diameter of the cone that the detector sees at once: widens peaks that have no width.
///     back_to_front: The specimen is mounted back to front, turned about its up axis: its front is seen on the back.
///     seed: The same seed gives the same points and noise.
///     progress: As for `fit`.
///
/// Returns:
///     The files, a list of paths.
///
/// Raises:
///     ArgumentError: No such material, a setting makes no sense, or the folder holds other files.
///     IoError: The folder cannot be written.
#[pyfunction]
#[pyo3(signature = (
    material, folder, *, azimuth_step_degrees = None, sweeps = None, points_per_sweep = None,
    spiral_points = None, relative_noise = None, absolute_noise = None, retro_hole_degrees = None,
    grazing_limit_degrees = None, aperture_degrees = None, back_to_front = false, seed = None, progress = None
))]
pub(crate) fn simulate(
    py: Python<'_>,
    material: &str,
    folder: PathBuf,
    azimuth_step_degrees: Option<f64>,
    sweeps: Option<usize>,
    points_per_sweep: Option<usize>,
    spiral_points: Option<usize>,
    relative_noise: Option<f64>,
    absolute_noise: Option<f64>,
    retro_hole_degrees: Option<f64>,
    grazing_limit_degrees: Option<f64>,
    aperture_degrees: Option<f64>,
    back_to_front: bool,
    seed: Option<u64>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<PathBuf>> {
    let usual = Goniophotometer::default();
    let instrument = Goniophotometer {
        azimuth_step_degrees: azimuth_step_degrees.unwrap_or(usual.azimuth_step_degrees),
        sweeps: sweeps.unwrap_or(usual.sweeps),
        points_per_sweep: points_per_sweep.unwrap_or(usual.points_per_sweep),
        spiral_points: spiral_points.unwrap_or(usual.spiral_points),
        relative_noise: relative_noise.unwrap_or(usual.relative_noise),
        absolute_noise: absolute_noise.unwrap_or(usual.absolute_noise),
        retro_hole_degrees: retro_hole_degrees.unwrap_or(usual.retro_hole_degrees),
        grazing_limit_degrees: grazing_limit_degrees.unwrap_or(usual.grazing_limit_degrees),
        aperture_degrees: aperture_degrees.unwrap_or(usual.aperture_degrees),
        back_to_front,
        seed: seed.unwrap_or(usual.seed),
    };
    let summary = watched(py, progress, material, |watch| {
        let mut all = every();
        let Some(at) = all.iter().position(|m| m.name() == material) else {
            let names: Vec<&str> = all.iter().map(|m| m.name()).collect();
            let names = names.join(", ");
            return Err(Error::argument(format!(
                "material: expected one of {names}, found {material:?}"
            )));
        };
        let chosen = all.swap_remove(at);
        write_measurements(&folder, &*chosen, &instrument, |done, total| {
            if let Some(progress) = watch.progress {
                progress(Progress { done, total });
            }
            let cancelled = watch.cancel.is_some_and(|flag| flag.load(Ordering::Relaxed));
            if cancelled { Err(Error::limit("cancelled")) } else { Ok(()) }
        })
    })?;
    Ok(summary.files)
}
