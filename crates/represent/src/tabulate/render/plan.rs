//! What a table is to be made of.

use bsdfkit::render::{Chart, Frame, Pose, Shape, View};
use bsdfkit_sphere::DVec3;

use super::subject::{Course, Subject};

/// A layer: where it goes, and the form of its tables.
#[derive(Clone, Debug)]
pub(super) struct Planned {
    pub(super) course: Course,
    pub(super) shape: Shape,
    /// Peaks whose light it has; empty: it has all.
    pub(super) peaks: Vec<usize>,
    /// Cells of hue about the peak and outward; 0 without spectra.
    pub(super) hue: [usize; 2],
}

/// What tables have beside values: colour, coefficients of hue.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beside {
    pub(super) coloured: bool,
    pub(super) rank: usize,
}

impl Beside {
    /// Nothing.
    pub(super) const NONE: Self = Self { coloured: false, rank: 0 };

    /// All that the subject has.
    pub(super) fn of(subject: &Subject<'_>) -> Self {
        let rank = subject.hue().map_or(0, |hue| hue.basis().rank());
        Self { coloured: subject.channels() == 3, rank }
    }
}

impl Planned {
    /// Of values of f the part that this layer has; `shares` of all peaks at each.
    pub(super) fn take(&self, values: &mut [f64], shares: &[f32]) {
        if self.peaks.is_empty() || values.is_empty() {
            return;
        }
        let count = shares.len() / values.len();
        for (value, shares) in values.iter_mut().zip(shares.chunks_exact(count)) {
            let share: f32 = self.peaks.iter().map(|&k| shares[k]).sum();
            *value *= f64::from(share);
        }
    }
}

/// Nodes and layers.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) chart: Chart,
    pub(super) layers: Vec<Planned>,
    /// Of each layer at each node of the finer chart.
    pub(super) poses: Vec<Vec<Pose>>,
}

impl Plan {
    pub(super) fn new(subject: &Subject<'_>, chart: Chart, layers: Vec<Planned>) -> Self {
        let courses: Vec<(Frame, Course)> =
            layers.iter().map(|l| (l.shape.frame, l.course)).collect();
        let poses = subject.poses(&courses, &chart.refined(2));
        Self { chart, layers, poses }
    }

    /// Tables that are drawn from alone.
    pub(super) fn without_values(mut self) -> Self {
        for layer in &mut self.layers {
            let shape = &mut layer.shape;
            (shape.angles, shape.radii) = (0, 0);
            (shape.colour_angles, shape.colour_radii) = (0, 0);
            layer.hue = [0; 2];
        }
        self
    }

    /// The coordinates of each layer for an incident direction.
    pub(super) fn views(&self, wi: DVec3) -> Vec<View> {
        let blend = self.chart.refined(2).blend(wi);
        let view = |(layer, poses): (&Planned, &Vec<Pose>)| {
            let mut sum = Pose { centre: [0.0; 2], stretch: [0.0; 3] };
            for &(node, weight) in &blend {
                let (pose, w) = (&poses[node], weight as f32);
                sum.centre.iter_mut().zip(pose.centre).for_each(|(s, v)| *s += w * v);
                sum.stretch.iter_mut().zip(pose.stretch).for_each(|(s, v)| *s += w * v);
            }
            View::new(&self.chart, layer.shape.frame, wi, &sum)
        };
        self.layers.iter().zip(&self.poses).map(view).collect()
    }
}

/// Bytes of all arrays of layers of these forms.
pub(super) fn bytes<'a>(
    chart: &Chart,
    shapes: impl Iterator<Item = &'a Shape>,
    beside: Beside,
) -> usize {
    let layer = |s: &Shape| {
        let values = (s.angles + 1) * (s.radii + 1);
        // Hue has as many cells as colour.
        let numbers = if beside.coloured { 2 } else { 0 } + beside.rank;
        let colour = numbers * (s.angles / 2 + 1) * (s.radii / 2 + 1);
        let drawn = (s.drawn_angles + 1) * (s.drawn_radii + 1);
        let sums = (s.drawn_angles + 1) * (s.drawn_radii / 4 + 2);
        2 * (values + colour + drawn) + 4 * sums
    };
    let (mut layers, mut tables) = (0, 0);
    for shape in shapes {
        (layers, tables) = (layers + 1, tables + layer(shape));
    }
    // Of each node of the finer chart a total, and poses and factors.
    chart.nodes() * tables + chart.refined(2).nodes() * 4 * (1 + 6 * layers)
}

/// The part of each of several views at a direction, most of the one whose peak is nearest: for adding up over all of them.
///
/// Sums to 1, and changes as smoothly as the peaks' distances.
pub(super) fn parts(views: &[View], wo: DVec3, out: &mut [f64]) {
    for (view, out) in views.iter().zip(&mut *out) {
        let squared = view.apart(wo) + NEAR;
        *out = 1.0 / (squared * squared);
    }
    let sum: f64 = out.iter().sum();
    out.iter_mut().for_each(|part| *part /= sum);
}

/// Square of the distance within which a peak's view takes all.
const NEAR: f64 = 1e-5;
