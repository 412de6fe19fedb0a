//! How lobes are taken to move between incidences.

use serde::{Deserialize, Serialize};

use crate::interpolant::mesh::chart::Chart;
use crate::lobe::frame::Frame;
use crate::lobe::{Lobe, LobeSet};

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
    /// Whether broad lobes (a deviation of 10 degrees and more) stay where they are in the hemisphere, as diffuse light does
    /// beside a peak that moves.
    #[serde(default)]
    pub still: bool,
    /// How much past the outermost incidences scattering goes on changing, in proportion to its change on the way there.
    #[serde(default)]
    pub onward: f64,
}

/// Fourth root of the determinant of a covariance, in frame coordinates, from which on a lobe may be diffuse
/// light: 10 degrees of direction near the normal, in the frame of half vectors 20. At 0.25 parts of diffuse light moved with
/// the beam of fritted glass (0.0019 instead of 0.0014 with seven incidences); 0.12 is as good.
const BROAD: f64 = 0.17;

/// The reaches tried: 18 degrees near the normal (peaks farther apart are different peaks), 6
/// degrees, and none. A guess.
pub(crate) const REACHES: [f64; 3] = [0.1, 0.01, 0.0];

/// The shares of change past the outermost incidences that are tried.
pub(crate) const ONWARD: [f64; 3] = [0.0, 0.5, 1.0];

impl Motion {
    /// Straight tracks in `frame` with the longest of the [`REACHES`].
    pub fn straight(frame: Frame) -> Self {
        let (reach, chart) = (REACHES[0], Chart::Disk);
        Self { frame, reach, curved: false, chart, still: false, onward: 0.0 }
    }

    /// All hypotheses with `frame`.
    pub fn all(frame: Frame) -> impl Iterator<Item = Self> {
        let of = move |reach| {
            // Lobes that travel need a layout in which their tracks are affine.
            let chart = if reach > 0.0 { Chart::Disk } else { Chart::Beneath };
            [false, true].map(|curved| Self { reach, curved, chart, ..Self::straight(frame) })
        };
        REACHES.into_iter().flat_map(of).filter(|m| m.reach > 0.0 || !m.curved)
    }

    /// The lobes of a vertex that move, and those that do not.
    pub(crate) fn split(&self, set: LobeSet) -> (LobeSet, Vec<Lobe>) {
        let stays = |l: &Lobe| self.still && l.covariance.determinant() > BROAD.powi(4);
        let (still, lobes) = set.lobes.into_iter().partition(stays);
        (LobeSet { floor: set.floor, lobes }, still)
    }
}
