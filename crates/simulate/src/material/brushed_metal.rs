//! Brushed metal: an elliptical Gaussian of slopes, energy-bounded at grazing. [War92], [GMD10]

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::{DVec3, Side};

use super::{Material, SymmetryHint};

/// Metal brushed along X: it scatters widely across, narrowly along.
#[derive(Clone, Debug)]
pub struct BrushedMetal {
    /// Root mean square slope along X.
    pub roughness_x: f64,
    /// Root mean square slope along Y.
    pub roughness_y: f64,
    /// Reflectance of the brushed lobe.
    pub specular: f64,
    /// Lambertian reflectance beside it.
    pub diffuse: f64,
}

impl Default for BrushedMetal {
    fn default() -> Self {
        Self { roughness_x: 0.05, roughness_y: 0.25, specular: 0.75, diffuse: 0.05 }
    }
}

impl Material for BrushedMetal {
    fn name(&self) -> &'static str {
        "brushed-metal"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let h = wi + wo;
        let (ax, ay) = (self.roughness_x, self.roughness_y);
        let slope2 = ((h.x / ax).powi(2) + (h.y / ay).powi(2)) / (h.z * h.z);
        let lobe = FRAC_1_PI / (ax * ay) * h.length_squared() / h.z.powi(4) * (-slope2).exp();
        self.specular * lobe + self.diffuse * FRAC_1_PI
    }

    fn scattered(&self) -> Side {
        Side::Front
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Quadrilateral
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("roughness_x", self.roughness_x),
            ("roughness_y", self.roughness_y),
            ("specular", self.specular),
            ("diffuse", self.diffuse),
        ]
    }
}
