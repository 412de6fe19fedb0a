//! f in a plane through the normal.

use std::f64::consts::TAU;

use bsdfkit::{Bsdf, DVec3};

use crate::selection::Selection;

/// f(wi, ·) of `selection`, 1/sr, once round in the plane of the normal and azimuth `phi` (degrees): number k is at
/// the angle (k + ½) / `steps` turns from the front normal toward `phi`.
pub(crate) fn values(
    bsdf: &Bsdf,
    wi: DVec3,
    phi: f64,
    selection: &Selection,
    steps: usize,
) -> Vec<f32> {
    let (sin_phi, cos_phi) = phi.to_radians().sin_cos();
    let wo: Vec<DVec3> = (0..steps)
        .map(|k| {
            let (sin, cos) = ((k as f64 + 0.5) / steps as f64 * TAU).sin_cos();
            DVec3::new(sin * cos_phi, sin * sin_phi, cos)
        })
        .collect();
    selection.values(bsdf, wi, &wo).into_iter().map(|f| f as f32).collect()
}
