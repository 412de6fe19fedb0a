//! Ground glass: a rough face that light enters by, a smooth one that it leaves by. [WMLT07]

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::{DVec3, Side};

use super::microfacet::Ggx;
use super::optics::fresnel;
use super::{Material, SymmetryHint};

/// A pane, rough in front.
#[derive(Clone, Debug)]
pub struct RoughDielectric {
    /// Index of refraction.
    pub index: f64,
    /// GGX roughness of the front.
    pub roughness: f64,
    /// Lambertian transmittance of the scattered rest.
    pub diffuse: f64,
}

impl Default for RoughDielectric {
    fn default() -> Self {
        Self { index: 1.5, roughness: 0.25, diffuse: 0.01 }
    }
}

impl Material for RoughDielectric {
    fn name(&self) -> &'static str {
        "rough-dielectric"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z >= 0.0 {
            return 0.0;
        }
        let n = self.index;
        let facets = Ggx { x: self.roughness, y: self.roughness };
        // the direction inside the glass that the smooth face bends to wo
        let flat = wo.truncate() / n;
        let inside = flat.extend(-(1.0 - flat.length_squared()).sqrt());
        let h = -(wi + n * inside).normalize();
        let h = if h.z < 0.0 { -h } else { h };
        let (ci, co) = (wi.dot(h), inside.dot(h));
        let rough = if ci > 0.0 && co < 0.0 {
            let jacobian = (ci * co).abs() * n * n / (ci + n * co).powi(2).max(1e-12);
            let flat = (wi.z * inside.z).abs().max(1e-9);
            jacobian * (1.0 - fresnel(ci, n)) * facets.visible(wi, inside) * facets.density(h)
                / flat
        } else {
            0.0
        };
        // leaving spreads the light over n² the projected solid angle
        rough * (1.0 - fresnel(wo.z, n)) / (n * n) + self.diffuse * FRAC_1_PI
    }

    fn scattered(&self) -> Side {
        Side::Back
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Isotropic
    }

    fn polar_angles(&self) -> Vec<f64> {
        vec![0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 75.0]
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("index", self.index), ("roughness", self.roughness), ("diffuse", self.diffuse)]
    }
}
