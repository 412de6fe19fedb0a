//! A woven fabric: two crossed families of threads, each a long lobe, over a diffuse ground.

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::{DVec3, Side};

use super::microfacet::Ggx;
use super::optics::{schlick, turn_y, turn_z};
use super::{Material, SymmetryHint};

/// Threads at ± `twist_degrees` from X, leaning by `tilt_degrees`.
#[derive(Clone, Debug)]
pub struct Fabric {
    /// Roughness along a thread's X.
    pub roughness_x: f64,
    /// Roughness along a thread's Y.
    pub roughness_y: f64,
    /// Azimuth of either family of threads.
    pub twist_degrees: f64,
    /// How far the threads' normals lean toward X.
    pub tilt_degrees: f64,
    /// Weight of each family's lobe.
    pub specular: f64,
    /// Lambertian reflectance of the ground.
    pub diffuse: f64,
}

impl Default for Fabric {
    fn default() -> Self {
        Self {
            roughness_x: 0.12,
            roughness_y: 0.5,
            twist_degrees: 30.0,
            tilt_degrees: 8.0,
            specular: 0.25,
            diffuse: 0.25,
        }
    }
}

impl Material for Fabric {
    fn name(&self) -> &'static str {
        "fabric"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let threads = Ggx { x: self.roughness_x, y: self.roughness_y };
        let h = (wi + wo).normalize();
        let flat = 4.0 * wi.z.max(1e-3) * wo.z.max(1e-3);
        let family = |twist: f64| {
            let [a, b, h] = [wi, wo, h].map(|w| turn_z(turn_y(w, -self.tilt_degrees), -twist));
            if a.z <= 0.0 || b.z <= 0.0 {
                return 0.0;
            }
            threads.density(h) * threads.visible(a, b)
        };
        let lobes = family(self.twist_degrees) + family(-self.twist_degrees);
        self.specular * lobes * schlick(wi.dot(h), 0.6) / flat + self.diffuse * FRAC_1_PI
    }

    fn scattered(&self) -> Side {
        Side::Front
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Bilateral
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("roughness_x", self.roughness_x),
            ("roughness_y", self.roughness_y),
            ("twist_degrees", self.twist_degrees),
            ("tilt_degrees", self.tilt_degrees),
            ("specular", self.specular),
            ("diffuse", self.diffuse),
        ]
    }
}
