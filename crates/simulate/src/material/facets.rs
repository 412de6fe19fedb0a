//! What facets at the back of a film, flat in front, do to a beam.

use bsdfkit_sphere::DVec3;

use super::optics::{fresnel, refract_out, spherical_gaussian};

/// A film's material and the roughness of its facets.
#[derive(Clone, Copy)]
pub(super) struct Facets {
    /// Index of refraction.
    pub(super) index: f64,
    /// Width of each beam, degrees.
    pub(super) beam_degrees: f64,
}

impl Facets {
    /// f |cos θo| of the beams that leave through facets of (lean toward +X in degrees, part of the area).
    ///
    /// A facet that reflects totally, or that the light runs from behind, has no beam.
    pub(super) fn beams(
        self,
        wi: DVec3,
        wo: DVec3,
        facets: impl Iterator<Item = (f64, f64)>,
    ) -> f64 {
        let n = self.index;
        let entering = 1.0 - fresnel(wi.z, n);
        let flat = wi.truncate() / -n;
        let inside = flat.extend(-(1.0 - flat.length_squared()).sqrt());
        let width = self.beam_degrees.to_radians();
        let beam = |(lean, area): (f64, f64)| {
            let (sin, cos) = lean.to_radians().sin_cos();
            let facet = DVec3::new(sin, 0.0, -cos);
            let Some(out) = refract_out(inside, facet, n) else { return 0.0 };
            let leaving = 1.0 - fresnel(out.dot(facet), n);
            area * entering * leaving * spherical_gaussian(wo.dot(out), width)
        };
        facets.map(beam).sum()
    }
}
