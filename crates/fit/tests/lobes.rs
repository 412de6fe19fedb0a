//! The fit of one incidence: noise, uneven sampling, holes, and points of every unhappy kind.

mod support;

use std::f64::consts::PI;

use bsdfkit::{DVec3, Side};
use bsdfkit_fit::interpolant::{Component, Frame};
use bsdfkit_measure::{Incidence, Symmetry};
use bsdfkit_simulate::material::Fabric;
use bsdfkit_simulate::{Goniophotometer, Material, six};
use bsdfkit_sphere::direction::from_degrees;
use support::{
    coarse, distance_from_points, distance_from_truth, fit, given, hemisphere, incidence,
    instrument, measured, measurement,
};

fn frame(material: &dyn Material) -> Frame {
    if material.scattered() == Side::Front { Frame::Half } else { Frame::Turned }
}

fn single(i: Incidence) -> Component {
    fit(&measurement(Side::Front, Symmetry::None, vec![i]), &given(Frame::Half))
}

/// Where a goniophotometer looks, sweeps and spirals.
fn scan() -> Vec<DVec3> {
    coarse().scan(&Fabric::default(), 30.0, 0.0).wo
}

#[test]
fn noise_is_averaged_not_followed() {
    let noisy = Goniophotometer { relative_noise: 0.02, ..instrument() };
    for material in six() {
        let material = material.as_ref();
        for (theta, phi) in [(0.0, 0.0), (30.0, 0.0), (50.0, 40.0)] {
            let angles = [(theta, phi)];
            let m = measured(&noisy, material, Symmetry::None, &angles);
            let wi = m.incidences[0].wi;
            let distance =
                distance_from_truth(&fit(&m, &given(frame(material))).at(wi), material, wi);
            assert!(distance <= 0.02, "{} {angles:?}: {distance}", material.name());
        }
    }
}

/// 20,000 points in 6 degrees beside 3000 over the hemisphere.
#[test]
fn a_dense_spiral_does_not_pull_the_hemispherical_value() {
    let fabric = Fabric::default();
    let wi = from_degrees(40.0, 0.0);
    let value = |wo: Vec<DVec3>| {
        single(incidence(wi, wo, |w| fabric.eval(wi, w))).at(wi).directional_hemispherical()
    };
    let without = value(scan());
    assert!((without / fabric.albedo(wi) - 1.0).abs() < 2e-3, "{without}");
    for (theta, phi) in [(10.0, 100.0), (60.0, 180.0), (40.0, 180.0)] {
        let centre = from_degrees(theta, phi);
        let (x, y) = centre.any_orthonormal_pair();
        let point = |k: i32| {
            let t = (f64::from(k) / 20_000.0).sqrt();
            let (sin, cos) = (200.0 * t).sin_cos();
            (centre + 0.1 * t * (cos * x + sin * y)).normalize()
        };
        let with = value(scan().into_iter().chain((0..20_000).map(point)).collect());
        assert!((with / without - 1.0).abs() < 5e-3, "{theta} {phi}: {with} {without}");
    }
}

#[test]
fn the_hole_around_the_light_is_filled_as_its_surroundings_ask() {
    for material in six().iter().filter(|m| m.scattered() == Side::Front) {
        let material = material.as_ref();
        for theta in [10.0, 30.0, 50.0] {
            let m = measured(&instrument(), material, Symmetry::None, &[(theta, 0.0)]);
            let wi = m.incidences[0].wi;
            let c = fit(&m, &given(Frame::Half));
            let (x, y) = wi.any_orthonormal_pair();
            for k in 0..24 {
                let (sin, cos) = (f64::from(k % 8) * PI / 4.0).sin_cos();
                let aside = (f64::from(k / 8) * 1.9).to_radians().tan();
                let wo = (wi + aside * (cos * x + sin * y)).normalize();
                let (f, truth) = (c.at(wi).eval(wo), material.eval(wi, wo));
                assert!((f / truth - 1.0).abs() < 0.2, "{} {theta}: {f} {truth}", material.name());
            }
        }
    }
}

