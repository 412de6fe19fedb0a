//! A screen of crossed threads: through its gaps a beam as narrow as the instrument's, from the threads diffuse light.

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::{DVec3, Side};

use super::optics::{soft_cosine, spherical_gaussian};
use super::{Material, SymmetryHint};

/// Threads along X and Y, thick in depth: aslant they hide the gaps.
///
/// f = V(wi) G(−wi·wo) / s(cos θo) + threads/π (1 − V(wi)) (1 − V(wo)), with V = gap_x gap_y of the gaps' open widths as seen,
/// G a Gaussian on the sphere and s the softened cosine.
#[derive(Clone, Debug)]
pub struct PerforatedScreen {
    /// Open part of the width across X at normal incidence.
    pub gap_x: f64,
    /// Open part of the width across Y at normal incidence.
    pub gap_y: f64,
    /// Depth of the threads over their period.
    pub depth: f64,
    /// Width of the beam: what the instrument makes of a straight ray.
    pub beam_degrees: f64,
    /// How much of what meets threads on both its ways is scattered through.
    pub threads: f64,
}

impl Default for PerforatedScreen {
    fn default() -> Self {
        Self { gap_x: 0.45, gap_y: 0.6, depth: 0.25, beam_degrees: 1.5, threads: 0.4 }
    }
}

impl PerforatedScreen {
    /// The open part of the screen along the line of `w`, 0 to 1.
    fn view(&self, w: DVec3) -> f64 {
        let open = |gap: f64, across: f64| (gap - self.depth * (across / w.z).abs()).max(0.0);
        open(self.gap_x, w.x) * open(self.gap_y, w.y)
    }
}

impl Material for PerforatedScreen {
    fn name(&self) -> &'static str {
        "perforated-screen"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z >= 0.0 {
            return 0.0;
        }
        let beam =
            spherical_gaussian(-wi.dot(wo), self.beam_degrees.to_radians()) / soft_cosine(wo.z);
        let (there, out) = (self.view(wi), self.view(wo));
        there * beam + FRAC_1_PI * self.threads * (1.0 - there) * (1.0 - out)
    }

    fn scattered(&self) -> Side {
        Side::Back
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Quadrilateral
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("gap_x", self.gap_x),
            ("gap_y", self.gap_y),
            ("depth", self.depth),
            ("beam_degrees", self.beam_degrees),
            ("threads", self.threads),
        ]
    }
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::direction::from_degrees;

    use super::*;

    #[test]
    fn the_view_is_the_open_part_of_a_screen_of_boxes() {
        // a slow twin: rays at points of one period, against threads of rectangular section
        let m = PerforatedScreen::default();
        for (theta, phi) in [(0.0, 0.0), (20.0, 0.0), (35.0, 60.0), (50.0, 200.0), (70.0, 90.0)] {
            let w = from_degrees(theta, phi);
            let shift = (w.x / w.z * m.depth, w.y / w.z * m.depth);
            let clear = |gap: f64, at: f64, shift: f64| {
                (0..=50).all(|k| (at + shift * f64::from(k) / 50.0).rem_euclid(1.0) < gap)
            };
            let part = |gap: f64, shift: f64| {
                let open = (0..2000).filter(|&k| clear(gap, (f64::from(k) + 0.5) / 2000.0, shift));
                open.count() as f64 / 2000.0
            };
            let twin = part(m.gap_x, shift.0) * part(m.gap_y, shift.1);
            assert!((m.view(w) - twin).abs() < 5e-3, "{theta} {phi}: {} {twin}", m.view(w));
        }
    }
}
