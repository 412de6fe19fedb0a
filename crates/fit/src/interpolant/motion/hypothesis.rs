//! How lobes are taken to move between incidences.

use serde::{Deserialize, Serialize};

use crate::interpolant::mesh::chart::Chart;
use bsdfkit_measure::frame::Frame;

/// One hypothesis on motion; which one holds for a material is found by `choose::select`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Coordinates in which lobes are compared.
    pub frame: Frame,
    /// Squared distance in frame coordinates beyond which mass does not travel but fades; 0 is plain
    /// blending in the frame.
    pub reach: f64,
    /// Whether tracks follow their curvature (second order) or the straight line between incidences.
    pub curved: bool,
    /// Layout of incident directions in which weights are linear.
    #[serde(default)]
    pub chart: Chart,
    /// Laws that lobes follow which do not move as the others do.
    #[serde(default)]
    pub laws: [Option<Frame>; 3],
    /// How much past the outermost incidences scattering goes on changing, in proportion to its change on the way there.
    #[serde(default)]
    pub onward: f64,
}

/// Laws beside the motion of all others, at most.
pub(crate) const MOST_LAWS: usize = 3;

/// The reaches tried: 18 degrees near the normal (peaks farther apart are different peaks), 6
/// degrees, and none. A guess.
pub(crate) const REACHES: [f64; 3] = [0.1, 0.01, 0.0];

/// How far apart along grooves incidences are taken to be, in proportion.
pub(crate) const SHARES: [f64; 2] = [0.3, 0.1];

/// The shares of change past the outermost incidences that are tried.
pub(crate) const ONWARD: [f64; 3] = [0.0, 0.5, 1.0];

impl Motion {
    /// Straight tracks in `frame` with the longest of the [`REACHES`].
    pub fn straight(frame: Frame) -> Self {
        let (reach, chart) = (REACHES[0], Chart::Disk);
        Self { frame, reach, curved: false, chart, laws: [None; 3], onward: 0.0 }
    }

    /// What of it cannot be, what was expected, and what was found.
    pub(crate) fn wrong(&self) -> Option<(&'static str, &'static str, f64)> {
        if !(0.0..=1.0).contains(&self.onward) {
            return Some(("motion.onward", "0 to 1", self.onward));
        }
        if !(0.0..=4.0).contains(&self.reach) {
            return Some(("motion.reach", "0 to 4", self.reach));
        }
        if let Chart::Profile { azimuth, share } = self.chart {
            if !(1e-3..=1.0).contains(&share) {
                return Some(("motion.chart.share", "0.001 to 1", share));
            }
            if !azimuth.is_finite() {
                return Some(("motion.chart.azimuth", "a number", azimuth));
            }
        }
        self.laws().into_iter().chain([self.frame]).find_map(Frame::wrong)
    }

    /// The laws.
    pub fn laws(&self) -> Vec<Frame> {
        self.laws.iter().flatten().copied().collect()
    }

    /// The same with one law more; [`MOST_LAWS`] at most.
    #[must_use]
    pub fn with_law(mut self, law: Frame) -> Self {
        if let Some(free) = self.laws.iter_mut().find(|l| l.is_none()) {
            *free = Some(law);
        }
        self
    }
}
