//! A prism film of three kinds of facets, one of them flat: two beams thrown aside, one that goes straight through.

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::{DVec3, Side};

use super::facets::Facets;
use super::optics::soft_cosine;
use super::{Material, SymmetryHint};

/// Flat in front; behind, prisms along Y whose tips are cut off.
///
/// Each facet refracts, darkens and ends (by total reflection) on its own; the flat one never ends.
#[derive(Clone, Debug)]
pub struct ThreeFacetFilm {
    /// Index of refraction.
    pub index: f64,
    /// How far each kind of facet leans toward +X.
    pub tilts_degrees: [f64; 3],
    /// Part of the area that each kind of facet takes.
    pub areas: [f64; 3],
    /// Width of a beam, from the facets' roughness.
    pub beam_degrees: f64,
    /// Lambertian transmittance of the scattered rest.
    pub diffuse: f64,
}

impl Default for ThreeFacetFilm {
    fn default() -> Self {
        Self {
            index: 1.53,
            tilts_degrees: [22.0, -32.0, 0.0],
            areas: [0.4, 0.3, 0.25],
            beam_degrees: 3.0,
            diffuse: 0.02,
        }
    }
}

impl Material for ThreeFacetFilm {
    fn name(&self) -> &'static str {
        "three-facet-film"
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

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("index", self.index),
            ("tilt_0_degrees", self.tilts_degrees[0]),
            ("tilt_1_degrees", self.tilts_degrees[1]),
            ("tilt_2_degrees", self.tilts_degrees[2]),
            ("area_0", self.areas[0]),
            ("area_1", self.areas[1]),
            ("area_2", self.areas[2]),
            ("beam_degrees", self.beam_degrees),
            ("diffuse", self.diffuse),
        ]
    }
}
