//! Pearlescent paint: flakes whose hue turns with the angle, over an orange ground.

use std::f64::consts::{FRAC_1_PI, TAU};
use std::sync::LazyLock;

use bsdfkit::spectrum::{Bands, Illuminant, View, Weights};
use bsdfkit_sphere::{DVec3, Side};

use super::microfacet::Ggx;
use super::{Material, SymmetryHint};

/// GGX flakes that mirror by interference in a thin layer, over a Lambertian ground with a step in its spectrum.
///
/// A flake mirrors dim + bright · sin²(2π n d cos θ′ / λ), θ′ inside the layer; the ground has low + step · s(λ) with s from 0 to
/// 1 around 580 nm.
#[derive(Clone, Debug)]
pub struct PearlPaint {
    /// GGX roughness of the flakes.
    pub roughness: f64,
    /// Index of refraction of the layer.
    pub index: f64,
    /// Thickness of the layer, nm.
    pub thickness: f64,
}

impl Default for PearlPaint {
    fn default() -> Self {
        Self { roughness: 0.18, index: 2.2, thickness: 140.0 }
    }
}

/// Wavelengths that it is measured at: 31, every 10 nm from 400 to 700.
const FIRST: u32 = 400;
const LAST: u32 = 700;
const STEP: usize = 10;

fn wavelengths() -> Vec<f64> {
    (FIRST..=LAST).step_by(STEP).map(f64::from).collect()
}

/// Daylight as the eye sees it.
static PHOTOPIC: LazyLock<Weights> = LazyLock::new(|| {
    let bands = Bands::new(wavelengths()).expect("rising wavelengths");
    View::Photopic(Illuminant::D65).weights(&bands).expect("the visible is covered")
});

impl PearlPaint {
    /// f without what depends on the wavelength: flakes, and the cosine inside their layer.
    fn flakes(&self, wi: DVec3, wo: DVec3) -> (f64, f64) {
        let h = (wi + wo).normalize();
        let facets = Ggx { x: self.roughness, y: self.roughness };
        let flat = 4.0 * wi.z.max(1e-6) * wo.z.max(1e-6);
        let sine = (1.0 - wi.dot(h).powi(2)).max(0.0) / (self.index * self.index);
        (facets.density(h) * facets.visible(wi, wo) / flat, (1.0 - sine).sqrt())
    }

    fn at(&self, (flakes, cosine): (f64, f64), nanometres: f64) -> f64 {
        let phase = TAU * self.index * self.thickness * cosine / nanometres;
        let mirrored = 0.05 + 0.5 * phase.sin().powi(2);
        let step = 1.0 / (1.0 + ((580.0 - nanometres) / 15.0).exp());
        flakes * mirrored + (0.04 + 0.3 * step) * FRAC_1_PI
    }
}

impl Material for PearlPaint {
    fn name(&self) -> &'static str {
        "pearl-paint"
    }

    /// What the eye sees in daylight.
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let flakes = self.flakes(wi, wo);
        let bands: Vec<f64> = wavelengths().into_iter().map(|w| self.at(flakes, w)).collect();
        PHOTOPIC.apply(&bands).sum()
    }

    fn wavelengths(&self) -> Vec<f64> {
        wavelengths()
    }

    fn eval_at(&self, wi: DVec3, wo: DVec3, nanometres: f64) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        self.at(self.flakes(wi, wo), nanometres)
    }

    fn scattered(&self) -> Side {
        Side::Front
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Isotropic
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("roughness", self.roughness), ("index", self.index), ("thickness", self.thickness)]
    }
}
