//! The interpolated scattering of one incident direction.

use bsdfkit::limits::MAGNITUDE;
use bsdfkit::spectrum::Basis;
use bsdfkit::{DVec2, DVec3};
use bsdfkit_sphere::widest::{Loop, widest};

use crate::interpolant::answer::lobe_on_disk::Bow;
use crate::interpolant::family::carried::{Law, Standing};
use crate::interpolant::field::past_rim;
use crate::interpolant::incidence::fitted::FittedIncidence;
use crate::interpolant::incidence::spectra::MOST_DETAILS;
use crate::interpolant::motion::moved::{Moved, Sums};
use crate::lobe::detail::Detail;
use bsdfkit_measure::Image;
use bsdfkit_measure::frame::FrameAt;
use bsdfkit_represent::{Peak, Slice};

/// A corner of the cell that holds the query.
pub(crate) struct Corner<'a> {
    pub(crate) weight: f64,
    pub(crate) frame: &'a FrameAt,
    /// From the corner to its measured incidence.
    pub(crate) back: Image,
    pub(crate) incidence: &'a FittedIncidence,
    /// Lobes of the corner that follow each of the laws.
    pub(crate) families: &'a [Vec<Standing>],
    /// 1 over the cosine of the last polar angle that was seen there.
    pub(crate) per_limit: f64,
    /// What it has to say at the horizon and below, where nothing was seen, in proportion to elsewhere.
    pub(crate) unseen: f64,
}

/// [`Corner::unseen`] of reflected light, whose peaks would go on below the horizon: lobes do there as they please.
/// Of 0.01 to 1: with 0.1 to 0.5 L1 of brushed and rotated metals and fabrics falls by 2 to 25 %. Transmitted
/// light, which does end there, loses by it.
pub(crate) const UNSEEN: f64 = 0.35;

impl<'a> Corner<'a> {
    /// A measured incidence as it was seen, of which all lobes move as the frame does.
    pub(crate) fn new(
        incidence: &'a FittedIncidence,
        frame: &'a FrameAt,
        weight: f64,
        reflects: bool,
    ) -> Self {
        Self {
            weight,
            frame,
            back: Image::IDENTITY,
            incidence,
            families: &[],
            per_limit: 1.0 / (1.0 - incidence.limit.powi(2)).max(1e-6).sqrt(),
            unseen: if reflects { UNSEEN } else { 1.0 },
        }
    }

    /// How much it has to say of what scatters at this cosine there.
    #[inline(always)]
    fn seen(&self, cosine: f64) -> f64 {
        (cosine * self.per_limit).max(self.unseen).min(1.0)
    }
}

