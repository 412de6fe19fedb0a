//! Unit vectors to and from polar angles.

use glam::DVec3;

/// (θ, φ) in degrees → unit vector (sin θ cos φ, sin θ sin φ, cos θ).
///
/// Convention: θ 0..180 from +Z, φ from +X toward +Y.
pub fn from_degrees(theta: f64, phi: f64) -> DVec3 {
    let (st, ct) = theta.to_radians().sin_cos();
    let (sp, cp) = phi.to_radians().sin_cos();
    DVec3::new(st * cp, st * sp, ct)
}

/// Unit vector → (θ, φ) in degrees, θ in \[0, 180\], φ in \[0, 360).
///
/// Accuracy: inverse of [`from_degrees`] to 1e-13 degrees away from the poles; φ is 0 at the poles.
pub fn to_degrees(w: DVec3) -> (f64, f64) {
    let theta = w.x.hypot(w.y).atan2(w.z).to_degrees();
    let phi = w.y.atan2(w.x).to_degrees();
    (theta, if phi < 0.0 { phi + 360.0 } else { phi } % 360.0)
}
