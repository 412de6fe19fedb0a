//! Crossed threads of unlike sheen: each draws its own streak across the hemisphere, as a cylinder does.

use std::f64::consts::{FRAC_1_PI, PI};

use bsdfkit_sphere::{DVec3, Side};

use super::{Material, SymmetryHint};

/// Warp along X, weft along Y, each waving up and down over the other.
///
/// A thread along unit `a` mirrors light into a cone about it, (wi + wo)·a = 0. As it waves, a leans by ± the wave:
/// f = ground/π + Σ sheen ½ g((wi + wo)·a) / 2 √(wi⊥ wo⊥), with g the normal density of the thread's width and w⊥ the length of w
/// across a.
#[derive(Clone, Debug)]
pub struct CrossedThreads {
    /// Reflectance of warp and weft.
    pub sheens: [f64; 2],
    /// Width of their streaks, in direction cosines.
    pub widths: [f64; 2],
    /// How far their axes lean up and down.
    pub waves_degrees: [f64; 2],
    /// Lambertian reflectance.
    pub ground: f64,
}

impl Default for CrossedThreads {
    fn default() -> Self {
        Self {
            sheens: [0.3, 0.15],
            widths: [0.05, 0.16],
            waves_degrees: [12.0, 20.0],
            ground: 0.15,
        }
    }
}

impl Material for CrossedThreads {
    fn name(&self) -> &'static str {
        "crossed-threads"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let streak = |axis: DVec3, width: f64| {
            let off = (wi + wo).dot(axis) / width;
            let across = |w: DVec3| w.reject_from_normalized(axis).length();
            let spread = 2.0 * (across(wi) * across(wo)).sqrt().max(0.1);
            (-0.5 * off * off).exp() / (width * (2.0 * PI).sqrt() * spread)
        };
        let thread = |k: usize, along: DVec3| {
            let (sin, cos) = self.waves_degrees[k].to_radians().sin_cos();
            let [up, down] =
                [sin, -sin].map(|s| streak(cos * along + s * DVec3::Z, self.widths[k]));
            0.5 * self.sheens[k] * (up + down)
        };
        thread(0, DVec3::X) + thread(1, DVec3::Y) + self.ground * FRAC_1_PI
    }

    fn scattered(&self) -> Side {
        Side::Front
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Quadrilateral
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("sheen_warp", self.sheens[0]),
            ("sheen_weft", self.sheens[1]),
            ("width_warp", self.widths[0]),
            ("width_weft", self.widths[1]),
            ("wave_warp_degrees", self.waves_degrees[0]),
            ("wave_weft_degrees", self.waves_degrees[1]),
            ("ground", self.ground),
        ]
    }
}
