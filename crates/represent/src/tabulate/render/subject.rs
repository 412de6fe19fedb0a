//! A source looked at from the outside: values on the front, and parts of them that follow peaks.

use bsdfkit::render::{Chart, Frame, FrameKind, Pose};
use bsdfkit::spectrum::Hue;
use bsdfkit::{DVec2, DVec3, Side};
use rayon::prelude::*;

use crate::source::{Extent, Followed, Slice, Source};

/// What a table is made of. Tables have both directions on the front.
pub(super) struct Subject<'a> {
    source: &'a dyn Source,
    pub(super) followed: Option<Box<dyn Followed + 'a>>,
}

fn on_side(w: DVec3, side: Side) -> DVec3 {
    DVec3::new(w.x, w.y, side.sign() * w.z.max(1e-9))
}

/// Where a layer goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Course {
    /// Where the law of its frame has it, with this stretch near the normal.
    Law([f64; 3]),
    /// Along with a peak that is followed.
    Peak(usize),
}

/// Least and greatest deviation of a peak in the disk that frames make round.
const WIDTHS: [f64; 2] = [0.003, 0.5];

/// A peak this far out is looked at as if there: stretches stay finite.
const FLATTEST: f64 = 0.1;

impl<'a> Subject<'a> {
    pub(super) fn new(source: &'a dyn Source) -> Self {
        Self { source, followed: None }
    }

    /// Peaks followed over `chart`, if the source knows them.
    pub(super) fn follow(&mut self, chart: &Chart) {
        self.followed = self.source.followed(chart);
    }

    pub(super) fn channels(&self) -> usize {
        self.source.channels()
    }

    pub(super) fn isotropic(&self) -> bool {
        self.source.isotropic()
    }

    /// How its bands follow from its luminance, if it has bands.
    pub(super) fn hue(&self) -> Option<Hue> {
        self.source.hue()
    }

    /// Coefficients of hue at each of `wo`: (directions, rank).
    pub(super) fn hues(&self, hue: &Hue, wi: DVec3, wo: &[DVec3]) -> Vec<f64> {
        let other: Vec<DVec3> = wo.iter().map(|&w| on_side(w, self.source.scattered())).collect();
        let bands = hue.basis().bands().count();
        let mut spectra = vec![0.0; wo.len() * bands];
        self.source.spectra(on_side(wi, self.source.incident()), &other, &mut spectra);
        let mut coefficients = Vec::with_capacity(wo.len() * hue.basis().rank());
        spectra.chunks_exact(bands).for_each(|f| hue.tell(f, &mut coefficients));
        coefficients
    }

    /// All channels of f at each of `wo`, 1/sr: (directions, channels).
    pub(super) fn colours(&self, wi: DVec3, wo: &[DVec3]) -> Vec<f32> {
        let other: Vec<DVec3> = wo.iter().map(|&w| on_side(w, self.source.scattered())).collect();
        let mut values = vec![0.0; wo.len() * self.channels()];
        self.slice(wi).eval(&other, &mut values);
        for value in &mut values {
            *value = if value.is_finite() { value.max(0.0) } else { 0.0 };
        }
        values
    }

