//! The peaks of one incident direction of any BSDF: where they are, how high, how wide.

use bsdfkit::{Bsdf, DVec3, Side};

use crate::validate::{Peak, View};

/// A local maximum of f |cos θₒ| over scattered directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Maximum {
    /// Where it is.
    pub direction: DVec3,
    /// f there, 1/sr.
    pub f: f64,
    /// f |cos θₒ| there, 1/sr.
    pub height: f64,
    /// Full widths of f |cos θₒ| at half the height, over great circles through the peak: the narrowest and the widest, in degrees. NaN
    /// where it stays above half of it out to the horizon.
    pub widths_degrees: [f64; 2],
}

/// Great circles through a peak along which its width is taken: 15 degrees from one to the next.
const CUTS: usize = 12;

/// Steps out of a peak, before the border is found by halving, in degrees: what narrows down and rises again within
/// one is passed over.
const STEP_DEGREES: f64 = 0.25;

/// Between two peaks f |cos θₒ| falls to this share of the lower one. The steps of a tree along one ridge, nine tenths, are no peaks; nor
/// are shoulders.
const DIP: f64 = 0.75;

/// The peaks of light from `wi` on side `scattered`, the highest first: at most four, at least 12 degrees apart.
///
/// What is lower than 15 % of the highest, or has no dip of a quarter between itself and a higher one, is no peak. A Lambertian surface has one, at the
/// normal, 120 degrees wide.
/// Cost: 11,000 values, of an interpolant 5 ms.
pub fn peaks(bsdf: &Bsdf, wi: DVec3, scattered: Side) -> Vec<Maximum> {
    let f = |w: DVec3| bsdf.eval(wi, w);
    let view = View { f: &f, side: scattered, limit: 1.0 };
    let mut apart: Vec<Peak> = Vec::new();
    for peak in view.peaks() {
        if apart.iter().all(|higher| dips(&view, peak, *higher)) {
            apart.push(peak);
        }
    }
    let found = apart.into_iter();
    found
        .map(|peak| Maximum {
            direction: peak.direction,
            f: f(peak.direction),
            height: peak.height,
            widths_degrees: widths(&view, peak.direction, 0.5 * peak.height),
        })
        .collect()
}

/// Whether there is a dip on the great circle from one peak to a higher one.
fn dips(view: &View<'_>, peak: Peak, higher: Peak) -> bool {
    const STEPS: usize = 40;
    (1..STEPS).any(|k| {
        let share = k as f64 / STEPS as f64;
        let between = peak.direction.lerp(higher.direction, share).normalize();
        view.height(between) < DIP * peak.height
    })
}

/// Narrowest and widest over all cuts.
fn widths(view: &View<'_>, direction: DVec3, half: f64) -> [f64; 2] {
    let (u, v) = direction.any_orthonormal_pair();
    let mut least_and_most = [f64::INFINITY, 0.0f64];
    for k in 0..CUTS {
        let (sin, cos) = (std::f64::consts::PI * k as f64 / CUTS as f64).sin_cos();
        let along = cos * u + sin * v;
        let (Some(a), Some(b)) =
            (border(view, direction, along, half), border(view, direction, -along, half))
        else {
            least_and_most[1] = f64::NAN;
            continue;
        };
        least_and_most[0] = least_and_most[0].min(a + b);
        // NaN stays.
        least_and_most[1] = if a + b > least_and_most[1] { a + b } else { least_and_most[1] };
    }
    least_and_most.map(|w| if w.is_finite() { w } else { f64::NAN })
}

/// How far along a great circle it falls below `half`, in degrees; `None` where it does not before the horizon.
fn border(view: &View<'_>, from: DVec3, along: DVec3, half: f64) -> Option<f64> {
    let above = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let w = cos * from + sin * along;
        (Side::of(w) == view.side).then(|| view.height(w) > half)
    };
    let (mut low, mut high) = (0.0, STEP_DEGREES);
    while above(high)? {
        (low, high) = (high, high + STEP_DEGREES);
    }
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        match above(middle) {
            Some(true) => low = middle,
            _ => high = middle,
        }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit::tree::{Rank, TensorTree, TreeDistribution};
    use bsdfkit::{Component, Distribution, Lambertian, Metadata, Sense, Xyz};
    use bsdfkit_sphere::DVec2;
    use bsdfkit_sphere::direction::from_degrees;

    /// f |cos θₒ| = exp(−½ q(w)), q of a Gaussian of two widths about a direction.
    #[derive(Debug)]
    struct Bump {
        at: DVec3,
        sigmas: [f64; 2],
    }

    impl Distribution for Bump {
        fn value(&self, _: DVec3, wo: DVec3) -> f64 {
            let (u, v) = self.at.any_orthonormal_pair();
            let angle = self.at.angle_between(wo);
            let off = DVec2::new(wo.dot(u), wo.dot(v)).normalize_or_zero() * angle;
            let q = (off / DVec2::from_array(self.sigmas)).length_squared();
            (-0.5 * q).exp() / wo.z.abs()
        }

        fn constant_part(&self) -> Xyz {
            Xyz::ZERO
        }

        fn total(&self, _: DVec3, _: Sense, _: f64) -> f64 {
            1.0
        }

        fn max_total(&self, _: f64) -> f64 {
            1.0
        }

        fn sample(&self, _: DVec3, _: Sense, _: f64, _: f64) -> Option<DVec2> {
            None
        }

        fn projected_solid_angle(
            &self,
            _: DVec3,
            _: Option<DVec3>,
            _: Sense,
        ) -> Option<(f64, f64)> {
            None
        }

        fn min_projected_solid_angle(&self) -> f64 {
            0.0
        }
    }

    #[test]
    fn a_gaussian_has_its_place_height_and_widths() {
        let at = from_degrees(35.0, 200.0);
        let sigmas = [4.0f64, 8.0].map(f64::to_radians);
        let bump = Component::new(Side::Front, Side::Front, Bump { at, sigmas });
        let bsdf = Bsdf::new(Metadata::default(), vec![bump], Lambertian::default());
        let found = peaks(&bsdf, from_degrees(35.0, 20.0), Side::Front);
        assert_eq!(found.len(), 1);
        assert!(found[0].direction.angle_between(at).to_degrees() < 0.05);
        assert!((found[0].height - 1.0).abs() < 1e-3);
        assert!((found[0].f - 1.0 / at.z).abs() < 2e-3);
        // 2 √(2 ln 2) deviations.
        for (width, sigma) in found[0].widths_degrees.into_iter().zip([4.0, 8.0]) {
            assert!((width - 2.354_82 * sigma).abs() < 0.1, "{width}");
        }
    }

    #[test]
    fn what_never_falls_to_half_has_no_width() {
        let flat = TreeDistribution::new(TensorTree::constant(Rank::Four, 0.3).unwrap());
        let flat = Component::new(Side::Front, Side::Front, flat);
        let bsdf = Bsdf::new(Metadata::default(), vec![flat], Lambertian::default());
        let found = peaks(&bsdf, DVec3::Z, Side::Front);
        // f is the same all over, f |cos θₒ| halves at 60 degrees.
        assert_eq!(found.len(), 1);
        assert!(found[0].widths_degrees.iter().all(|w| (w - 120.0).abs() < 2.0), "{found:?}");
        assert!(peaks(&bsdf, DVec3::Z, Side::Back).is_empty());
    }
}
