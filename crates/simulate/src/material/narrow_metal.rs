//! A finely ground metal: a peak of a few degrees along its grain's X, of some more along Y, askew to the sample.

use bsdfkit_sphere::{DVec3, Side};

use super::{Material, RotatedMetal, SymmetryHint};

/// [`RotatedMetal`] of a quarter of its usual roughness, its grain on the other side.
#[derive(Clone, Debug)]
pub struct NarrowMetal(pub RotatedMetal);

impl Default for NarrowMetal {
    fn default() -> Self {
        Self(RotatedMetal {
            roughness_x: 0.025,
            roughness_y: 0.09,
            rotation_degrees: -35.0,
            reflectance: 0.8,
        })
    }
}

impl Material for NarrowMetal {
    fn name(&self) -> &'static str {
        "narrow-metal"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.0.eval(wi, wo)
    }

    fn scattered(&self) -> Side {
        self.0.scattered()
    }

    fn symmetry(&self) -> SymmetryHint {
        self.0.symmetry()
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        self.0.parameters()
    }
}
