//! A clear pane that is a little hazy: light that goes straight through, and a halo about it.

use bsdfkit_sphere::{DVec3, Side};

use super::optics::{disk_gaussian, fresnel};
use super::peak::Peak;
use super::{Material, SymmetryHint};

/// τ = through · S(cos θi) / S(1) straight through, with S = (1 − F) / (1 + F) of a pane's two surfaces, and
/// f = haze · K(ui + uo), K a Gaussian.
#[derive(Clone, Debug)]
pub struct ClearGlass {
    /// Index of refraction.
    pub index: f64,
    /// Transmittance straight through at normal incidence.
    pub through: f64,
    /// Share of the light in the halo.
    pub haze: f64,
    /// Width of the halo, in direction cosines.
    pub haze_width: f64,
}

impl Default for ClearGlass {
    fn default() -> Self {
        Self { index: 1.52, through: 0.85, haze: 0.05, haze_width: 0.15 }
    }
}

impl Material for ClearGlass {
    fn name(&self) -> &'static str {
        "clear-glass"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z >= 0.0 {
            return 0.0;
        }
        self.haze * disk_gaussian(wi.truncate() + wo.truncate(), self.haze_width)
    }

    fn peaks(&self, wi: DVec3) -> Vec<Peak> {
        if wi.z <= 0.0 {
            return Vec::new();
        }
        let pane = |cosine: f64| {
            let f = fresnel(cosine, self.index);
            (1.0 - f) / (1.0 + f)
        };
        let coefficient = self.through * pane(wi.z) / pane(1.0);
        vec![Peak { wo: -wi, coefficient, width_degrees: 0.0 }]
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
            ("through", self.through),
            ("haze", self.haze),
            ("haze_width", self.haze_width),
        ]
    }
}