    fn slice(&self, wi: DVec3) -> Box<dyn Slice + '_> {
        self.source.slice(on_side(wi, self.source.incident()))
    }

    /// Luminance alone.
    pub(super) fn values(&self, wi: DVec3, wo: &[DVec3]) -> Vec<f64> {
        let values = self.colours(wi, wo);
        values.iter().step_by(self.channels()).map(|&v| f64::from(v)).collect()
    }

    /// The share of f that is each followed peak's: (directions, peaks).
    pub(super) fn shares(&self, wi: DVec3, wo: &[DVec3]) -> Vec<f32> {
        let Some(followed) = &self.followed else { return vec![1.0; wo.len()] };
        let mut shares = vec![0.0; wo.len() * followed.count()];
        followed.shares(on_side(wi, self.source.incident()), wo, &mut shares);
        shares
    }

    /// Of every followed peak the law that it obeys most nearly: which multiple of the incident cosines its middle is, but for
    /// what changes least.
    pub(super) fn factors(&self, chart: &Chart) -> Vec<f64> {
        let Some(followed) = &self.followed else { return Vec::new() };
        let wi: Vec<DVec3> = (0..chart.nodes()).map(|n| chart.direction(n)).collect();
        let all: Vec<_> =
            wi.iter().map(|&w| followed.extents(on_side(w, self.source.incident()))).collect();
        let spread = |k: usize, factor: f64| {
            let off =
                |(w, e): (&DVec3, &Vec<Option<Extent>>)| Some(e[k]?.centre - w.truncate() * factor);
            let offs: Vec<DVec2> = wi.iter().zip(&all).filter_map(off).collect();
            let mean = offs.iter().sum::<DVec2>() / offs.len().max(1) as f64;
            offs.iter().map(|o| o.distance_squared(mean)).sum::<f64>()
        };
        let best = |k: usize| {
            let least = |a: &f64, b: &f64| spread(k, *a).total_cmp(&spread(k, *b));
            [-1.0, 0.0, 1.0].into_iter().min_by(least).unwrap_or(-1.0)
        };
        (0..followed.count()).map(best).collect()
    }

    /// The poses of several courses at the nodes of a chart.
    pub(super) fn poses(&self, courses: &[(Frame, Course)], chart: &Chart) -> Vec<Vec<Pose>> {
        let wi: Vec<DVec3> = (0..chart.nodes()).map(|n| chart.direction(n)).collect();
        let tracked = courses.iter().any(|(_, c)| matches!(c, Course::Peak(_)));
        let followed = self.followed.as_ref().filter(|_| tracked);
        let extents: Vec<Vec<Option<Extent>>> = match followed {
            Some(f) => {
                wi.par_iter().map(|&w| f.extents(on_side(w, self.source.incident()))).collect()
            }
            None => Vec::new(),
        };
        let mirrored = chart.fold() == bsdfkit::render::Fold::IsotropicMirrored;
        let course = |&(frame, course): &(Frame, Course)| match course {
            Course::Law(stretch) => wi.iter().map(|&w| of_law(frame, stretch, w)).collect(),
            Course::Peak(k) => {
                let known: Vec<usize> =
                    (0..wi.len()).filter(|&n| extents[n][k].is_some()).collect();
                let of = |n: usize| {
                    let apart = |m: &usize| wi[*m].distance_squared(wi[n]);
                    let near = known.iter().copied().min_by(|a, b| apart(a).total_cmp(&apart(b)));
                    match near.and_then(|m| extents[m][k]) {
                        Some(extent) => of_extent(frame, extent, wi[near.unwrap_or(n)], mirrored),
                        None => Pose::about_normal(1.0),
                    }
                };
                (0..wi.len()).map(of).collect()
            }
        };
        courses.iter().map(course).collect()
    }
}

/// The pose of a law at an incident direction: stretched along the azimuth as the disk foreshortens.
fn of_law(frame: Frame, [xx, xy, yy]: [f64; 3], wi: DVec3) -> Pose {
    let centre = wi.truncate() * frame.factor;
    let more = match frame.kind {
        FrameKind::Slopes => 0.0,
        FrameKind::Cosines => {
            1.0 / (1.0 - centre.length_squared()).max(FLATTEST * FLATTEST).sqrt() - 1.0
        }
    };
    let e = centre.normalize_or_zero();
    // (1 + m e eᵀ) S (1 + m e eᵀ) has half of it on either side.
    let half = (1.0 + more).sqrt() - 1.0;
    let f = [1.0 + half * e.x * e.x, half * e.x * e.y, 1.0 + half * e.y * e.y];
    let columns = [
        DVec2::new(f[0] * xx + f[1] * xy, f[1] * xx + f[2] * xy),
        DVec2::new(f[0] * xy + f[1] * yy, f[1] * xy + f[2] * yy),
    ];
    let stretch = [
        columns[0].x * f[0] + columns[1].x * f[1],
        columns[0].y * f[0] + columns[1].y * f[1],
        columns[0].y * f[1] + columns[1].y * f[2],
    ];
    Pose { centre: [0.0; 2], stretch: stretch.map(|s| s as f32) }
}