/// The interpolated scattering of one incident direction.
pub struct Distribution<'a> {
    /// From the caller's frame to the folded one.
    pub(crate) fold: Image,
    /// Energy correction.
    pub(crate) scale: f64,
    pub(crate) frame: FrameAt,
    pub(crate) floor: f64,
    pub(crate) epsilon: f64,
    pub(crate) moved: Vec<Moved>,
    pub(crate) corners: [Corner<'a>; 3],
    /// How bands are made of details, where there are bands.
    pub(crate) spectra: Option<&'a Basis>,
    /// What some lobes of the corners follow.
    pub(crate) laws: Vec<Law<'a>>,
    /// The same incident direction seen in a mirror, where the mesh is not its own mirror image:
    /// the mean of both is.
    pub(crate) twin: Option<Box<Distribution<'a>>>,
    /// Past the rim of the mesh: what there is as far inside, brought here, and [`Motion::onward`](crate::interpolant::Motion::onward).
    pub(crate) inner: Option<(f64, Box<Distribution<'a>>)>,
}

/// Directions that go through evaluation together.
const LANES: usize = 8;
/// Their values, of luminance or of three channels, need no memory of their own.
const FEW: usize = 3 * LANES;

/// `f` with room for so many values.
#[inline(always)]
pub(super) fn with_room<R>(count: usize, f: impl FnOnce(&mut [f64]) -> R) -> R {
    if count <= FEW { f(&mut [0.0; FEW][..count]) } else { f(&mut vec![0.0; count]) }
}

impl Distribution<'_> {
    /// Luminance f in 1/sr at scattered direction `wo` (its side is not looked at).
    pub fn eval(&self, wo: DVec3) -> f64 {
        let mut value = [0.0];
        self.eval_channels(wo, &mut value);
        value[0]
    }

    /// The lobes on the disk of scattered directions (of the folded frame), without those that hardly scatter.
    pub(crate) fn bows(&self) -> Vec<Bow> {
        self.bows_of(HARDLY)
    }

    /// Those that scatter this share at least.
    pub(crate) fn bows_of(&self, hardly: f64) -> Vec<Bow> {
        let place = |q: DVec2| {
            let (u, z) = self.frame.inverse(q);
            (z > 0.0).then_some(u)
        };
        let carried = |c: &Corner<'_>| {
            c.weight * c.families.iter().flatten().map(|l| l.lobe.mass).sum::<f64>()
        };
        let least = hardly
            * (self.moved.iter().map(|m| m.lobe.mass).sum::<f64>()
                + self.corners.iter().map(carried).sum::<f64>());
        let lobes = self.moved.iter().map(|m| &m.lobe).filter(|lobe| lobe.mass > least);
        let mut bows: Vec<Bow> = lobes.filter_map(|lobe| Bow::of(lobe, &place)).collect();
        bows.extend(self.carried_bows(least));
        bows
    }

    /// Values of one direction: luminance, or Y, X, Z, or the guide and all bands.
    pub(crate) fn channels(&self) -> usize {
        match self.spectra {
            Some(spectra) => 1 + spectra.bands().count(),
            None => self.corners[0].incidence.details.len(),
        }
    }

    /// The logarithms of channels over the model, from those of details.
    #[inline(always)]
    pub(super) fn logarithms(&self, detail: impl Fn(usize) -> f64, out: &mut [f64]) {
        match self.spectra {
            Some(spectra) if out.len() > 1 => spectra.logarithms(detail, out),
            _ => out.iter_mut().enumerate().for_each(|(d, out)| *out = detail(d)),
        }
    }

    /// From the caller's frame to the one in which [`Distribution::bows`] are.
    pub(crate) fn fold(&self) -> Image {
        self.fold
    }

    /// A direction of the folded frame as the caller sees it.
    pub(crate) fn unfolded(&self, w: DVec3) -> DVec3 {
        self.fold.inverse().apply(w)
    }

    /// f of the first `out.len()` channels, luminance first.
    pub fn eval_channels(&self, wo: DVec3, out: &mut [f64]) {
        self.eval_past(&[wo], out);
    }

    /// f of the first `out.len()` / `N` channels at `N` directions, channels fastest.
    #[inline(always)]
    fn eval_lanes<const N: usize>(&self, wo: &[DVec3; N], out: &mut [f64]) {
        let (mut u, mut still, mut density) = ([DVec2::ZERO; N], [0.0; N], [0.0; N]);
        let mut q = [[0.0; N]; 2];
        for k in 0..N {
            u[k] = on_disk(self.fold.apply(wo[k]));
            let at = self.frame.forward(u[k]);
            (q[0][k], q[1][k]) = (at.x, at.y);
            density[k] = self.frame.density(u[k]);
            // What does not move maps every direction to itself.
            still[k] = self.floor * density[k] + 1e-12;
        }
        let sums = Sums::at(q, &self.moved);
        // Per corner: where what is here comes from, and its part of the model.
        let (mut from, mut parts) = ([[DVec2::ZERO; N]; 3], [[0.0; N]; 3]);
        let (mut model, mut say) = ([0.0; N], [0.0; N]);
        let present = || self.corners.iter().enumerate().filter(|(_, c)| c.weight > 0.0);
        for (c, corner) in present() {
            for k in 0..N {
                let place = sums.place(c, k) + still[k] * corner.frame.forward(u[k]);
                from[c][k] = place / (sums.density[k] + still[k]);
            }
            let places = corner.frame.inverse_each(from[c]);
            for (k, (v, z)) in places.into_iter().enumerate() {
                let own = sums.share(c, k) + still[k] * corner.weight;
                let seen = corner.seen(z);
                parts[c][k] = seen * own;
                model[k] += seen * own;
                say[k] += seen * corner.weight;
                let v = if z > 0.0 { v } else { v * (0.9999 / v.length().max(1e-12)) };
                from[c][k] = corner.back.apply(v.extend(0.0)).truncate();
            }
        }
        let channels = out.len() / N;
        let mut logs = [[0.0; N]; MOST_DETAILS];
        for (c, corner) in present() {
            for (logs, detail) in logs.iter_mut().zip(details(corner.incidence, channels)) {
                for (k, log) in detail.log_each(from[c]).into_iter().enumerate() {
                    logs[k] += parts[c][k] / model[k] * log;
                }
            }
        }
        for (k, out) in out.chunks_exact_mut(channels).enumerate() {
            self.logarithms(|detail| logs[detail][k], out);
            let model = model[k] / say[k] / density[k] + self.epsilon;
            for value in out {
                *value = model * value.exp() - self.epsilon;
            }
        }
        self.add_families(&u, out);
        out.iter_mut().for_each(|value| *value = self.scale * value.max(0.0));
    }

    /// [`Distribution::eval_twins`], and past the rim what that changes to on the way out.
    #[inline(always)]
    fn eval_past<const N: usize>(&self, wo: &[DVec3; N], out: &mut [f64]) {
        self.eval_twins(wo, out);
        if let Some((onward, inner)) = &self.inner {
            with_room(out.len(), |within| {
                inner.eval_twins(wo, within);
                for (value, within) in out.iter_mut().zip(within) {
                    *value *= past_rim::change(*value, *within, self.epsilon).powf(*onward);
                }
            });
        }
        // Whatever numbers a broken file holds; what is none counts as no light.
        out.iter_mut().for_each(|value| *value = value.max(0.0).clamp(0.0, MAGNITUDE));
    }

    /// [`Distribution::eval_lanes`] of the incident direction and of itself in the mirror.
    #[inline(always)]
    fn eval_twins<const N: usize>(&self, wo: &[DVec3; N], out: &mut [f64]) {
        self.eval_lanes(wo, out);
        if let Some(twin) = &self.twin {
            with_room(out.len(), |other| {
                twin.eval_lanes(wo, other);
                for (value, other) in out.iter_mut().zip(other) {
                    *value = 0.5 * (*value + *other);
                }
            });
        }
    }
}

