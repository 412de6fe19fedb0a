//! An engineered diffuser that fills a square of directions, mounted askew.

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::{DVec2, DVec3, Side};

use super::optics::fresnel;
use super::{Material, SymmetryHint};

/// f = T(wi) transmitted E(x) E(y) + diffuse/π, with (x, y) = ui + uo in direction cosines, turned, and E the box from
/// −half to half with soft edges, ½ (tanh((x + half) / 2 edge) − tanh((x − half) / 2 edge)) / 2 half, whose integral is 1.
#[derive(Clone, Debug)]
pub struct SquareDiffuser {
    /// Half of the square's side, in direction cosines.
    pub half: f64,
    /// Softness of its edges, in direction cosines.
    pub edge: f64,
    /// From the sample's X to the square's.
    pub rotation_degrees: f64,
    /// Index of refraction: what the front reflects is lost.
    pub index: f64,
    /// Transmittance into the square, after the front.
    pub transmitted: f64,
    /// Lambertian transmittance beside it.
    pub diffuse: f64,
}

impl Default for SquareDiffuser {
    fn default() -> Self {
        Self {
            half: 0.26,
            edge: 0.02,
            rotation_degrees: 20.0,
            index: 1.5,
            transmitted: 0.85,
            diffuse: 0.03,
        }
    }
}

impl Material for SquareDiffuser {
    fn name(&self) -> &'static str {
        "square-diffuser"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z >= 0.0 {
            return 0.0;
        }
        let axis = DVec2::from_angle(-self.rotation_degrees.to_radians());
        let off = axis.rotate(wi.truncate() + wo.truncate());
        let side = |x: f64| {
            let [far, near] =
                [x + self.half, x - self.half].map(|d| (d / (2.0 * self.edge)).tanh());
            0.5 * (far - near) / (2.0 * self.half)
        };
        let entering = 1.0 - fresnel(wi.z, self.index);
        entering * self.transmitted * side(off.x) * side(off.y) + self.diffuse * FRAC_1_PI
    }

    fn scattered(&self) -> Side {
        Side::Back
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::None
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("half", self.half),
            ("edge", self.edge),
            ("rotation_degrees", self.rotation_degrees),
            ("index", self.index),
            ("transmitted", self.transmitted),
            ("diffuse", self.diffuse),
        ]
    }
}
