//! Errors that leaving incidences out shows, and what they tell of incidences never measured.

mod support;

use std::sync::atomic::AtomicBool;

use bsdfkit::{DVec3, ErrorClass, Side};
use bsdfkit_fit::interpolant::{Component, Frame};
use bsdfkit_fit::validate::{ErrorModel, Validation};
use bsdfkit_measure::{Incidence, Measurement, Mirror, Symmetry};
use bsdfkit_represent::Watch;
use bsdfkit_simulate::material::{BrushedMetal, Fabric};
use bsdfkit_simulate::{Goniophotometer, Material};
use bsdfkit_sphere::direction::from_degrees;
use support::{coarse, direction, fit, given, grid, hemisphere, instrument, measured};

fn validated(m: &Measurement) -> (Component, Validation) {
    let whole = fit(m, &given(Frame::Half));
    let validation = Validation::of(m, &whole, &Watch::default()).unwrap_or_else(|e| panic!("{e}"));
    (whole, validation)
}

fn quarter(gonio: &Goniophotometer) -> Measurement {
    let angles = grid(&[0.0, 20.0, 40.0, 60.0], &[0.0, 30.0, 60.0, 90.0]);
    measured(gonio, &BrushedMetal::default(), Symmetry::Quadrilateral, &angles)
}

/// A specimen of which every incidence is known from any other.
fn matte() -> Measurement {
    let mut m = quarter(&coarse());
    for i in &mut m.incidences {
        i.values.fill(0.25);
    }
    m
}

#[test]
fn what_all_incidences_agree_on_has_no_error() {
    let (whole, v) = validated(&matte());
    for i in &v.incidences {
        assert!(i.l1 < 2e-3 && i.hemispherical_error.abs() < 2e-3, "{i:?}");
    }
    let expected = ErrorModel::of(&whole, &v).at(from_degrees(30.0, 15.0));
    assert!(expected.l1 < 2e-3 && expected.spread < 5e-3, "{expected:?}");
    assert!((expected.background / 0.025 - 1.0).abs() < 0.01, "{expected:?}");
}

/// One incidence measured with the lamp twice as bright stands out, and its neighbours less.
#[test]
fn an_incidence_that_contradicts_its_neighbours_stands_out() {
    let mut m = matte();
    let odd = m.incidences.iter().position(|i| i.wi.distance(from_degrees(40.0, 30.0)) < 1e-9);
    let odd = odd.expect("measured");
    m.incidences[odd].values.fill(0.5);
    let (_, v) = validated(&m);
    let found = &v.incidences[odd];
    assert!((found.l1 - 0.5).abs() < 0.03, "{found:?}");
    assert!((found.hemispherical_error + 0.5).abs() < 0.03, "{found:?}");
    for (k, i) in v.incidences.iter().enumerate().filter(|&(k, _)| k != odd) {
        let wi = m.incidences[odd].wi;
        let near = i.wi.angle_between(wi) < 0.6 || i.extrapolated;
        assert!(if near { i.l1 < 1.2 } else { i.l1 < 0.05 }, "{k}: {i:?}");
    }
}

/// A specimen that was turned by 6 degrees between two incidences.
#[test]
fn a_displaced_peak_is_off_by_as_much() {
    let gonio = Goniophotometer { spiral_points: 3000, ..instrument() };
    let mut m = quarter(&gonio);
    let turned = m.incidences.iter().position(|i| i.wi.distance(from_degrees(40.0, 60.0)) < 1e-9);
    let turned = turned.expect("measured");
    let before = validated(&m).1.incidences[turned].peaks[0];
    assert!(before.offset_degrees < 0.5 && (before.height_ratio - 1.0).abs() < 0.1, "{before:?}");
    let (sin, cos) = 6f64.to_radians().sin_cos();
    let turn = |w: DVec3| DVec3::new(cos * w.x - sin * w.y, sin * w.x + cos * w.y, w.z);
    m.incidences[turned].wo.change(turn);
    let after = &validated(&m).1.incidences[turned];
    let moved = from_degrees(40.0, 240.0).angle_between(from_degrees(40.0, 246.0)).to_degrees();
    assert!((after.peaks[0].offset_degrees - moved).abs() < 0.7, "{moved}: {after:?}");
    assert!(after.l1 > 0.2, "{after:?}");
}

#[test]
fn the_rim_is_extrapolated_and_nothing_else() {
    let (_, v) = validated(&quarter(&coarse()));
    for i in &v.incidences {
        assert_eq!(i.extrapolated, i.wi.z < 0.51, "{:?}", i.wi);
    }
    let (inner, rim) = (v.summary(false).expect("some"), v.summary(true).expect("some"));
    assert_eq!((inner.incidences, rim.incidences), (9, 4));
    assert!(inner.l1 < rim.l1 && inner.l1 <= inner.largest_l1, "{inner:?} {rim:?}");
}

