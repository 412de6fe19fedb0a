//! What a table is to be made of.

use bsdfkit::render::{Chart, Frame, FrameKind, Shape, View};
use bsdfkit_sphere::{DVec2, DVec3};

use super::track::Seed;
use crate::source::Source;

/// A layer: the form of its tables, and where its peak is that follows no simple law.
#[derive(Clone, Debug)]
pub(super) struct Planned {
    pub(super) shape: Shape,
    /// Where the peak was found that is followed.
    pub(super) seed: Option<Seed>,
    /// What is added to the law at each node of the finer chart; or none.
    pub(super) moved: Vec<[f32; 2]>,
}

/// Nodes and layers.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) chart: Chart,
    pub(super) layers: Vec<Planned>,
}

impl Plan {
    /// The same layers on another chart; peaks are followed anew.
    pub(super) fn on(&self, source: &dyn Source, chart: Chart) -> Self {
        let layer = |l: &Planned| {
            let moved =
                l.seed.map_or(Vec::new(), |seed| seed.track(source, &chart, &l.shape.frame));
            Planned { moved, ..l.clone() }
        };
        Self { chart, layers: self.layers.iter().map(layer).collect() }
    }

    /// Tables that are drawn from alone.
    pub(super) fn without_values(mut self) -> Self {
        for layer in &mut self.layers {
            let shape = &mut layer.shape;
            (shape.angles, shape.radii) = (0, 0);
            (shape.colour_angles, shape.colour_radii) = (0, 0);
        }
        self
    }

    /// The coordinates of each layer for an incident direction.
    pub(super) fn views(&self, wi: DVec3) -> Vec<View> {
        let blend = self.chart.refined(2).blend(wi);
        let view = |l: &Planned| {
            let of = |node: usize, k: usize| l.moved.get(node).map_or(0.0, |m| f64::from(m[k]));
            let sum = |k| blend.iter().map(|&(node, weight)| weight * of(node, k)).sum();
            View::new(&self.chart, &l.shape.frame, wi, DVec2::new(sum(0), sum(1)))
        };
        self.layers.iter().map(view).collect()
    }
}

/// Bytes of tables of these forms.
pub(super) fn bytes<'a>(
    chart: &Chart,
    shapes: impl Iterator<Item = &'a Shape>,
    channels: usize,
) -> usize {
    let layer = |s: &Shape| {
        let values = (s.angles + 1) * (s.radii + 1);
        let colour =
            if channels == 3 { 2 * (s.colour_angles + 1) * (s.colour_radii + 1) } else { 0 };
        let drawn = (s.drawn_angles + 1) * (s.drawn_radii + 1);
        let sums = (s.drawn_angles + 1) * (s.drawn_radii / 4 + 2);
        2 * (values + colour + drawn) + 4 * sums
    };
    chart.nodes() * shapes.map(layer).sum::<usize>()
}

/// A frame of slopes.
pub(super) fn slopes(stretch: [f64; 3]) -> Frame {
    Frame { kind: FrameKind::Slopes, law: [[0.0; 2]; 2], offset: [0.0; 2], stretch }
}

/// A frame about `factor` times the incident direction's cosines.
pub(super) fn cosines(factor: f64, stretch: [f64; 3]) -> Frame {
    let law = [[factor, 0.0], [0.0, factor]];
    Frame { kind: FrameKind::Cosines, law, offset: [0.0; 2], stretch }
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
