//! A finely ruled film: light straight through, and one diffracted order beside it.

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::{DVec3, Side};

use super::peak::Peak;
use super::{Material, SymmetryHint};

/// Orders m = 0 and 1 at uo = m · grating x̂ − ui, τₘ = efficiencyₘ · cos^falloff θi; f = diffuse/π. An order whose place
/// lies beyond the horizon is not there.
#[derive(Clone, Debug)]
pub struct RuledFilm {
    /// Wavelength over period.
    pub grating: f64,
    /// Coefficients at normal incidence.
    pub efficiencies: [f64; 2],
    /// How steeply they fall toward grazing.
    pub falloff: f64,
    /// Lambertian transmittance beside them.
    pub diffuse: f64,
}

impl Default for RuledFilm {
    fn default() -> Self {
        Self { grating: 0.34, efficiencies: [0.5, 0.25], falloff: 0.3, diffuse: 0.08 }
    }
}

impl Material for RuledFilm {
    fn name(&self) -> &'static str {
        "ruled-film"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z >= 0.0 {
            return 0.0;
        }
        self.diffuse * FRAC_1_PI
    }

    fn peaks(&self, wi: DVec3) -> Vec<Peak> {
        if wi.z <= 0.0 {
            return Vec::new();
        }
        let order = |(m, efficiency): (usize, f64)| {
            let (x, y) = (m as f64 * self.grating - wi.x, -wi.y);
            let z2 = 1.0 - x * x - y * y;
            let coefficient = efficiency * wi.z.powf(self.falloff);
            (z2 > 0.0).then(|| Peak {
                wo: DVec3::new(x, y, -z2.sqrt()),
                coefficient,
                width_degrees: 0.0,
            })
        };
        self.efficiencies.into_iter().enumerate().filter_map(order).collect()
    }

    fn scattered(&self) -> Side {
        Side::Back
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Bilateral
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("grating", self.grating),
            ("efficiency_0", self.efficiencies[0]),
            ("efficiency_1", self.efficiencies[1]),
            ("falloff", self.falloff),
            ("diffuse", self.diffuse),
        ]
    }
}
