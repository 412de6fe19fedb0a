//! Past the rim of the mesh scattering goes on changing as it did on the way there, or half as much, where left-out
//! incidences are foretold better so.
//!
//! In the frame in which lobes move, what lies inside the mesh as far from the rim, what is on the rim, and
//! what is sought are at equal steps, and f grows from each to the next by the same factor. A constant in the
//! frame instead errs by up to three times as much at grazing incidence.

use bsdfkit::DVec3;

use crate::interpolant::mesh::chart::Chart;

/// f changes by this factor at most from the rim on. With 2 to 100 errors at grazing incidence of rough dielectrics
/// fall by a third, others hardly depend on it: ten is for peaks that came to the rim all at once.
const MOST: f64 = 10.0;
/// Nearer to the rim than this, in the chart, there is nothing past it.
const ON_RIM: f64 = 1e-6;

/// The direction inside as far from `rim` as `wi` is past it, on a line in the chart; from far out less, never farther in
/// than the normal is. `None` where `wi` is not past the rim.
pub(crate) fn inner(chart: Chart, rim: DVec3, wi: DVec3) -> Option<DVec3> {
    let on_rim = chart.place(rim);
    let out = chart.place(wi) - on_rim;
    let (way, most) = (out.length(), on_rim.length());
    (way > ON_RIM).then(|| chart.direction(on_rim - out * (most / (most + way))))
}