/// The pose that makes a peak of this extent round and about one wide.
fn of_extent(frame: Frame, extent: Extent, wi: DVec3, mirrored: bool) -> Pose {
    let mut centre = extent.centre.clamp_length_max(0.995);
    let [mut xx, mut xy, mut yy] = extent.covariance;
    if mirrored {
        (centre.y, xy, yy) = (0.0, 0.0, yy + extent.centre.y * extent.centre.y);
    }
    if frame.kind == FrameKind::Slopes {
        // The covariance of slopes, by differences of them.
        let slope = |u: DVec2| {
            let z = (1.0 - u.length_squared()).max(FLATTEST * FLATTEST).sqrt();
            (u + wi.truncate()) / (wi.z.max(FLATTEST) + z)
        };
        let step = 1e-3;
        let inner = centre.clamp_length_max(0.99);
        let [x, y] = [DVec2::X, DVec2::Y]
            .map(|d| (slope(inner + d * step) - slope(inner - d * step)) / (2.0 * step));
        let (a, b) = (x * xx + y * xy, x * xy + y * yy);
        (xx, xy, yy) = (a.x * x.x + b.x * y.x, a.x * x.y + b.x * y.y, a.y * x.y + b.y * y.y);
    }
    // Eigenvalues within bounds; Σ^(-1/2) has their roots' inverses.
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let spread = (half * half + xy * xy).sqrt();
    let bound = |v: f64| 1.0 / v.max(0.0).sqrt().clamp(WIDTHS[0], WIDTHS[1]);
    let (long, short) = (bound(mean + spread), bound(mean - spread));
    let turn = if spread > 1e-12 { DVec2::new(half, xy) / spread } else { DVec2::X };
    let (m, d) = (0.5 * (long + short), 0.5 * (long - short));
    let stretch = [m + d * turn.x, d * turn.y, m - d * turn.x];
    let centre = centre - wi.truncate() * frame.factor;
    Pose { centre: centre.to_array().map(|c| c as f32), stretch: stretch.map(|s| s as f32) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit::render::View;

    #[test]
    fn a_pose_makes_its_peak_round_and_one_wide() {
        let chart = Chart::new(bsdfkit::render::Fold::None, 3, 1.0).unwrap();
        let (centre, covariance) = (DVec2::new(0.2, -0.3), [4e-4_f64, 1e-4, 9e-4]);
        let wi = DVec3::new(-0.2, 0.3, 0.87_f64.sqrt());
        // A point on the ellipse of one deviation: root of Σ times a unit vector, by Cholesky.
        let [xx, xy, yy] = covariance;
        let l = [xx.sqrt(), xy / xx.sqrt(), (yy - xy * xy / xx).sqrt()];
        for kind in [FrameKind::Cosines, FrameKind::Slopes] {
            let frame = Frame { kind, factor: 0.5 };
            let pose = of_extent(frame, Extent { centre, covariance }, wi, false);
            let view = View::new(&chart, frame, wi, &pose);
            for k in 0..12 {
                let e = DVec2::from_angle(f64::from(k) * 0.5);
                let u = centre + DVec2::new(l[0] * e.x, l[1] * e.x + l[2] * e.y) * 0.2;
                let q = view.place(u.extend((1.0 - u.length_squared()).sqrt())).length();
                assert!((q / 0.2 - 1.0).abs() < 0.03, "{kind:?} {k}: {q}");
            }
        }
    }
}
