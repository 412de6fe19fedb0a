//! What a table is to be made of.

use bsdfkit::render::{Chart, Frame, FrameKind, Shape, View};
use bsdfkit_sphere::{DVec2, DVec3};

/// Nodes and layers.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) chart: Chart,
    pub(super) layers: Vec<Shape>,
}

impl Plan {
    /// Bytes of its arrays.
    pub(super) fn bytes(&self, channels: usize) -> usize {
        let layer = |s: &Shape| {
            let values = (s.angles + 1) * (s.radii + 1);
            let colour =
                if channels == 3 { 2 * (s.colour_angles + 1) * (s.colour_radii + 1) } else { 0 };
            let drawn = (s.drawn_angles + 1) * (s.drawn_radii + 1);
            let sums = (s.drawn_angles + 1) * (s.drawn_radii / 4 + 2);
            2 * (values + colour + drawn) + 4 * sums
        };
        self.chart.nodes() * self.layers.iter().map(layer).sum::<usize>()
    }

    /// The coordinates of each layer for an incident direction.
    pub(super) fn views(&self, wi: DVec3) -> Vec<View> {
        views(&self.chart, self.layers.iter().map(|s| &s.frame), wi)
    }
}

pub(super) fn views<'a>(
    chart: &Chart,
    frames: impl Iterator<Item = &'a Frame>,
    wi: DVec3,
) -> Vec<View> {
    frames.map(|frame| View::new(chart, frame, wi, DVec2::ZERO)).collect()
}

/// A frame of slopes.
pub(super) fn slopes(stretch: [f64; 3]) -> Frame {
    Frame { kind: FrameKind::Slopes, law: [[0.0; 2]; 2], stretch }
}

/// A frame about `factor` times the incident direction's cosines.
pub(super) fn cosines(factor: f64, stretch: [f64; 3]) -> Frame {
    Frame { kind: FrameKind::Cosines, law: [[factor, 0.0], [0.0, factor]], stretch }
}

/// No stretch.
pub(super) const PLAIN: [f64; 3] = [1.0, 0.0, 1.0];

/// The share of f at a direction that each of several layers takes: most the one whose peak is nearest.
///
/// Sums to 1, and changes as smoothly as the peaks' distances.
pub(super) fn shares(views: &[View], wo: DVec3, out: &mut [f64]) {
    if let [out] = out {
        *out = 1.0;
        return;
    }
    for (view, out) in views.iter().zip(&mut *out) {
        let squared = view.squared(wo) + NEAR;
        *out = 1.0 / (squared * squared);
    }
    let sum: f64 = out.iter().sum();
    out.iter_mut().for_each(|share| *share /= sum);
}

/// Square of the distance within which a peak's layer takes all.
const NEAR: f64 = 1e-5;
