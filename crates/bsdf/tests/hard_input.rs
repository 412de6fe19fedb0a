//! Directions and numbers that are wrong or at the edge: NaN gives NaN, nothing panics.

#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use std::f64::consts::{FRAC_1_PI, PI};

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::tree::{Rank, TreeDistribution};
use bsdfkit::{
    Bsdf, Component, Components, DVec2, DVec3, Lambertian, Lookup, Metadata, Part, Side, Xyz,
};
use bsdfkit_sphere::concentric::square_to_hemisphere;
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

/// Trees of either rank and lookup, and a matrix of each kind of basis: as stored and in reverse.
fn stored_and_reversed() -> Vec<(String, Bsdf)> {
    let mut all = Vec::new();
    for (way, incident) in [("forward", Side::Front), ("reverse", Side::Back)] {
        let of = |c| Bsdf::new(Metadata::default(), vec![c], Lambertian::default());
        for rank in [Rank::Three, Rank::Four] {
            let tree = TreeDistribution::new(random_tree(rank, 4, 0.01, &mut Random(18)));
            let stored = of(Component::new(incident, Side::Front, tree));
            let smooth = stored.clone().with_lookup(Lookup::Smooth).unwrap();
            all.push((format!("{rank:?}, {way}"), stored));
            all.push((format!("{rank:?}, {way}, smooth"), smooth));
        }
        for basis in [KlemsBasis::full(), KlemsBasis::half_73(), KlemsBasis::quarter()] {
            let random = &mut Random(19);
            let n = basis.directions();
            let values = (0..n * n).map(|_| 0.01 + random.unit() as f32).collect();
            let matrix = KlemsMatrix::new(basis.clone(), basis.clone(), values).unwrap();
            let component = Component::new(incident, Side::Front, matrix);
            all.push((format!("{}, {way}", basis.name()), of(component)));
        }
    }
    all
}

/// Directions just inside one that is exactly axial or grazing, on either side of every border that meets there.
fn just_inside(theta: f64, phi: f64, side: Side) -> Vec<DVec3> {
    let turned = |theta: f64, phi: f64| {
        let w = from_degrees(theta, phi);
        DVec3::new(w.x, w.y, side.sign() * w.z)
    };
    const TURNS: [f64; 2] = [-1e-5, 1e-5];
    match theta {
        0.0 => {
            (0..32).map(|k| turned(1e-5, 22.5 * f64::from(k / 2) + TURNS[k as usize % 2])).collect()
        }
        _ => TURNS.map(|turn| turned(theta - 1e-3, phi + turn)).into(),
    }
}

/// The direction itself: axial to the last bit, or in the surface as far as its side allows.
fn exactly(theta: f64, phi: f64, side: Side) -> DVec3 {
    let w = from_degrees(theta, phi);
    match (theta, side) {
        (0.0, _) => DVec3::Z * side.sign(),
        // z = 0 counts as back.
        (_, Side::Back) => DVec3::new(w.x, w.y, 0.0),
        (_, Side::Front) => DVec3::new(w.x, w.y, f64::MIN_POSITIVE),
    }
}

/// ∫ f |cos| dω by 256 × 256 points of equal projected solid angle.
fn integral(bsdf: &Bsdf, wi: DVec3, side: Side) -> f64 {
    let at = |n: usize| (n as f64 + 0.5) / 256.0;
    let points = (0..1 << 16).map(|n| DVec2::new(at(n % 256), at(n / 256)));
    let sum: f64 = points.map(|s| bsdf.eval(wi, square_to_hemisphere(s, side))).sum();
    sum * PI / f64::from(1 << 16)
}

/// Whether `found` is one of the values just inside, to 1e-4: smooth lookup varies by some 1e-5 so far away.
fn is_among(found: f64, inside: impl IntoIterator<Item = f64>) -> bool {
    inside.into_iter().any(|value| (found - value).abs() <= 1e-4 * value.abs())
}

#[test]
fn grazing_and_axial_directions_answer_as_those_just_inside() {
    let edges = (0..24).map(|k| (90.0, 15.0 * f64::from(k))).chain([(0.0, 0.0)]);
    let edges: Vec<(f64, f64)> = edges.collect();
    for (name, bsdf) in stored_and_reversed() {
        let scattered =
            if bsdf.components()[0].incident == Side::Front { Side::Front } else { Side::Back };
        for &(theta, phi) in &edges {
            let wi = exactly(theta, phi, Side::Front);
            let inside = just_inside(theta, phi, Side::Front);
            let all = Components::ALL;
            let total = bsdf.directional_hemispherical(wi, all);
            let totals = inside.iter().map(|wi| bsdf.directional_hemispherical(*wi, all));
            let totals: Vec<f64> = totals.collect();
            // What is exactly axial lies in one cell of the four around it. To an isotropic tree in reverse
            // that is one of four azimuths, all of which any other direction has.
            let one_of_four = theta == 0.0 && name.starts_with("Three, reverse");
            if one_of_four {
                let integral = integral(&bsdf, wi, scattered);
                assert!((integral / total - 1.0).abs() < 0.01, "{name}: {integral} {total}");
                continue;
            }
            let found = total > 0.0 && is_among(total, totals.iter().copied());
            assert!(found, "{name}, {wi:.2}: total {total}, inside {totals:?}");
            for &(theta, phi) in &edges {
                let wo = exactly(theta, phi, scattered);
                let f = bsdf.eval(wi, wo);
                let outs = just_inside(theta, phi, scattered);
                let values = inside.iter().flat_map(|wi| outs.iter().map(|wo| bsdf.eval(*wi, *wo)));
                let values: Vec<f64> = values.collect();
                assert!(
                    f > 0.0 && is_among(f, values.iter().copied()),
                    "{name}, {wi:.2} {wo:.2}: f {f}, inside {values:?}"
                );
            }
            for k in 0..20 {
                let u = (f64::from(k) + 0.5) / 20.0;
                let s = bsdf.sample(wi, u, all).expect(&name);
                assert_eq!((s.weight, Side::of(s.wo)), (total, scattered), "{name}, {wi}");
                let found = bsdf.eval(wi, s.wo) * s.wo.z.abs() / total;
                assert!(s.pdf > 0.0 && (s.pdf / found - 1.0).abs() < 1e-9, "{name}, {wi}");
                // Along a curve, a place moves with the root of what moves it.
                let near = inside.iter().filter_map(|wi| bsdf.sample(*wi, u, all));
                let away = near.map(|near| near.wo.truncate().distance(s.wo.truncate()));
                let away = away.fold(f64::INFINITY, f64::min);
                assert!(away < 2e-2, "{name}, {wi}: {} is {away} from those drawn inside", s.wo);
            }
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