/// What tells the first `channels` channels of an incidence.
#[inline(always)]
pub(super) fn details(
    incidence: &FittedIncidence,
    channels: usize,
) -> impl Iterator<Item = &Detail> {
    let more = if channels > 1 { incidence.coefficients.as_slice() } else { &[] };
    incidence.details.iter().take(channels).chain(more)
}

/// The place of a scattered direction, a little off the horizon.
#[inline(always)]
pub(crate) fn on_disk(wo: DVec3) -> DVec2 {
    let v = wo.truncate();
    let r2 = v.length_squared();
    if r2 > 0.99999 { v * (0.99999 / r2).sqrt() } else { v }
}

/// Evaluation of many directions.
struct Values<'a> {
    of: &'a Distribution<'a>,
    wo: &'a [DVec3],
    out: &'a mut [f32],
}

impl Loop for Values<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { of, wo, out } = self;
        let channels = of.channels();
        let mut values = vec![0.0; LANES * channels];
        for (out, wo) in out.chunks_mut(LANES * channels).zip(wo.chunks(LANES)) {
            // The last few are as many as the others: the last of all counts again.
            let lanes: [DVec3; LANES] = std::array::from_fn(|k| wo[k.min(wo.len() - 1)]);
            of.eval_past(&lanes, &mut values);
            for (o, v) in out.iter_mut().zip(&values) {
                *o = *v as f32;
            }
        }
    }
}

/// Share of the moved mass below which a lobe needs no care where light is added up.
const HARDLY: f64 = 1e-4;

