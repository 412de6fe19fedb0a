//! A mirror peak that is one at normal incidence, and two that part the more aslant the light comes.

use std::f64::consts::FRAC_1_PI;

use bsdfkit_sphere::{DVec2, DVec3, Side};

use super::optics::disk_gaussian;
use super::{Material, SymmetryHint};

/// With u the direction cosines, t = (uo − ui) / 2 and d = split · t² along X:
/// f = diffuse/π + specular (1 − split² tₓ²) ½ \[K(ui + uo − d) + K(ui + uo + d)\], K a Gaussian.
///
/// At a peak t is near −ui, so that the two stand about split · sin²θ along X from the mirror direction. Swapping the
/// directions turns t into −t and leaves f. The peaks run at unlike speed, which makes one brighter; the factor
/// 1 − split² tₓ² leaves each the energy specular (1 ± split tₓ) / 2, with tₓ at the peak.
#[derive(Clone, Debug)]
pub struct SplittingPeak {
    /// How far either peak is from the mirror direction at grazing incidence, in direction cosines; below 1.
    pub split: f64,
    /// Width of a peak, in direction cosines.
    pub width: f64,
    /// Reflectance of both peaks together.
    pub specular: f64,
    /// Lambertian reflectance beside them.
    pub diffuse: f64,
}

impl Default for SplittingPeak {
    fn default() -> Self {
        Self { split: 0.45, width: 0.06, specular: 0.7, diffuse: 0.1 }
    }
}

impl Material for SplittingPeak {
    fn name(&self) -> &'static str {
        "splitting-peak"
    }

    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let (i, o) = (wi.truncate(), wo.truncate());
        let t = 0.5 * (o - i);
        let apart = DVec2::new(self.split * t.length_squared(), 0.0);
        let peaks =
            disk_gaussian(i + o - apart, self.width) + disk_gaussian(i + o + apart, self.width);
        let even = 1.0 - (self.split * t.x).powi(2);
        0.5 * self.specular * even * peaks + self.diffuse * FRAC_1_PI
    }

    fn scattered(&self) -> Side {
        Side::Front
    }

    fn symmetry(&self) -> SymmetryHint {
        SymmetryHint::Quadrilateral
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("split", self.split),
            ("width", self.width),
            ("specular", self.specular),
            ("diffuse", self.diffuse),
        ]
    }
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::direction::from_degrees;

    use super::*;

    #[test]
    fn the_peaks_are_where_the_formula_says_and_keep_their_energy() {
        let m = SplittingPeak { diffuse: 0.0, ..SplittingPeak::default() };
        let one = m.eval(from_degrees(0.0, 0.0), from_degrees(0.0, 0.0));
        assert!((one / (0.7 / (2.0 * std::f64::consts::PI * 0.0036)) - 1.0).abs() < 1e-12, "{one}");
        for theta in [15.0, 30.0, 45.0] {
            // across the plane of incidence both peaks stay above the horizon
            let wi = from_degrees(theta, 90.0);
            let aside = 0.45 * wi.y * wi.y;
            // at the peaks tₓ = ± aside / 2, to first order
            let energy = 0.7 * (1.0 + 0.45 * aside / 2.0);
            assert!((m.albedo(wi) - energy).abs() < 4e-3, "{theta}: {} {energy}", m.albedo(wi));
            let at = |x: f64| {
                let u = DVec2::new(x, -wi.y);
                m.eval(wi, u.extend((1.0 - u.length_squared()).sqrt()))
            };
            let brightest =
                (0..600).map(|k| f64::from(k) * 1e-3).max_by(|a, b| at(*a).total_cmp(&at(*b)));
            // the widths of two near peaks overlap
            assert!((brightest.unwrap() - aside).abs() < 0.02 || aside < m.width, "{theta}");
        }
    }
}
