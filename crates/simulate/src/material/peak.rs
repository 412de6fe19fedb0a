//! Peaks that have no width, or one that only the best instruments resolve, as an aperture sees them.

use bsdfkit_sphere::DVec3;

/// Light that goes all one way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Which.
    pub wo: DVec3,
    /// The share of the incident light.
    pub coefficient: f64,
    /// Standard deviation of a Gaussian about it; 0: none.
    pub width_degrees: f64,
}

/// Circles about a Gaussian's middle, each of as much light: their fractions within an aperture are summed to 1e-4.
const CIRCLES: usize = 512;

impl Peak {
    /// What a detector of that aperture (the diameter of its cone) reads toward `w`: f of as much light, 1/sr.
    pub(crate) fn seen(&self, w: DVec3, aperture_degrees: f64) -> f64 {
        let radius = 0.5 * aperture_degrees.to_radians();
        let off = self.wo.angle_between(w);
        let sigma = self.width_degrees.to_radians();
        if off > radius + 6.0 * sigma {
            return 0.0;
        }
        let solid_angle = std::f64::consts::TAU * (1.0 - radius.cos());
        self.coefficient * within(off, radius, sigma) / (solid_angle * w.z.abs())
    }
}

/// Share of a Gaussian of width `sigma` that lies within `radius` of a point `off` its middle, all small angles.
fn within(off: f64, radius: f64, sigma: f64) -> f64 {
    if sigma <= 0.0 {
        return f64::from(off <= radius);
    }
    let circle = |k: usize| {
        let beyond = (k as f64 + 0.5) / CIRCLES as f64;
        let r = sigma * (-2.0 * beyond.ln()).sqrt();
        if r + off <= radius {
            return 1.0;
        }
        // Half the angle under which the aperture's part of the circle is seen from the circle's middle.
        let cosine = (off * off + r * r - radius * radius) / (2.0 * off * r).max(f64::MIN_POSITIVE);
        cosine.clamp(-1.0, 1.0).acos() / std::f64::consts::PI
    };
    (0..CIRCLES).map(circle).sum::<f64>() / CIRCLES as f64
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::direction::from_degrees;

    use super::*;

    /// Readings over the whole plane add up to the light, however wide peak and aperture are.
    #[test]
    fn an_aperture_sees_all_of_it() {
        for (width, aperture) in [(0.0, 1.0), (0.127, 1.0), (0.5, 1.0), (0.3, 0.2)] {
            let wo = from_degrees(140.0, 70.0);
            let peak = Peak { wo, coefficient: 0.7, width_degrees: width };
            let (u, v) = wo.any_orthonormal_pair();
            let half = (0.5 * aperture + 5.0 * width) * 1.05;
            let (steps, mut sum) = (300, 0.0);
            let step = 2.0 * half / f64::from(steps);
            for k in 0..steps * steps {
                let at = |k: i32| ((f64::from(k) + 0.5) * step - half).to_radians();
                let w = (wo + at(k / steps) * u + at(k % steps) * v).normalize();
                sum += peak.seen(w, aperture) * w.z.abs() * step.to_radians().powi(2);
            }
            assert!((sum / 0.7 - 1.0).abs() < 0.01, "{width} {aperture}: {sum}");
        }
    }
}
