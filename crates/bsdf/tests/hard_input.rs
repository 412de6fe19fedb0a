//! Directions and numbers that are wrong or at the edge: NaN gives NaN, nothing panics.

#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use std::f64::consts::{FRAC_1_PI, PI};

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::tree::{Rank, TreeDistribution};
use bsdfkit::{Bsdf, Component, Components, DVec3, Lambertian, Metadata, Part, Side, Xyz};
use bsdfkit_sphere::direction::from_degrees;
use support::{Random, random_tree};

fn bsdfs() -> Vec<Bsdf> {
    let of = |c| Bsdf::new(Metadata::default(), vec![c], Lambertian::default());
    let tree = |rank| TreeDistribution::new(random_tree(rank, 3, 0.01, &mut Random(8)));
    let quarter = KlemsBasis::quarter();
    let values = (0..41 * 41).map(|i| (i % 7) as f32 * 0.1).collect();
    let matrix = KlemsMatrix::new(quarter.clone(), quarter, values).unwrap();
    vec![
        of(Component::new(Side::Front, Side::Front, tree(Rank::Four))),
        of(Component::new(Side::Back, Side::Front, tree(Rank::Four))),
        of(Component::new(Side::Front, Side::Front, tree(Rank::Three))),
        of(Component::new(Side::Back, Side::Front, tree(Rank::Three))),
        of(Component::new(Side::Back, Side::Front, matrix)),
        Bsdf::new(Metadata::default(), vec![], Lambertian::default()),
    ]
}

const HARD: [f64; 9] = [0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, f64::NAN, f64::INFINITY, -0.5];

#[test]
fn nothing_panics_and_nan_gives_nan() {
    for bsdf in bsdfs() {
        for x in HARD {
            for y in HARD {
                for z in HARD {
                    let w = DVec3::new(x, y, z);
                    let up = DVec3::new(0.6, 0.0, 0.8);
                    for (wi, wo) in [(w, up), (up, w), (w, w), (w, -w)] {
                        let f = bsdf.eval(wi, wo);
                        let pdf = bsdf.pdf(wi, wo, Components::ALL);
                        let total = bsdf.directional_hemispherical(wi, Components::ALL);
                        bsdf.projected_solid_angle(wi, Some(wo));
                        let (low, high) = bsdf.projected_solid_angle(wi, None);
                        let sample = bsdf.sample(wi, x, Components::ALL);
                        let nan = wi.is_nan() || wo.is_nan();
                        assert!(!nan || f.is_nan() && pdf.is_nan(), "{wi} {wo}: {f} {pdf}");
                        if wi.is_nan() {
                            assert!(total.is_nan() && low.is_nan() && high.is_nan());
                            assert!(sample.is_none());
                        }
                        if let Some(s) = sample {
                            assert!(s.wo.is_finite() && s.pdf >= 0.0, "{wi}: {s:?}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn grazing_and_axial_directions_have_data() {
    for bsdf in &bsdfs()[..4] {
        for phi in 0..24 {
            // z = 0 counts as back; the smallest positive z as front.
            let edge = from_degrees(90.0, 15.0 * f64::from(phi));
            let wi = DVec3::new(edge.x, edge.y, f64::MIN_POSITIVE);
            let total = bsdf.directional_hemispherical(wi, Components::ALL);
            assert!(total > 0.0, "{wi}: {total}");
            let s = bsdf.sample(wi, 0.4, Components::ALL).unwrap();
            assert!(s.pdf > 0.0 && bsdf.eval(wi, s.wo) > 0.0);
        }
    }
}

#[test]
fn the_wrong_side_is_black() {
    let bsdf = &bsdfs()[0];
    let (front, back) = (from_degrees(20.0, 0.0), from_degrees(160.0, 0.0));
    assert!(bsdf.eval(front, front) > 0.0);
    assert_eq!(bsdf.eval(front, back), 0.0);
    assert_eq!(bsdf.eval(back, back), 0.0);
    assert_eq!(bsdf.pdf(back, back, Components::ALL), 0.0);
    assert!(bsdf.sample(back, 0.5, Components::ALL).is_none());
    assert_eq!(bsdf.projected_solid_angle(back, None), (PI, PI));
}

/// The intervals of u: Lambertian reflection, Lambertian transmission, then the others.
#[test]
fn u_visits_the_parts_in_order() {
    let tree = TreeDistribution::new(random_tree(Rank::Four, 3, 0.0, &mut Random(8)));
    let explicit = Lambertian {
        reflection_front: Xyz::grey(0.25),
        transmission_front: Xyz::grey(0.5),
        ..Lambertian::default()
    };
    let c = Component::new(Side::Front, Side::Front, tree);
    let bsdf = Bsdf::new(Metadata::default(), vec![c], explicit);
    let wi = from_degrees(20.0, 0.0);
    let total = bsdf.directional_hemispherical(wi, Components::ALL);
    let draw = |u: f64| bsdf.sample(wi, u, Components::ALL).unwrap();
    for k in 0..1000 {
        let u = f64::from(k) / 1000.0;
        let expected = match u * total {
            at if at < 0.25 => Part::LambertianReflection,
            at if at < 0.75 => Part::LambertianTransmission,
            _ => Part::Component(0),
        };
        assert_eq!(draw(u).part, expected, "{u}");
    }
    // A Lambertian part alone: cosine-distributed.
    let s = bsdf.sample(wi, 0.9, Components::LAMBERTIAN & Components::REFLECTION).unwrap();
    assert!((s.pdf - s.wo.z * FRAC_1_PI).abs() < 1e-15 && s.weight == 0.25);
}
