//! A film with prisms on its back: each facet throws a narrow beam aside.

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::{DVec3, Side};

use super::facets::Facets;
use super::optics::soft_cosine;
use super::{Material, SymmetryHint};

/// Flat in front, two kinds of facets behind, running along Y.
#[derive(Clone, Debug)]
pub struct PrismFilm {
    /// Index of refraction.
    pub index: f64,
    /// How far each kind of facet leans toward +X.
    pub tilts_degrees: [f64; 2],
    /// Part of the area that each kind of facet takes.
    pub areas: [f64; 2],
    /// Width of a beam, from the facets' roughness.
    pub beam_degrees: f64,
    /// Lambertian transmittance of the scattered rest.
    pub diffuse: f64,
}

impl Default for PrismFilm {
    fn default() -> Self {
        Self {
            index: 1.49,
            tilts_degrees: [25.0, -25.0],
            areas: [0.6, 0.35],
            beam_degrees: 3.5,
            diffuse: 0.02,
        }
    }
}

impl Material for PrismFilm {
    fn name(&self) -> &'static str {
        "prism-film"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z >= 0.0 {
            return 0.0;
        }
        let facets = Facets { index: self.index, beam_degrees: self.beam_degrees };
        let beams = facets.beams(wi, wo, self.tilts_degrees.into_iter().zip(self.areas));
        beams / soft_cosine(wo.z) + self.diffuse * FRAC_1_PI
    }

    fn scattered(&self) -> Side {
        Side::Back
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Bilateral
    }

    fn polar_angles(&self) -> Vec<f64> {
        vec![0.0, 15.0, 30.0, 45.0, 60.0]
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("index", self.index),
            ("tilt_0_degrees", self.tilts_degrees[0]),
            ("tilt_1_degrees", self.tilts_degrees[1]),
            ("area_0", self.areas[0]),
            ("area_1", self.areas[1]),
            ("beam_degrees", self.beam_degrees),
            ("diffuse", self.diffuse),
        ]
    }
}
