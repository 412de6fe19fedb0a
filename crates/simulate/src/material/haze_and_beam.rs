//! A hazy pane: a narrow beam that is used up on its way, and the wide haze that it turns into.

use bsdfkit_sphere::{DVec3, Side};

use super::optics::disk_gaussian;
use super::{Material, SymmetryHint};

/// With u the direction cosines and b = exp(−depth / cos θi):
/// f = T b K(ui + uo; beam) + T (1 − b) kept K(follows · ui + uo; haze), K Gaussians.
///
/// The beam goes straight through, the haze follows it only in part: two laws, and energy that passes from one to the other.
#[derive(Clone, Debug)]
pub struct HazeAndBeam {
    /// Optical depth of the pane along its normal.
    pub depth: f64,
    /// Transmittance of both together.
    pub transmitted: f64,
    /// Part of the scattered light that comes through.
    pub kept: f64,
    /// Width of the beam, in direction cosines.
    pub beam: f64,
    /// Width of the haze, in direction cosines.
    pub haze: f64,
    /// How far the haze's middle goes with the beam, 0 to 1.
    pub follows: f64,
}

impl Default for HazeAndBeam {
    fn default() -> Self {
        Self { depth: 0.5, transmitted: 0.9, kept: 0.8, beam: 0.035, haze: 0.3, follows: 0.6 }
    }
}

impl Material for HazeAndBeam {
    fn name(&self) -> &'static str {
        "haze-and-beam"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z >= 0.0 {
            return 0.0;
        }
        let (i, o) = (wi.truncate(), wo.truncate());
        let left = (-self.depth / wi.z).exp();
        let beam = left * disk_gaussian(i + o, self.beam);
        let haze = (1.0 - left) * self.kept * disk_gaussian(self.follows * i + o, self.haze);
        self.transmitted * (beam + haze)
    }

    fn scattered(&self) -> Side {
        Side::Back
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Isotropic
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("depth", self.depth),
            ("transmitted", self.transmitted),
            ("kept", self.kept),
            ("beam", self.beam),
            ("haze", self.haze),
            ("follows", self.follows),
        ]
    }
}