#[test]
fn a_constant_is_a_constant() {
    let wi = from_degrees(30.0, 0.0);
    for value in [0.3, 1e-4, 1e6] {
        let c = single(incidence(wi, scan(), |_| value));
        let distribution = c.at(wi);
        for wo in hemisphere(20, Side::Front, 90.0) {
            let f = distribution.eval(wo);
            assert!((f / value - 1.0).abs() < 1e-3, "{value} {wo}: {f}");
        }
        assert!((distribution.directional_hemispherical() / (PI * value) - 1.0).abs() < 1e-3);
    }
}

#[test]
fn darkness_is_dark() {
    let wi = from_degrees(30.0, 0.0);
    let zero: fn(DVec3) -> f64 = |_| 0.0;
    let negative: fn(DVec3) -> f64 = |_| -0.1;
    for f in [zero, negative] {
        let c = single(incidence(wi, scan(), f));
        assert!(hemisphere(20, Side::Front, 90.0).iter().all(|&w| c.at(wi).eval(w) <= 1e-9));
    }
}

/// Noise about zero may be negative: the fit is not, and keeps the mean.
#[test]
fn negative_noise_averages_out() {
    let (fabric, wi) = (Fabric::default(), from_degrees(30.0, 0.0));
    let wave = |w: DVec3| 0.05 * (12_345.6 * w.x + 777.7 * w.y).sin();
    let c = single(incidence(wi, scan(), |w| fabric.eval(wi, w) + wave(w)));
    let distribution = c.at(wi);
    assert!(hemisphere(40, Side::Front, 90.0).iter().all(|&w| distribution.eval(w) >= 0.0));
    let (ours, truth) = (distribution.directional_hemispherical(), fabric.albedo(wi));
    assert!((ours / truth - 1.0).abs() < 0.05, "{ours} {truth}");
}

/// One wild value is a peak as far as anyone can tell: it must not reach beyond its surroundings.
#[test]
fn an_outlier_stays_where_it_is() {
    let (fabric, wi) = (Fabric::default(), from_degrees(30.0, 0.0));
    let spike = from_degrees(60.0, 90.0);
    let mut i = incidence(wi, scan(), |w| fabric.eval(wi, w));
    let nearest = (0..i.wo.len())
        .min_by(|&a, &b| i.wo.at(a).distance(spike).total_cmp(&i.wo.at(b).distance(spike)))
        .expect("points");
    i.values[nearest] = 100.0;
    let c = single(i);
    let distribution = c.at(wi);
    let (mut error, mut total) = (0.0, 0.0);
    for wo in hemisphere(60, Side::Front, 80.0) {
        if wo.angle_between(spike) > 0.35 {
            let truth = fabric.eval(wi, wo);
            error += (distribution.eval(wo) - truth).abs();
            total += truth;
        }
    }
    assert!(error / total < 0.05, "{}", error / total);
}

#[test]
fn few_points_and_part_of_the_hemisphere_are_reproduced() {
    let (fabric, wi) = (Fabric::default(), from_degrees(30.0, 0.0));
    let quarter = scan().into_iter().filter(|w| w.x < 0.0 && w.y > 0.0).collect();
    let ten = scan().into_iter().step_by(300).take(10).collect();
    let line = (0..170).map(|k| from_degrees(f64::from(k) - 85.0, 0.0)).collect();
    let one = vec![from_degrees(30.0, 180.0)];
    let same = vec![from_degrees(30.0, 180.0); 100];
    let sets: [(&str, Vec<DVec3>); 5] =
        [("quarter", quarter), ("ten", ten), ("line", line), ("one", one), ("same", same)];
    for (name, wo) in sets {
        let i = incidence(wi, wo, |w| fabric.eval(wi, w));
        let most = i.channel(0).fold(0.0, f64::max);
        let c = single(i.clone());
        let distance = distance_from_points(&c.at(wi), &i);
        assert!(distance < 0.02, "{name}: {distance}");
        // What nothing was measured of is bounded by what was, give or take a peak beside it.
        for wo in hemisphere(40, Side::Front, 90.0) {
            let f = c.at(wi).eval(wo);
            assert!((0.0..=5.0 * most).contains(&f), "{name} {wo}: {f}, measured {most}");
        }
    }
    let none = single(incidence(wi, Vec::new(), |_| 1.0));
    assert!(hemisphere(20, Side::Front, 90.0).iter().all(|&w| none.at(wi).eval(w) < 1e-6));
}