/// Share of the moved mass below which a lobe is no peak to be looked for: missed, it costs that.
const PEAK_MASS: f64 = 1e-3;

impl Slice for Distribution<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        if let [wo] = wo {
            with_room(self.channels(), |values| {
                self.eval_past(&[*wo], values);
                for (o, v) in out.iter_mut().zip(values) {
                    *o = *v as f32;
                }
            });
        } else {
            widest(Values { of: self, wo, out });
        }
    }

    /// The moved lobes that carry mass and lie above the horizon; long ones in several places
    /// along their axis.
    fn peaks(&self, out: &mut Vec<Peak>) {
        let total: f64 = self.moved.iter().map(|m| m.lobe.mass).sum();
        let back = self.fold.inverse();
        for m in self.moved.iter().filter(|m| m.lobe.mass > PEAK_MASS * total) {
            let (mean, c) = (m.lobe.mean, m.lobe.covariance);
            let [long, short] = c.axes();
            let (wide, narrow) = (long.length(), short.length());
            let along = long / wide;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpolant::component::fitted::Fitted;
    use crate::interpolant::component::planned::{Peaks, Planned};
    use crate::interpolant::{Chart, Frame, Motion};
    use crate::lobe::{Covariance, Lobe, LobeSet};
    use bsdfkit::Side;
    use bsdfkit_measure::{Seen, Symmetry};
    use bsdfkit_sphere::direction::from_degrees;

    #[test]
    fn what_lobes_do_behind_the_horizon_is_not_taken_for_what_is_seen() {
        let (wi, wo) = (from_degrees(45.0, 0.0), from_degrees(80.0, 180.0));
        let at = Frame::Half.at(wi);
        let (floor, q) = (0.1, at.forward(wo.truncate()));
        // Below the horizon at 60 degrees, 25 degrees above it at 30.
        let lobe = Lobe { mass: 0.002, mean: q, covariance: Covariance::isotropic(1e-3) };
        let of = |theta: f64, lobes: Vec<Lobe>| FittedIncidence {
            wi: from_degrees(theta, 0.0),
            lobes: LobeSet { floor, lobes },
            details: vec![Detail::fit([DVec3::Z], &[1.0], &[1.0], 8)],
            coefficients: Vec::new(),
            points: 1,
            hemispherical: 0.3,
            fit_error: 0.0,
            limit: 82.0_f64.to_radians().sin(),
            seen: Seen::whole(),
        };
        let motion = Motion { reach: 0.0, chart: Chart::Beneath, ..Motion::straight(Frame::Half) };
        let value = |behind: bool, scattered: Side| {
            let lobes = |here: bool| if here { vec![lobe] } else { Vec::new() };
            let incidences =
                vec![of(0.0, vec![]), of(30.0, lobes(!behind)), of(60.0, lobes(behind))];
            let symmetry = Symmetry::Isotropic;
            let fitted = Fitted {
                incident: Side::Front,
                scattered,
                symmetry,
                epsilon: 1e-6,
                spectra: None,
                incidences,
            };
            let c = Planned::new(fitted, motion, Peaks::Apart).expect("mesh");
            let weights = c.mesh.locate(wi).weights(&c.mesh.topology);
            let far = weights.iter().filter(|(v, _)| c.mesh.vertices[*v as usize].wi.z < 0.6);
            (c.at(wi).eval(wo) - floor, far.map(|w| w.1).sum::<f64>())
        };
        let peak = lobe.density(q) / at.density(wo.truncate());
        let [(behind, far), (seen, _)] = [true, false].map(|b| value(b, Side::Front));
        assert!(far > 0.3 && far < 0.7, "{far}");
        let say = UNSEEN * far + 1.0 - far;
        assert!((behind / (UNSEEN * far * peak / say) - 1.0).abs() < 0.02, "{behind} {peak}");
        assert!((seen / ((1.0 - far) * peak / say) - 1.0).abs() < 0.02, "{seen} {peak}");
        // Transmitted light ends there.
        let (ends, _) = value(true, Side::Back);
        assert!((ends / (far * peak) - 1.0).abs() < 0.02, "{ends} {peak}");
    }
}
