//! A rough metal whose grain lies askew to the sample's axes: nothing mirrors it.

use bsdfkit_sphere::{DVec3, Side};

use super::microfacet::Ggx;
use super::optics::{schlick, turn_z};
use super::{Material, SymmetryHint};

/// Anisotropic GGX facets, turned about the normal.
#[derive(Clone, Debug)]
pub struct RotatedMetal {
    /// Roughness along the grain's X.
    pub roughness_x: f64,
    /// Roughness along the grain's Y.
    pub roughness_y: f64,
    /// From the sample's X to the grain's X, counter-clockwise.
    pub rotation_degrees: f64,
    /// Reflectance at normal incidence.
    pub reflectance: f64,
}

impl Default for RotatedMetal {
    fn default() -> Self {
        Self { roughness_x: 0.1, roughness_y: 0.35, rotation_degrees: 25.0, reflectance: 0.9 }
    }
}

impl Material for RotatedMetal {
    fn name(&self) -> &'static str {
        "rotated-metal"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let facets = Ggx { x: self.roughness_x, y: self.roughness_y };
        let [a, b] = [wi, wo].map(|w| turn_z(w, -self.rotation_degrees));
        let h = (a + b).normalize();
        facets.density(h) * facets.visible(a, b) * schlick(a.dot(h), self.reflectance)
            / (4.0 * a.z.max(1e-6) * b.z.max(1e-6))
    }

    fn scattered(&self) -> Side {
        Side::Front
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::None
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("roughness_x", self.roughness_x),
            ("roughness_y", self.roughness_y),
            ("rotation_degrees", self.rotation_degrees),
            ("reflectance", self.reflectance),
        ]
    }
}
