//! A mirror film: a core that few instruments resolve, and a wide halo.

use bsdfkit_sphere::{DVec3, Side};

use super::optics::{disk_gaussian, schlick};
use super::peak::Peak;
use super::{Material, SymmetryHint};

/// A core of Schlick's reflectance less the halo's light about the mirror direction, and f = halo · K(ui + uo), K a Gaussian.
#[derive(Clone, Debug)]
pub struct MirrorFilm {
    /// Reflectance at normal incidence, core and halo.
    pub reflectance: f64,
    /// Full width of the core at half its height, degrees.
    pub core_degrees: f64,
    /// Share of the light in the halo.
    pub halo: f64,
    /// Width of the halo, in direction cosines.
    pub halo_width: f64,
}

impl Default for MirrorFilm {
    fn default() -> Self {
        Self { reflectance: 0.85, core_degrees: 0.3, halo: 0.15, halo_width: 0.2 }
    }
}

/// Full width of a Gaussian at half its height in standard deviations, 2 √(2 ln 2).
const FULL_WIDTH: f64 = 2.354_820_045;

impl Material for MirrorFilm {
    fn name(&self) -> &'static str {
        "mirror-film"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        self.halo * disk_gaussian(wi.truncate() + wo.truncate(), self.halo_width)
    }

    fn peaks(&self, wi: DVec3) -> Vec<Peak> {
        if wi.z <= 0.0 {
            return Vec::new();
        }
        let coefficient = schlick(wi.z, self.reflectance) - self.halo;
        let wo = DVec3::new(-wi.x, -wi.y, wi.z);
        vec![Peak { wo, coefficient, width_degrees: self.core_degrees / FULL_WIDTH }]
    }

    fn scattered(&self) -> Side {
        Side::Front
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Isotropic
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("reflectance", self.reflectance),
            ("core_degrees", self.core_degrees),
            ("halo", self.halo),
            ("halo_width", self.halo_width),
        ]
    }
}
