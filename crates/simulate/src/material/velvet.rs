//! Velvet: brightest at its rim, where the light meets the sides of the pile's hairs, and brushed to one side. [AP07]

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::{DVec3, Side};

use super::optics::turn_y;
use super::{Material, SymmetryHint};

/// An inverted Gaussian of facets over a diffuse ground.
///
/// f = diffuse/π + sheen (1 + 4 exp(−cot² θₕ / spread²) / sin⁴ θₕ) / (π (1 + 4 spread²) 4 (cᵢ + cₒ − cᵢ cₒ)), with θₕ from
/// the lean of the pile to the half vector and c the cosines.
#[derive(Clone, Debug)]
pub struct Velvet {
    /// How far the pile leans toward +X.
    pub lean_degrees: f64,
    /// Root mean square cotangent of the hairs' sides.
    pub spread: f64,
    /// Reflectance of the hairs.
    pub sheen: f64,
    /// Lambertian reflectance of the ground.
    pub diffuse: f64,
}

impl Default for Velvet {
    fn default() -> Self {
        Self { lean_degrees: 15.0, spread: 0.35, sheen: 0.5, diffuse: 0.08 }
    }
}

impl Material for Velvet {
    fn name(&self) -> &'static str {
        "velvet"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let h = turn_y((wi + wo).normalize(), -self.lean_degrees);
        // exp(−cot²/spread²) goes to zero faster than the sine's fourth power
        let sin2 = (1.0 - h.z * h.z).max(1e-6);
        let hairs = 1.0 + 4.0 * (-(h.z * h.z / sin2) / self.spread.powi(2)).exp() / (sin2 * sin2);
        let seen = 4.0 * (wi.z + wo.z - wi.z * wo.z);
        let all = 1.0 + 4.0 * self.spread.powi(2);
        FRAC_1_PI * (self.sheen * hairs / (all * seen) + self.diffuse)
    }

    fn scattered(&self) -> Side {
        Side::Front
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Bilateral
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("lean_degrees", self.lean_degrees),
            ("spread", self.spread),
            ("sheen", self.sheen),
            ("diffuse", self.diffuse),
        ]
    }
}