#[test]
fn too_few_incidences_and_a_cancelled_run_are_refused() {
    let m = quarter(&coarse());
    let mut few = m.clone();
    few.incidences.truncate(2);
    let whole = fit(&few, &given(Frame::Half));
    let error = Validation::of(&few, &whole, &Watch::default()).expect_err("too few");
    assert_eq!(error.class(), ErrorClass::Argument);
    assert!(error.to_string().contains("at least 3 incidences"), "{error}");
    let cancel = AtomicBool::new(true);
    let watch = Watch { progress: None, cancel: Some(&cancel) };
    let whole = fit(&m, &given(Frame::Half));
    let error = Validation::of(&m, &whole, &watch).expect_err("cancelled");
    assert_eq!(error.class(), ErrorClass::Limit);
}

fn ranks(values: &[f64]) -> Vec<f64> {
    let below = |v: f64| values.iter().filter(|&&w| w < v).count() as f64;
    values.iter().map(|&v| below(v)).collect()
}

/// Spearman's, of values without ties.
fn rank_correlation(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (ranks(a), ranks(b));
    let n = a.len() as f64;
    let square: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum();
    1.0 - 6.0 * square / (n * (n * n - 1.0))
}

/// (expected, true) L1 at incident directions that were not measured, and the share of scattered
/// directions whose interval holds the truth.
fn against_truth(material: &dyn Material, m: &Measurement) -> (Vec<(f64, f64)>, f64) {
    const DIRECTIONS: usize = 30;
    let (whole, validation) = validated(m);
    let model = ErrorModel::of(&whole, &validation);
    let wo = hemisphere(40, Side::Front, 80.0);
    let mut held = 0.0;
    let pairs = (0..DIRECTIONS).map(|k| {
        let wi = direction(k, 60.0);
        let (distribution, at) = (whole.at(wi), model.at(wi));
        let (mut error, mut total) = (0.0, 0.0);
        for &w in &wo {
            let (value, truth) = (distribution.eval(w), material.eval(wi, w));
            error += (value - truth).abs();
            total += truth;
            let (low, high) = at.interval(value);
            let inside = (low..=high).contains(&truth);
            held += f64::from(u8::from(inside)) / (DIRECTIONS * wo.len()) as f64;
        }
        (at.l1, error / total)
    });
    (pairs.collect(), held)
}

#[test]
fn expected_errors_rank_and_bound_the_true_ones() {
    let (metal, fabric) = (BrushedMetal::default(), Fabric::default());
    let half = grid(&[0.0, 20.0, 40.0, 60.0], &[0.0, 36.0, 72.0, 108.0, 144.0, 180.0]);
    let sets: [(&dyn Material, Measurement); 2] = [
        (&metal, quarter(&instrument())),
        (&fabric, measured(&instrument(), &fabric, Symmetry::Bilateral(Mirror::Y), &half)),
    ];
    let mut all = Vec::new();
    for (material, m) in sets {
        let (pairs, held) = against_truth(material, &m);
        let bias = pairs.iter().map(|(e, t)| (e / t).ln()).sum::<f64>() / pairs.len() as f64;
        let name = material.name();
        println!("{name}: mean log ratio {bias:.2}, intervals hold {held:.3}");
        assert!(bias.abs() < 0.6, "{name}: {bias}");
        assert!((0.85..0.98).contains(&held), "{name}: {held}");
        all.extend(pairs);
    }
    let (expected, found): (Vec<f64>, Vec<f64>) = all.into_iter().unzip();
    let correlation = rank_correlation(&expected, &found);
    println!("rank correlation {correlation:.3}");
    assert!(correlation > 0.8, "{correlation}");
}

#[test]
fn errors_are_least_at_measured_incidences_and_alike_in_the_mirror() {
    let (whole, v) = validated(&quarter(&coarse()));
    let model = ErrorModel::of(&whole, &v);
    for i in &v.incidences {
        let here = model.at(i.wi).l1;
        assert!(here <= i.fit_l1 + 1e-9, "{here} {i:?}");
    }
    let middle = from_degrees(50.0, 15.0);
    assert!(model.at(middle).l1 > model.at(from_degrees(59.0, 1.0)).l1);
    for mirrored in [(50.0, 165.0), (50.0, 195.0), (50.0, 345.0)] {
        let other = model.at(from_degrees(mirrored.0, mirrored.1)).l1;
        assert!((other / model.at(middle).l1 - 1.0).abs() < 1e-9);
    }
    assert!(model.at(from_degrees(85.0, 0.0)).l1 > model.at(from_degrees(62.0, 0.0)).l1);
    assert!(model.at(DVec3::NAN).l1.is_nan());
}

/// Light that comes from behind is answered like light from the front.
#[test]
fn the_back_side_is_measured_alike() {
    let mut m = matte();
    let turned = |w: DVec3| DVec3::new(w.x, w.y, -w.z);
    (m.incident, m.scattered) = (Side::Back, Side::Back);
    m.incidences = m
        .incidences
        .iter()
        .map(|i| Incidence { wi: turned(i.wi), wo: i.wo.iter().map(turned).collect(), ..i.clone() })
        .collect();
    let (whole, v) = validated(&m);
    assert!(v.incidences.iter().all(|i| i.wi.z < 0.0 && i.l1 < 2e-3), "{:?}", v.incidences);
    assert!(ErrorModel::of(&whole, &v).at(from_degrees(150.0, 15.0)).l1 < 2e-3);
}
