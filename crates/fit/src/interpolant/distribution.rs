//! The interpolated scattering of one incident direction.

use bsdfkit::{DVec2, DVec3};
use bsdfkit_sphere::concentric::disk_to_square;

use super::displace::Moved;
use super::frame::FrameAt;
use super::incidence::FittedIncidence;
use crate::lobe::exponential::exp;
use crate::measurement::Image;
use crate::tabulate::{Peak, Slice};

/// A corner of the cell that holds the query.
pub(super) struct Corner<'a> {
    pub(super) weight: f64,
    pub(super) frame: FrameAt,
    /// From the corner to its measured incidence.
    pub(super) back: Image,
    pub(super) incidence: &'a FittedIncidence,
}

/// The interpolated scattering of one incident direction.
pub struct Distribution<'a> {
    /// From the caller's frame to the folded one.
    pub(super) fold: Image,
    /// Energy correction.
    pub(super) scale: f64,
    pub(super) frame: FrameAt,
    pub(super) floor: f64,
    pub(super) epsilon: f64,
    pub(super) moved: Vec<Moved>,
    pub(super) corners: [Corner<'a>; 3],
    /// The same incident direction seen in a mirror, where the mesh is not its own mirror image:
    /// the mean of both is.
    pub(super) twin: Option<Box<Distribution<'a>>>,
}

/// Lobes are cut at this exponent: exp(−16) of the peak.
const CUT: f64 = 32.0;

impl Distribution<'_> {
    /// Luminance f in 1/sr at scattered direction `wo` (its side is not looked at).
    pub fn eval(&self, wo: DVec3) -> f64 {
        let mut value = [0.0];
        self.eval_channels(wo, &mut value);
        value[0]
    }

    /// Where the lobes are on the square of scattered directions (of the folded frame), with the
    /// least and greatest extent of one standard deviation there; those below the horizon left out.
    pub(super) fn extents(&self) -> Vec<(DVec2, f64, f64)> {
        let place = |q: DVec2| {
            let (u, z) = self.frame.inverse(q);
            (z > 0.0).then(|| disk_to_square(u))
        };
        let extent = |m: &Moved| {
            let centre = place(m.lobe.mean)?;
            let root = m.lobe.covariance.sqrt();
            let (mut least, mut most) = (f64::MAX, 0.0f64);
            for axis in [DVec2::X, DVec2::Y] {
                let d = root.apply(axis);
                let (a, b) = (place(m.lobe.mean + d), place(m.lobe.mean - d));
                let r = a.or(b).map_or(1.0, |p| p.distance(centre));
                least = least.min(r);
                most = most.max(r);
            }
            Some((centre, least, most))
        };
        self.moved.iter().filter_map(extent).collect()
    }

    /// A direction of the folded frame as the caller sees it.
    pub(super) fn unfolded(&self, w: DVec3) -> DVec3 {
        self.fold.inverse().apply(w)
    }

    /// f of the first `out.len()` channels, luminance first.
    pub fn eval_channels(&self, wo: DVec3, out: &mut [f64]) {
        let u = self.fold.apply(wo).truncate();
        let r2 = u.length_squared();
        let u = if r2 > 0.99999 { u * (0.99999 / r2).sqrt() } else { u };
        let q = self.frame.forward(u);
        let density = self.frame.density(u);
        let mut sum = 0.0;
        let mut places = [DVec2::ZERO; 3];
        for m in &self.moved {
            let d = q - m.lobe.mean;
            let e = m.precision.quadratic(d);
            if e < CUT {
                let g = m.peak * f64::from(exp(-0.5 * e as f32));
                sum += g;
                for (place, (centre, map)) in places.iter_mut().zip(&m.maps) {
                    *place += g * (*centre + map.apply(d));
                }
            }
        }
        // The floor does not move: it maps every direction to itself.
        let still = self.floor * density + 1e-12;
        out.fill(0.0);
        for (corner, place) in self.corners.iter().zip(places) {
            if corner.weight > 0.0 {
                let q = (place + still * corner.frame.forward(u)) / (sum + still);
                let (v, z) = corner.frame.inverse(q);
                let v = if z > 0.0 { v } else { v * (0.9999 / v.length().max(1e-12)) };
                let v = corner.back.apply(v.extend(0.0)).truncate();
                for (log, detail) in out.iter_mut().zip(&corner.incidence.details) {
                    *log += corner.weight * detail.log_at(v);
                }
            }
        }
        let model = self.floor + sum / density + self.epsilon;
        for value in out.iter_mut() {
            *value = self.scale * (model * value.exp() - self.epsilon).max(0.0);
        }
        if let Some(twin) = &self.twin {
            let mut other = vec![0.0; out.len()];
            twin.eval_channels(wo, &mut other);
            for (value, other) in out.iter_mut().zip(other) {
                *value = 0.5 * (*value + other);
            }
        }
    }
}

/// Share of the moved mass below which a lobe is no peak to be looked for: missed, it costs that.
const PEAK_MASS: f64 = 1e-3;

impl Slice for Distribution<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        let channels = self.corners[0].incidence.details.len();
        let mut values = vec![0.0; channels];
        for (out, &w) in out.chunks_exact_mut(channels).zip(wo) {
            self.eval_channels(w, &mut values);
            for (o, v) in out.iter_mut().zip(&values) {
                *o = *v as f32;
            }
        }
    }

    /// The moved lobes that carry mass and lie above the horizon; long ones in several places
    /// along their axis.
    fn peaks(&self, out: &mut Vec<Peak>) {
        let total: f64 = self.moved.iter().map(|m| m.lobe.mass).sum();
        let back = self.fold.inverse();
        for m in self.moved.iter().filter(|m| m.lobe.mass > PEAK_MASS * total) {
            let (mean, c) = (m.lobe.mean, m.lobe.covariance);
            let half = 0.5 * c.trace();
            let wide = (half + (half * half - c.determinant()).max(0.0).sqrt()).sqrt();
            let narrow = c.determinant().max(0.0).sqrt() / wide;
            let angle = 0.5 * (2.0 * c.xy).atan2(c.xx - c.yy);
            let along = DVec2::new(angle.cos(), angle.sin());
            // From one to seven places, two narrow deviations apart.
            let steps = (0.75 * wide / narrow).min(3.0) as i32;
            for step in -steps..=steps {
                let q = mean + along * (2.0 * narrow * f64::from(step));
                let (u, z) = self.frame.inverse(q);
                if z > 0.0 {
                    let scale = |axis: DVec2| {
                        let moved = self.frame.inverse(q + axis * (0.1 * narrow)).0;
                        10.0 * (moved - u).length()
                    };
                    let radius = scale(along).min(scale(along.perp()));
                    out.push(Peak { direction: back.apply(u.extend(z)), radius });
                }
            }
        }
    }
}