/// The factor by which f changes from the rim on, if it did so from `inner` to `rim`.
#[inline(always)]
pub(crate) fn change(rim: f64, inner: f64, epsilon: f64) -> f64 {
    ((rim + epsilon) / (inner + epsilon)).clamp(1.0 / MOST, MOST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpolant::component::planned::{Peaks, Planned};
    use crate::interpolant::field::energy::Energy;
    use crate::interpolant::{Component, Distribution, Fitted, FittedIncidence, Frame, Motion};
    use crate::lobe::LobeSet;
    use crate::lobe::detail::Detail;
    use bsdfkit::Side;
    use bsdfkit_measure::{Seen, Symmetry};
    use bsdfkit_represent::Slice;
    use bsdfkit_sphere::direction::from_degrees;

    #[test]
    fn inside_is_as_far_as_past_the_rim_but_never_beyond_the_normal() {
        for chart in [Chart::Disk, Chart::Beneath] {
            let rim = from_degrees(60.0, 70.0);
            let at = |theta: f64| inner(chart, rim, from_degrees(theta, 70.0)).expect("past");
            let far = |wi: DVec3| chart.place(wi).distance(chart.place(rim));
            for (theta, share) in [(60.01, 0.999), (61.0, 0.95), (89.9, 0.1)] {
                let ways = far(at(theta)) / far(from_degrees(theta, 70.0));
                assert!(ways > share && ways < 1.0, "{chart:?} {theta}: {ways}");
                assert!(at(theta).dot(rim.with_z(0.0)) > 0.0, "{chart:?} {theta}");
            }
            assert_eq!(inner(chart, rim, rim), None);
            let normal = inner(chart, DVec3::Z, from_degrees(10.0, 0.0)).expect("past");
            assert!(normal.distance(DVec3::Z) < 1e-12);
        }
    }

    /// Matte incidences: polar angle, azimuth, f.
    fn matte(symmetry: Symmetry, incidences: &[(f64, f64, f64)]) -> Planned {
        let of = |&(theta, phi, floor): &(f64, f64, f64)| FittedIncidence {
            wi: from_degrees(theta, phi),
            lobes: LobeSet { floor, lobes: Vec::new() },
            details: vec![Detail::fit([DVec3::Z], &[1.0], &[1.0], 8)],
            coefficients: Vec::new(),
            points: 1,
            hemispherical: 1.0,
            fit_error: 0.0,
            limit: 1.0,
            seen: Seen::whole(),
        };
        let motion = Motion { reach: 0.0, onward: 1.0, ..Motion::straight(Frame::Fixed) };
        let incidences = incidences.iter().map(of).collect();
        let (incident, scattered) = (Side::Front, Side::Front);
        let fitted =
            Fitted { incident, scattered, symmetry, epsilon: 1e-9, spectra: None, incidences };
        Planned::new(fitted, motion, Peaks::Apart).expect("mesh")
    }

    #[test]
    fn what_grows_inside_grows_as_much_past_the_rim() {
        let chain = [(0.0, 0.0, 0.1), (30.0, 0.0, 0.1), (60.0, 0.0, 0.2)];
        let c = matte(Symmetry::Isotropic, &chain);
        let wo = [10.0, 20.0, 30.0].map(|phi| from_degrees(20.0, phi));
        let f = |wi: DVec3| c.at(wi).eval(wo[1]);
        let rim = from_degrees(60.0, 0.0);
        for theta in [60.1, 65.0, 75.0, 89.0] {
            let wi = from_degrees(theta, 0.0);
            let within = f(inner(Chart::Disk, rim, wi).expect("past"));
            assert!(within < 0.2 && (f(wi) / (0.04 / within) - 1.0).abs() < 1e-5, "{theta}");
            let mut together = [0.0f32; 3];
            Slice::eval(&c.at(wi), &wo, &mut together);
            assert!(together.iter().all(|v| (f64::from(*v) / f(wi) - 1.0).abs() < 1e-5), "{theta}");
        }
        assert!((f(from_degrees(60.000_01, 0.0)) / 0.2 - 1.0).abs() < 1e-5);
    }

    #[test]
    fn cells_that_straddle_a_mirror_grow_alike_on_both_sides() {
        let angles = [(30.0, 15.0, 0.1), (30.0, 75.0, 0.3), (60.0, 15.0, 0.5), (60.0, 75.0, 0.2)];
        let c = matte(Symmetry::Quadrilateral, &angles);
        let f = |wi: DVec3| c.at(wi).eval(from_degrees(20.0, 130.0));
        let (mut straddling, mesh) = (0, &c.mesh);
        for (theta, phi) in [(61.0, 3.0), (64.0, -7.0), (70.0, 87.0), (66.0, 95.0), (65.0, 40.0)] {
            let wi = c.fitted.symmetry.fold(from_degrees(theta, phi)).0;
            let rim = mesh.between(&mesh.locate(wi).weights(&mesh.topology));
            let inner = inner(Chart::Disk, rim, wi).expect("past");
            let grown = f(rim).powi(2) / f(inner);
            assert!((f(wi) / grown - 1.0).abs() < 1e-5, "{theta} {phi}: {} {grown}", f(wi));
            straddling += usize::from(c.at(inner).twin.is_some());
        }
        assert!(straddling > 0);
    }

    #[test]
    fn energy_is_corrected_once() {
        let chain = [(0.0, 0.0, 0.1), (30.0, 0.0, 0.1), (60.0, 0.0, 0.2)];
        let plain = matte(Symmetry::Isotropic, &chain);
        let energy = Energy::from_parts(0.0, 0.0, &[[0.9, 0.0, 0.4, 0.5]]);
        let corrected = Component::balanced(plain.clone(), energy.clone());
        for theta in [62.0, 70.0, 80.0] {
            let wi = from_degrees(theta, 0.0);
            let f = |at: Distribution<'_>| at.eval(from_degrees(20.0, 130.0));
            let factor = f(corrected.at(wi)) / f(plain.at(wi));
            // None is needed at measured incidences.
            let past = energy.logarithm(wi) - energy.logarithm(from_degrees(60.0, 0.0));
            let wanted = Energy::factor(past);
            assert!((factor / wanted - 1.0).abs() < 1e-3, "{theta}: {factor} {wanted}");
        }
    }

    #[test]
    fn nothing_grows_or_falls_more_than_tenfold() {
        assert!((change(3.0, 2.0, 1e-6) - 1.5).abs() < 1e-6);
        assert_eq!((change(1.0, 0.0, 1e-6), change(0.0, 1.0, 1e-6)), (MOST, 1.0 / MOST));
        assert_eq!(change(0.0, 0.0, 1e-6), 1.0);
    }
}
