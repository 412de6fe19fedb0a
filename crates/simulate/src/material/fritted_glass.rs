//! Glass printed with frit: a narrow forward beam through the bare part, diffuse light through the print.

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::{DVec3, Side};

use super::optics::{fresnel, soft_cosine, spherical_gaussian};
use super::{Material, SymmetryHint};

/// Bare and printed glass, side by side.
#[derive(Clone, Debug)]
pub struct FrittedGlass {
    /// Index of refraction.
    pub index: f64,
    /// Width of the forward beam.
    pub beam_degrees: f64,
    /// Transmittance of the beam before the surface's reflection.
    pub forward: f64,
    /// Lambertian transmittance of the print before both surfaces' reflection.
    pub diffuse: f64,
}

impl Default for FrittedGlass {
    fn default() -> Self {
        Self { index: 1.52, beam_degrees: 2.0, forward: 0.45, diffuse: 0.3 }
    }
}

impl Material for FrittedGlass {
    fn name(&self) -> &'static str {
        "fritted-glass"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z >= 0.0 {
            return 0.0;
        }
        let entering = 1.0 - fresnel(wi.z, self.index);
        let leaving = 1.0 - fresnel(wo.z, self.index);
        let beam = spherical_gaussian(-wi.dot(wo), self.beam_degrees.to_radians());
        self.forward * entering * beam / soft_cosine(wo.z)
            + self.diffuse * FRAC_1_PI * entering * leaving
    }

    fn scattered(&self) -> Side {
        Side::Back
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Isotropic
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("index", self.index),
            ("beam_degrees", self.beam_degrees),
            ("forward", self.forward),
            ("diffuse", self.diffuse),
        ]
    }
}
