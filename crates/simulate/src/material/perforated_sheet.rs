//! A sheet with round holes: what meets a hole goes straight through, the rest diffuses.

use std::f64::consts::{FRAC_1_PI, PI};

use bsdfkit_sphere::{DVec3, Side};

use super::peak::Peak;
use super::{Material, SymmetryHint};

/// τ = openness · O(depth · tan θi) straight through, with O the part of a hole's exit that its entry leaves free,
/// (2/π) (acos x − x √(1 − x²)); f = diffuse (1 − openness) / π.
#[derive(Clone, Debug)]
pub struct PerforatedSheet {
    /// Area of the holes over that of the sheet.
    pub openness: f64,
    /// Thickness over the holes' diameter.
    pub depth: f64,
    /// Transmittance of the sheet between the holes.
    pub diffuse: f64,
}

impl Default for PerforatedSheet {
    fn default() -> Self {
        Self { openness: 0.2, depth: 0.12, diffuse: 0.15 }
    }
}

impl Material for PerforatedSheet {
    fn name(&self) -> &'static str {
        "perforated-sheet"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z >= 0.0 {
            return 0.0;
        }
        self.diffuse * (1.0 - self.openness) * FRAC_1_PI
    }

    fn peaks(&self, wi: DVec3) -> Vec<Peak> {
        if wi.z <= 0.0 {
            return Vec::new();
        }
        let x = self.depth * wi.truncate().length() / wi.z;
        let free = if x < 1.0 { 2.0 / PI * (x.acos() - x * (1.0 - x * x).sqrt()) } else { 0.0 };
        vec![Peak { wo: -wi, coefficient: self.openness * free, width_degrees: 0.0 }]
    }

    fn scattered(&self) -> Side {
        Side::Back
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Isotropic
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("openness", self.openness), ("depth", self.depth), ("diffuse", self.diffuse)]
    }
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::direction::from_degrees;

    use super::*;

    /// A slow twin: points of the entry that are within the exit, too.
    #[test]
    fn holes_overlap_as_circles_do() {
        let m = PerforatedSheet { depth: 0.3, ..PerforatedSheet::default() };
        for theta in [0.0f64, 25.0, 50.0, 70.0] {
            let shift = 2.0 * m.depth * theta.to_radians().tan();
            let (mut inside, mut both) = (0, 0);
            for k in 0..400 * 400 {
                let (x, y) = (f64::from(k / 400) / 200.0 - 1.0, f64::from(k % 400) / 200.0 - 1.0);
                let within = |x: f64| x * x + y * y < 1.0;
                inside += i32::from(within(x));
                both += i32::from(within(x) && within(x - shift));
            }
            let twin = m.openness * f64::from(both) / f64::from(inside);
            let found = m.peaks(from_degrees(theta, 40.0))[0].coefficient;
            assert!((found - twin).abs() < 1e-3 * m.openness, "{theta}: {found} {twin}");
        }
    }
}
