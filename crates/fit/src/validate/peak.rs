//! Peaks of a distribution: where they are, and how far a prediction misses them.

use bsdfkit::{DVec3, Side};
use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::concentric::square_to_hemisphere;

/// How a prediction misses one peak of f |cos θₒ|.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeakError {
    /// Direction of the measured peak.
    pub direction: DVec3,
    /// f |cos θₒ| there, 1/sr.
    pub height: f64,
    /// From the measured peak to the predicted one.
    pub offset_degrees: f64,
    /// Height of the predicted peak over that of the measured one.
    pub height_ratio: f64,
}

/// A local maximum of f |cos θₒ|.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peak {
    pub(crate) direction: DVec3,
    pub(crate) height: f64,
}

/// Cells across the square of directions in which peaks are looked for: about 1 degree.
const CELLS: usize = 96;
/// A maximum below this share of the largest, or nearer to a larger one than this, is no peak of
/// its own.
const LEAST_SHARE: f64 = 0.15;
const APART_DEGREES: f64 = 12.0;
/// More are not told apart: a flat distribution has maxima everywhere.
const MOST: usize = 4;
/// First and last step of the climb.
const STEPS_DEGREES: (f64, f64) = (1.0, 0.02);

/// What is looked at: one distribution within the measured directions.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    /// f in 1/sr.
    pub(crate) f: &'a dyn Fn(DVec3) -> f64,
    pub(crate) side: Side,
    /// Largest sin θₒ.
    pub(crate) limit: f64,
}

impl View<'_> {
    /// f |cos θₒ|, 1/sr.
    pub(crate) fn height(&self, w: DVec3) -> f64 {
        (self.f)(w) * w.z.abs()
    }

    fn allows(&self, w: DVec3) -> bool {
        w.truncate().length() <= self.limit && Side::of(w) == self.side
    }

    /// Peaks, the highest first.
    pub(crate) fn peaks(&self) -> Vec<Peak> {
        let middle = |k: usize| {
            let square = DVec2::new((k / CELLS) as f64 + 0.5, (k % CELLS) as f64 + 0.5);
            square_to_hemisphere(square / CELLS as f64, self.side)
        };
        let mut all: Vec<Peak> = (0..CELLS * CELLS)
            .map(middle)
            .filter(|&w| self.allows(w))
            .map(|w| Peak { direction: w, height: self.height(w) })
            .collect();
        all.sort_by(|a, b| b.height.total_cmp(&a.height));
        let apart = APART_DEGREES.to_radians().cos();
        let mut peaks: Vec<Peak> = Vec::new();
        for &candidate in &all {
            let low = candidate.height < LEAST_SHARE * all[0].height;
            if peaks.len() == MOST || low || candidate.height <= 0.0 {
                break;
            }
            if peaks.iter().all(|p| p.direction.dot(candidate.direction) < apart) {
                peaks.push(candidate);
            }
        }
        // A shoulder of a larger peak climbs to where its cone ends: no maximum.
        let own = |p: Peak| {
            let top = self.climb(p, p.direction, APART_DEGREES);
            (top.direction.angle_between(p.direction).to_degrees() < 0.5 * APART_DEGREES)
                .then_some(top)
        };
        peaks.into_iter().filter_map(own).collect()
    }

    /// How this view, a prediction, misses `peak`, whose nearest neighbour is `room` degrees away.
    pub(crate) fn miss(&self, peak: Peak, room: f64) -> PeakError {
        let reach = (0.5 * room).min(APART_DEGREES);
        let (u, v) = peak.direction.any_orthonormal_pair();
        let steps = 24i32;
        let pitch = reach.to_radians() / f64::from(steps);
        let mut best = Peak { direction: peak.direction, height: self.height(peak.direction) };
        for i in -steps..=steps {
            for j in -steps..=steps {
                let w = peak.direction + pitch * (f64::from(i) * u + f64::from(j) * v);
                let w = w.normalize();
                if i * i + j * j <= steps * steps && self.allows(w) {
                    let height = self.height(w);
                    if height > best.height {
                        best = Peak { direction: w, height };
                    }
                }
            }
        }
        let best = self.climb(best, peak.direction, reach);
        PeakError {
            direction: peak.direction,
            height: peak.height,
            offset_degrees: best.direction.angle_between(peak.direction).to_degrees(),
            height_ratio: best.height / peak.height,
        }
    }

    /// Uphill from `from`, within `reach` degrees of `centre`.
    fn climb(&self, from: Peak, centre: DVec3, reach: f64) -> Peak {
        let within = reach.to_radians().cos();
        let (mut best, mut step) = (from, STEPS_DEGREES.0);
        while step > STEPS_DEGREES.1 {
            let (u, v) = best.direction.any_orthonormal_pair();
            let around = [u, -u, v, -v].map(|d| {
                let w = (best.direction + step.to_radians() * d).normalize();
                let inside = self.allows(w) && w.dot(centre) >= within;
                Peak { direction: w, height: if inside { self.height(w) } else { f64::MIN } }
            });
            match around.into_iter().max_by(|a, b| a.height.total_cmp(&b.height)) {
                Some(higher) if higher.height > best.height => best = higher,
                _ => step *= 0.5,
            }
        }
        best
    }
}
