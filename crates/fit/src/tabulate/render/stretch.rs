//! What makes a peak round.

use bsdfkit::render::{Chart, Fold, Frame, Place, View};
use bsdfkit_sphere::{DVec2, DVec3};

use super::probe::Sides;
use crate::source::Source;

/// Ratio of widths below which a peak counts as round.
const ROUND: f64 = 1.15;

/// How far from its middle a peak is looked at, in the plane: others are not its own.
const NEAR: f64 = 0.6;

/// Cells that are looked at about the peak.
const CELLS: (usize, usize) = (64, 96);

/// The part of a peak above half its height, near the normal.
pub(super) struct Extent {
    /// The stretch, of determinant 1, that makes it round; `None` where it is round, or where another stretch
    /// would break the symmetry of tables.
    pub(super) stretch: Option<[f64; 3]>,
    /// Its width in the plane, once it is round: a standard deviation of its area.
    pub(super) width: f64,
}

/// The extent of the peak of a frame.
pub(super) fn of(source: &dyn Source, chart: &Chart, frame: &Frame) -> Extent {
    let plain = Frame { stretch: [1.0, 0.0, 1.0], ..*frame };
    let wi = DVec3::new(0.02, 0.01, (1.0_f64 - 0.0005).sqrt());
    let view = View::new(chart, &plain, wi, DVec2::ZERO);
    let places = view.cells(CELLS.0, CELLS.1, 0.01);
    let wo: Vec<DVec3> = places.iter().map(|p| p.wo).collect();
    let values = Sides::of(source).values(source, wi, &wo);
    let near = |p: &Place| view.squared(p.wo) < NEAR * NEAR;
    let about = places.iter().zip(&values).filter(|(p, _)| near(p)).map(|(_, v)| *v);
    let half = 0.5 * about.fold(0.0, f64::max);
    let (mut xx, mut xy, mut yy, mut sum) = (0.0, 0.0, 0.0, 0.0);
    for (place, value) in places.iter().zip(values) {
        if value > half && near(place) {
            let q = view.place(place.wo);
            let size = place.size;
            xx += size * q.x * q.x;
            xy += size * q.x * q.y;
            yy += size * q.y * q.y;
            sum += size;
        }
    }
    (xx, xy, yy) = (xx / sum, xy / sum, yy / sum);
    if matches!(chart.fold(), Fold::Quadrants | Fold::MirrorX | Fold::MirrorY) {
        xy = 0.0;
    }
    // Σ^(-1/2) = (Σ⁻¹ + I/√det) / √(tr Σ⁻¹ + 2/√det), times det^(1/4).
    let det = xx * yy - xy * xy;
    if !(det > 0.0 && det.is_finite()) {
        return Extent { stretch: None, width: 0.1 };
    }
    let root = det.sqrt();
    let (a, b, c) = (yy / det + 1.0 / root, -xy / det, xx / det + 1.0 / root);
    let trace = (xx + yy) / det + 2.0 / root;
    let scale = root.sqrt() / trace.sqrt();
    let stretch = [a * scale, b * scale, c * scale];
    let spread = ((0.5 * (xx - yy)).powi(2) + xy * xy).sqrt();
    let ratio = ((0.5 * (xx + yy) + spread) / (0.5 * (xx + yy) - spread)).sqrt();
    let sound = stretch.iter().all(|s| s.is_finite());
    let turns = chart.fold().is_isotropic();
    let stretch = (ratio > ROUND && sound && !turns).then_some(stretch);
    Extent { stretch, width: root.sqrt() }
}
