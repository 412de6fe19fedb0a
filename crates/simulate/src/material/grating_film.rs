//! A blazed grating: several orders, each its own distance beside the light that goes straight through.

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::{DVec2, DVec3, Side};

use super::optics::disk_gaussian;
use super::{Material, SymmetryHint};

/// Grooves along Y: order m leaves at uo = m · grating − ui in direction cosines, along X.
///
/// f = diffuse/π + Σ efficiencyₘ K(ui + uo − m · grating x̂), K a Gaussian. An order whose place lies beyond the horizon
/// is not there, and its light is lost.
#[derive(Clone, Debug)]
pub struct GratingFilm {
    /// Wavelength over period: between neighbouring orders, in direction cosines.
    pub grating: f64,
    /// Parts of the light that orders −2 to 2 take.
    pub efficiencies: [f64; 5],
    /// Width of an order, in direction cosines.
    pub width: f64,
    /// Lambertian transmittance beside them.
    pub diffuse: f64,
}

impl Default for GratingFilm {
    fn default() -> Self {
        Self {
            grating: 0.34,
            efficiencies: [0.04, 0.1, 0.35, 0.22, 0.09],
            width: 0.045,
            diffuse: 0.05,
        }
    }
}

impl Material for GratingFilm {
    fn name(&self) -> &'static str {
        "grating-film"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z >= 0.0 {
            return 0.0;
        }
        let off = wi.truncate() + wo.truncate();
        let order = |(k, efficiency): (usize, f64)| {
            let beside = DVec2::new((k as f64 - 2.0) * self.grating, 0.0);
            efficiency * disk_gaussian(off - beside, self.width)
        };
        let orders: f64 = self.efficiencies.into_iter().enumerate().map(order).sum();
        orders + self.diffuse * FRAC_1_PI
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
            ("efficiency_minus_2", self.efficiencies[0]),
            ("efficiency_minus_1", self.efficiencies[1]),
            ("efficiency_0", self.efficiencies[2]),
            ("efficiency_1", self.efficiencies[3]),
            ("efficiency_2", self.efficiencies[4]),
            ("width", self.width),
            ("diffuse", self.diffuse),
        ]
    }
}
