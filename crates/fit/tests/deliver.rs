//! A file for a program: what is written beside what was measured.

mod support;

use bsdfkit::tree::{Rank, TreeBuilder, TreeDistribution};
use bsdfkit::{Bsdf, Component, Components, DVec2, DVec3, Lambertian, Metadata, Side};
use bsdfkit_fit::deliver::{Consumer, Delivered, Kind, Order, Subject};
use bsdfkit_fit::interpolant::{FitSettings, Interpolant};
use bsdfkit_measure::{Incidence, Measurement, Symmetry};
use bsdfkit_represent::Watch;
use bsdfkit_sphere::direction::from_degrees;
use support::measurement;

/// Of each incidence the peak, as a share of the direction cosines of light that goes straight on; and its width there.
const BENT: f64 = 0.6;
const WIDTH: f64 = 0.08;

fn value(wi: DVec3, wo: DVec3) -> f64 {
    let off = wo.truncate() + BENT * wi.truncate();
    0.02 + 4.0 * (-off.length_squared() / (2.0 * WIDTH * WIDTH)).exp()
}

/// Light from one side to another, at six polar angles.
fn scan((from, to): (Side, Side)) -> Measurement {
    let sign = |side| if side == Side::Front { 1.0 } else { -1.0 };
    let wo: Vec<DVec3> = spiral(3000).map(|d| d.extend(sign(to) * height(d))).collect();
    let of = |theta| {
        let up = from_degrees(theta, 0.0);
        let wi = DVec3::new(up.x, up.y, sign(from) * up.z);
        Incidence::new(wi, wo.clone(), wo.iter().map(|&wo| value(wi, wo)))
    };
    let incidences = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0].map(of).into();
    Measurement { incident: from, ..measurement(to, Symmetry::Isotropic, incidences) }
}

/// Points of the unit disk, evenly.
fn spiral(count: u32) -> impl Iterator<Item = DVec2> {
    (0..count).map(move |k| {
        let k = f64::from(k);
        DVec2::from_angle(k * 2.399_963) * ((k + 0.5) / f64::from(count)).sqrt()
    })
}

fn height(d: DVec2) -> f64 {
    (1.0 - d.length_squared()).sqrt()
}

fn fitted(m: &[Measurement]) -> Interpolant {
    Interpolant::fit(m, &FitSettings::default(), &Watch::default()).unwrap()
}

fn for_radiance(subject: Subject<'_>) -> Delivered {
    let order = Order { consumer: Some(Consumer::Radiance), ..Order::new(Kind::TensorTree) };
    order.deliver(subject, Metadata::default(), &Watch::default()).unwrap()
}

fn sides(bsdf: &Bsdf) -> Vec<(Side, Side)> {
    let mut all: Vec<_> = bsdf.components().iter().map(|c| (c.incident, c.scattered)).collect();
    all.sort_by_key(|&(i, s)| (i == Side::Back, s == Side::Back));
    all
}

const BOTH_WAYS: [(Side, Side); 2] = [(Side::Front, Side::Back), (Side::Back, Side::Front)];

/// Radiance samples one way of a lone isotropic tree alone, so the other is written; it is the same material.
#[test]
fn of_an_isotropic_transmission_radiance_gets_both_ways() {
    let glass = fitted(&[scan(BOTH_WAYS[0])]);
    let truth = glass.bsdf();
    let tree = for_radiance(Subject::Continuous(&glass));
    let order = Order::new(Kind::TensorTree);
    let alone = order.deliver(Subject::Continuous(&glass), Metadata::default(), &Watch::default());
    let stored = alone.unwrap().bsdf;
    assert_eq!(sides(&stored), BOTH_WAYS[..1]);
    let again = for_radiance(Subject::Stored(&stored));
    for made in [&tree, &again] {
        assert_eq!(sides(&made.bsdf), BOTH_WAYS);
        assert_eq!(
            made.said.iter().filter(|s| s.contains("the other direction reversed")).count(),
            1
        );
        let trees = made.bsdf.components().iter();
        assert!(
            trees.clone().all(|c| c.distribution().downcast_ref::<TreeDistribution>().is_some())
        );
        // Beyond 36 degrees nothing but the flank of the peak comes back.
        for theta in [3.0, 12.0, 22.0, 31.0] {
            for side in [0.0, 180.0] {
                let wi = from_degrees(f64::abs(side - theta), 25.0);
                let [found, expected] = [&made.bsdf, &truth]
                    .map(|b| b.directional_hemispherical(wi, Components::TRANSMISSION));
                assert!(
                    (found / expected - 1.0).abs() < 0.03,
                    "{theta}, {side}: {found} {expected}"
                );
                let (mut off, mut all) = (0.0, 0.0);
                for d in spiral(4000) {
                    let wo = d.extend(-wi.z.signum() * height(d));
                    let (a, b) = (made.bsdf.eval(wi, wo), truth.eval(wi, wo));
                    (off, all) = (off + (a - b).abs(), all + b);
                }
                assert!(off < 0.12 * all, "{theta}, {side}: L1 {}", off / all);
            }
        }
    }
}

/// What answers both ways by itself stays as it is: two sides, a tree of rank 4, a reflection, and whatever no program asked for.
#[test]
fn nothing_else_is_turned() {
    let both = BOTH_WAYS.map(scan);
    let two = for_radiance(Subject::Continuous(&fitted(&both)));
    assert_eq!(sides(&two.bsdf), BOTH_WAYS);
    assert!(!two.said.iter().any(|s| s.contains("reversed")), "{:?}", two.said);
    let mirror = fitted(&[scan((Side::Front, Side::Front))]);
    assert_eq!(for_radiance(Subject::Continuous(&mirror)).bsdf.components().len(), 1);
    let mut rank_four = TreeBuilder::new(Rank::Four);
    rank_four.grid(1, &(1..=16_u8).map(|v| 0.01 * f32::from(v)).collect::<Vec<_>>()).unwrap();
    let tree = TreeDistribution::new(rank_four.finish().unwrap());
    let component = Component::new(Side::Front, Side::Back, tree);
    let stored = Bsdf::new(Metadata::default(), vec![component], Lambertian::default());
    assert_eq!(sides(&for_radiance(Subject::Stored(&stored)).bsdf), BOTH_WAYS[..1]);
}
