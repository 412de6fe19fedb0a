//! What makes a peak round that goes along with a law.

use bsdfkit::render::{Chart, Fold, Frame, Place, Pose, View};
use bsdfkit_sphere::{DVec2, DVec3};

use super::subject::Subject;

/// Ratio of widths below which a peak counts as round.
const ROUND: f64 = 1.15;

/// How far from its middle a peak is looked at, in the plane: others are not its own.
const NEAR: f64 = 0.6;

/// Cells that are looked at about the peak, and how far from it they begin to widen.
const CELLS: (usize, usize) = (64, 96);
const CORE: f64 = 0.01;

/// Bounds of a width.
const WIDTHS: [f64; 2] = [0.005, 0.5];

/// The stretches to try for the peak that is where the law of `frame` has it, from the part of it above half its
/// height, near the normal: one that leaves it as round as it is, and one that makes it round, where that is another and
/// the symmetry of tables allows it. Both make it about one wide.
pub(super) fn of(subject: &Subject<'_>, chart: &Chart, frame: Frame) -> Vec<[f64; 3]> {
    let wi = DVec3::new(0.02, 0.01, (1.0_f64 - 0.0005).sqrt());
    let view = View::new(chart, frame, wi, &Pose::about_normal(1.0));
    let places = view.cells(CELLS.0, CELLS.1, CORE);
    let wo: Vec<DVec3> = places.iter().map(|p| p.wo).collect();
    let values = subject.values(wi, &wo);
    let near = |p: &Place| view.place(p.wo).length() < NEAR;
    let about = places.iter().zip(&values).filter(|(p, _)| near(p)).map(|(_, v)| *v);
    let half = 0.5 * about.fold(0.0, f64::max);
    let (mut xx, mut xy, mut yy, mut sum) = (0.0, 0.0, 0.0, 0.0);
    for (place, value) in places.iter().zip(values) {
        if value > half && near(place) {
            let q: DVec2 = view.place(place.wo);
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
    let det = xx * yy - xy * xy;
    if !(det > 0.0 && det.is_finite()) {
        return vec![[10.0, 0.0, 10.0]];
    }
    let root = det.sqrt();
    let per = 1.0 / root.sqrt().clamp(WIDTHS[0], WIDTHS[1]);
    let round = [per, 0.0, per];
    // Σ^(-1/2) = (Σ⁻¹ + I/√det) / √(tr Σ⁻¹ + 2/√det), times det^(1/4).
    let (a, b, c) = (yy / det + 1.0 / root, -xy / det, xx / det + 1.0 / root);
    let trace = (xx + yy) / det + 2.0 / root;
    let scale = per * root.sqrt() / trace.sqrt();
    let stretch = [a * scale, b * scale, c * scale];
    let spread = ((0.5 * (xx - yy)).powi(2) + xy * xy).sqrt();
    let ratio = ((0.5 * (xx + yy) + spread) / (0.5 * (xx + yy) - spread)).sqrt();
    let sound = stretch.iter().all(|s| s.is_finite()) && !chart.fold().is_isotropic();
    if ratio > ROUND && sound { vec![round, stretch] } else { vec![round] }
}
