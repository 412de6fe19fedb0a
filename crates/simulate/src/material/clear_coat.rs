//! A clear coat over brushed metal: a mirror peak that grows, over a streak that fades as the coat mirrors more.

use bsdfkit_sphere::{DVec3, Side};

use super::microfacet::Ggx;
use super::optics::{fresnel, schlick};
use super::{Material, SymmetryHint};

/// GGX facets of a dielectric, over GGX facets of metal brushed along X that see the light refracted.
///
/// f = coat + T(wi) T(wo) / n² · base(wi′, wo′), with T = 1 − F of the flat coat and primes inside it; light that the coat
/// reflects back into itself is lost.
#[derive(Clone, Debug)]
pub struct ClearCoat {
    /// Index of refraction of the coat.
    pub index: f64,
    /// GGX roughness of the coat.
    pub coat_roughness: f64,
    /// Roughness of the base along X.
    pub roughness_x: f64,
    /// Roughness of the base along Y.
    pub roughness_y: f64,
    /// Reflectance of the base at normal incidence.
    pub reflectance: f64,
}

impl Default for ClearCoat {
    fn default() -> Self {
        Self {
            index: 1.5,
            coat_roughness: 0.04,
            roughness_x: 0.07,
            roughness_y: 0.3,
            reflectance: 0.8,
        }
    }
}

impl ClearCoat {
    /// The direction inside the coat.
    fn inside(&self, w: DVec3) -> DVec3 {
        let flat = w.truncate() / self.index;
        flat.extend((1.0 - flat.length_squared()).sqrt())
    }
}

/// Reflection off facets, each of `mirror` (of the cosine at the facet).
fn reflection(facets: Ggx, a: DVec3, b: DVec3, mirror: impl Fn(f64) -> f64) -> f64 {
    let h = (a + b).normalize();
    let flat = 4.0 * a.z.max(1e-6) * b.z.max(1e-6);
    facets.density(h) * facets.visible(a, b) * mirror(a.dot(h)) / flat
}

impl Material for ClearCoat {
    fn name(&self) -> &'static str {
        "clear-coat"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let n = self.index;
        let rough = Ggx { x: self.coat_roughness, y: self.coat_roughness };
        let coat = reflection(rough, wi, wo, |c| fresnel(c, n));
        let brushed = Ggx { x: self.roughness_x, y: self.roughness_y };
        let [a, b] = [wi, wo].map(|w| self.inside(w));
        let base = reflection(brushed, a, b, |c| schlick(c, self.reflectance));
        let through = (1.0 - fresnel(wi.z, n)) * (1.0 - fresnel(wo.z, n)) / (n * n);
        coat + through * base
    }

    fn scattered(&self) -> Side {
        Side::Front
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Quadrilateral
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("index", self.index),
            ("coat_roughness", self.coat_roughness),
            ("roughness_x", self.roughness_x),
            ("roughness_y", self.roughness_y),
            ("reflectance", self.reflectance),
        ]
    }
}
