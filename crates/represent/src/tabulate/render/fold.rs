//! Which symmetry a source has.

use bsdfkit::render::Fold;
use bsdfkit_sphere::{DVec2, DVec3};

use super::probe::golden;
use super::subject::Subject;

/// Relative difference of values that counts as none: rounding of f32 in sums of many terms.
const SAME: f64 = 1e-4;

/// Incidences and scattered directions of each that are compared.
const COMPARED: (usize, usize) = (12, 48);

/// The largest symmetry that values at some pairs of directions do not contradict.
pub(super) fn of(subject: &Subject<'_>) -> Fold {
    let (incidences, scattered) = COMPARED;
    let holds = |map: &dyn Fn(DVec2) -> DVec2| {
        let turned = |w: DVec3| map(w.truncate()).extend(w.z);
        (0..incidences).all(|n| {
            let wi = golden(n, incidences);
            let wi = if subject.isotropic() {
                DVec2::new(wi.truncate().length(), 0.0).extend(wi.z)
            } else {
                wi
            };
            // Everywhere, and about where light is mirrored or goes through.
            let other = |k: usize| {
                let near = DVec2::from_angle(k as f64 * 2.4) * (0.02 * k as f64 / scattered as f64);
                match k % 2 {
                    0 => golden(k, scattered),
                    _ => {
                        let xy = (near - wi.truncate()).clamp_length_max(0.999);
                        xy.extend((1.0 - xy.length_squared()).sqrt())
                    }
                }
            };
            let wo: Vec<DVec3> = (0..scattered).map(other).collect();
            let here = subject.values(wi, &wo);
            let there: Vec<DVec3> = wo.iter().map(|&w| turned(w)).collect();
            let there = subject.values(turned(wi), &there);
            let most = here.iter().copied().fold(0.0, f64::max);
            here.iter().zip(&there).all(|(a, b)| (a - b).abs() <= SAME * a.max(1e-3 * most))
        })
    };
    let x = |v: DVec2| DVec2::new(-v.x, v.y);
    let y = |v: DVec2| DVec2::new(v.x, -v.y);
    if subject.isotropic() {
        return if holds(&y) { Fold::IsotropicMirrored } else { Fold::Isotropic };
    }
    match (holds(&x), holds(&y)) {
        (true, true) => Fold::Quadrants,
        (true, false) => Fold::MirrorX,
        (false, true) => Fold::MirrorY,
        (false, false) if holds(&|v| -v) => Fold::HalfTurn,
        (false, false) => Fold::None,
    }
}
