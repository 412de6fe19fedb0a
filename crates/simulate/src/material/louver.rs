//! A louver film: slats close the view at a sharp angle, and then only what they scatter comes through.

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::{DVec3, Side};

use super::optics::{soft_cosine, spherical_gaussian};
use super::{Material, SymmetryHint};

/// Slats along Y that lean toward +X, in a clear film of slight haze.
///
/// f = open V(wi) G(−wi·wo) / s(cos θo) + slats/π (1 − V(wi)) (1 − V(wo)) + diffuse/π, with V the view between the slats,
/// 1 along them and 0 from the cut-off on, G a Gaussian on the sphere and s the softened cosine.
#[derive(Clone, Debug)]
pub struct Louver {
    /// How far the slats lean from the normal toward +X.
    pub lean_degrees: f64,
    /// Tangent, measured from the slats' lean across them, at which the view closes.
    pub cut_off: f64,
    /// Part of the way to the cut-off, at its end, over which the view closes.
    pub closing: f64,
    /// Transmittance along the slats.
    pub open: f64,
    /// Width of the beam.
    pub beam_degrees: f64,
    /// How much of what meets slats on both its ways is scattered.
    pub slats: f64,
    /// Lambertian transmittance of the film's haze.
    pub diffuse: f64,
}

impl Default for Louver {
    fn default() -> Self {
        Self {
            lean_degrees: 8.0,
            cut_off: 0.75,
            closing: 0.4,
            open: 0.7,
            beam_degrees: 2.5,
            slats: 0.12,
            diffuse: 0.03,
        }
    }
}

impl Louver {
    /// How far the view between the slats is open along the line of `w`, 0 to 1.
    fn view(&self, w: DVec3) -> f64 {
        let across = (w.x / w.z - self.lean_degrees.to_radians().tan()).abs() / self.cut_off;
        ((1.0 - across) / self.closing).clamp(0.0, 1.0)
    }
}

impl Material for Louver {
    fn name(&self) -> &'static str {
        "louver"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z >= 0.0 {
            return 0.0;
        }
        let beam =
            spherical_gaussian(-wi.dot(wo), self.beam_degrees.to_radians()) / soft_cosine(wo.z);
        let (there, out) = (self.view(wi), self.view(wo));
        self.open * there * beam
            + FRAC_1_PI * (self.slats * (1.0 - there) * (1.0 - out) + self.diffuse)
    }

    fn scattered(&self) -> Side {
        Side::Back
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Bilateral
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("lean_degrees", self.lean_degrees),
            ("cut_off", self.cut_off),
            ("closing", self.closing),
            ("open", self.open),
            ("beam_degrees", self.beam_degrees),
            ("slats", self.slats),
            ("diffuse", self.diffuse),
        ]
    }
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::direction::from_degrees;

    use super::*;

    #[test]
    fn the_view_closes_at_the_cut_off_on_either_side() {
        let m = Louver::default();
        let lean = 8.0f64.to_radians().tan();
        for (tangent, view) in
            [(lean, 1.0), (lean + 0.45, 1.0), (lean + 0.75, 0.0), (lean - 0.6, 0.5)]
        {
            let theta = tangent.atan().to_degrees();
            // the same line from either end
            for w in [from_degrees(theta, 0.0), -from_degrees(theta, 0.0)] {
                assert!((m.view(w) - view).abs() < 1e-12, "{tangent}: {}", m.view(w));
            }
        }
        // along the slats nothing closes
        let along = from_degrees(80.0, 90.0);
        assert_eq!(m.view(along + DVec3::X * along.z * lean), 1.0);
    }
}
