//! Do samples of matrices follow their density? χ² over quarters of patches, furnace, integral.
//!
//! Seeds are fixed. Each χ² is at the level 1 − 0.99^(1/n) for n tests (Šidák), so that all pass
//! together with 99 % when they should.

#[allow(dead_code, reason = "trees are for others")]
mod support;

use std::f64::consts::PI;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix, Ring};
use bsdfkit::{Bsdf, Component, Components, DVec2, DVec3, Lambertian, Metadata, Side, Xyz};
use bsdfkit_sphere::direction::{from_degrees, to_degrees};
use support::Random;

fn custom() -> KlemsBasis {
    let rings = [(15.0, 2), (50.0, 9), (72.0, 5), (90.0, 4)];
    let rings = rings.map(|(upper_degrees, patches)| Ring { upper_degrees, patches });
    KlemsBasis::new("custom", rings.into()).unwrap()
}

/// A third of the values 0, the others over a factor of 100, `floor` added to all.
fn matrix(incident: &KlemsBasis, scattered: &KlemsBasis, floor: f32, seed: u64) -> KlemsMatrix {
    let random = &mut Random(seed);
    let n = incident.directions() * scattered.directions();
    let value = |random: &mut Random| {
        let u = random.unit();
        floor + if u < 0.33 { 0.0 } else { u.powi(8) as f32 }
    };
    let values = (0..n).map(|_| value(random)).collect();
    KlemsMatrix::new(incident.clone(), scattered.clone(), values).unwrap()
}

struct Case {
    name: &'static str,
    bsdf: Bsdf,
    /// The basis of the directions sampled, for light from the front.
    basis: KlemsBasis,
    scattered: Side,
    /// Whether the direction sampled is a stored incident one.
    reverse: bool,
}

fn cases() -> Vec<Case> {
    use Side::{Back, Front};
    let [full, half, quarter] = [KlemsBasis::full(), KlemsBasis::half(), KlemsBasis::quarter()];
    let of = |sides: (Side, Side), m: KlemsMatrix| {
        let component = Component::new(sides.0, sides.1, m);
        Bsdf::new(Metadata::default(), vec![component], Lambertian::default())
    };
    let case =
        |name, sides: (Side, Side), incident: &KlemsBasis, scattered: &KlemsBasis, floor, seed| {
            Case {
                name,
                bsdf: of(sides, matrix(incident, scattered, floor, seed)),
                basis: if sides.0 == Front { scattered.clone() } else { incident.clone() },
                scattered: if sides.0 == Front { sides.1 } else { sides.0 },
                reverse: sides.0 == Back,
            }
        };
    vec![
        case("full", (Front, Front), &full, &full, 0.0, 1),
        case("full with floor", (Front, Back), &full, &full, 0.1, 2),
        case("half", (Front, Front), &half, &half, 0.0, 3),
        case("old half", (Front, Front), &KlemsBasis::half_73(), &KlemsBasis::half_73(), 0.0, 4),
        case("quarter", (Front, Back), &quarter, &quarter, 0.02, 5),
        case("custom", (Front, Front), &custom(), &custom(), 0.0, 6),
        case("mixed", (Front, Front), &quarter, &custom(), 0.0, 7),
        case("lone transmission in reverse", (Back, Front), &custom(), &full, 0.02, 8),
    ]
}

const INCIDENCES: [(f64, f64); 4] = [(0.0, 0.0), (33.0, 70.0), (71.0, 201.0), (89.0, 300.0)];

/// Patch and quarter of it (halves in cos²θ and in φ) of a direction, by trigonometry alone.
fn bin(case: &Case, w: DVec3) -> usize {
    let (mut theta, mut phi) = to_degrees(w);
    theta = theta.min(180.0 - theta);
    if case.reverse {
        phi = (phi + 180.0) % 360.0;
    }
    let (mut first, mut lower) = (0, 0.0);
    for ring in case.basis.rings() {
        if theta < ring.upper_degrees {
            let turn = phi * ring.patches as f64 / 360.0 + 0.5;
            let patch = first + turn as usize % ring.patches;
            let [c, c0, c1] =
                [theta, lower, ring.upper_degrees].map(|t: f64| t.to_radians().cos().powi(2));
            return 4 * patch
                + 2 * usize::from(c < 0.5 * (c0 + c1))
                + usize::from(turn.fract() >= 0.5);
        }
        first += ring.patches;
        lower = ring.upper_degrees;
    }
    unreachable!("all bases end at 90°")
}

/// A direction in the middle of patch `k`, away from the surface.
fn inside(case: &Case, k: usize) -> DVec3 {
    let w = case.basis.direction_in(k, DVec2::splat(0.5));
    let w = if case.reverse { DVec3::new(-w.x, -w.y, w.z) } else { w };
    DVec3::new(w.x, w.y, w.z * case.scattered.sign())
}

/// ∫ pdf over each patch.
fn masses(case: &Case, wi: DVec3) -> Vec<f64> {
    (0..case.basis.directions())
        .map(|k| {
            let wo = inside(case, k);
            case.bsdf.pdf(wi, wo, Components::ALL) / wo.z.abs()
                * case.basis.projected_solid_angle(k)
        })
        .collect()
}

#[test]
fn pdf_integrates_to_one() {
    for case in cases() {
        for (theta, phi) in INCIDENCES {
            let sum: f64 = masses(&case, from_degrees(theta, phi)).iter().sum();
            assert!((sum - 1.0).abs() < 1e-9, "{}: ∫ pdf = {sum}", case.name);
        }
    }
}

#[test]
fn samples_follow_the_density() {
    let draws = 100_000;
    let cases = cases();
    let level = 1.0 - 0.99_f64.powf(1.0 / (2 * cases.len() * INCIDENCES.len()) as f64);
    for (seed, case) in cases.iter().enumerate() {
        let random = &mut Random(100 + seed as u64);
        for ((theta, phi), two) in INCIDENCES.into_iter().flat_map(|i| [(i, false), (i, true)]) {
            let wi = from_degrees(theta, phi);
            let mut observed = vec![0.0; 4 * case.basis.directions()];
            for _ in 0..draws {
                let sample = if two {
                    let u = DVec2::new(random.unit(), random.unit());
                    case.bsdf.sample2(wi, u, Components::ALL)
                } else {
                    case.bsdf.sample(wi, random.unit(), Components::ALL)
                };
                let sample = sample.unwrap();
                assert_eq!(Side::of(sample.wo), case.scattered, "{}", case.name);
                observed[bin(case, sample.wo)] += 1.0;
            }
            let expected = masses(case, wi);
            let (mut chi, mut bins, mut rare) = (0.0, 0.0, (0.0, 0.0));
            for (k, o) in observed.iter().enumerate() {
                let e = expected[k / 4] / 4.0 * f64::from(draws);
                if e >= 5.0 {
                    chi += (o - e) * (o - e) / e;
                    bins += 1.0;
                } else {
                    rare = (rare.0 + o, rare.1 + e);
                }
            }
            assert!(rare.0 <= rare.1 + 5.0 * rare.1.sqrt(), "{}: {rare:?}", case.name);
            let p = chi_squared_tail(chi, bins - 1.0);
            assert!(p > level, "{} at {theta}°: χ² = {chi} over {bins} bins, p = {p}", case.name);
        }
    }
}

/// Upper tail of χ² with k degrees of freedom. [Wilson & Hilferty 1931], [Abramowitz & Stegun 26.2.17]
fn chi_squared_tail(x: f64, k: f64) -> f64 {
    let v = 2.0 / (9.0 * k);
    let z = ((x / k).cbrt() - (1.0 - v)) / v.sqrt();
    let t = 1.0 / (1.0 + 0.231_641_9 * z.abs());
    let coefficients =
        [1.330_274_429, -1.821_255_978, 1.781_477_937, -0.356_563_782, 0.319_381_530];
    let polynomial = coefficients.iter().fold(0.0, |sum, c| (sum + c) * t);
    let tail = (-0.5 * z * z).exp() / (2.0 * PI).sqrt() * polynomial;
    if z >= 0.0 { tail } else { 1.0 - tail }
}

/// A surface that loses nothing stays so: every weight is 1.
#[test]
fn furnace() {
    for basis in [KlemsBasis::full(), KlemsBasis::half(), KlemsBasis::quarter(), custom()] {
        let n = basis.directions();
        let random = &mut Random(9);
        let mut values: Vec<f32> = (0..n * n).map(|_| random.unit().powi(4) as f32).collect();
        for row in values.chunks_exact_mut(n) {
            let omega = |k: usize| basis.projected_solid_angle(k);
            let total: f64 = row.iter().enumerate().map(|(k, &f)| f64::from(f) * omega(k)).sum();
            row.iter_mut().for_each(|f| *f = (f64::from(*f) / total) as f32);
        }
        let matrix = KlemsMatrix::new(basis.clone(), basis, values).unwrap();
        let component = Component::new(Side::Front, Side::Front, matrix);
        let bsdf = Bsdf::new(Metadata::default(), vec![component], Lambertian::default());
        for _ in 0..2000 {
            let wi = random.direction(Side::Front);
            let sample = bsdf.sample(wi, random.unit(), Components::ALL).unwrap();
            assert!((sample.weight - 1.0).abs() < 1e-6, "{}", sample.weight);
            let estimate = bsdf.eval(wi, sample.wo) * sample.wo.z.abs() / sample.pdf;
            assert!((estimate - sample.weight).abs() < 1e-9);
        }
    }
}

/// Light through a lone transmission component is the same both ways.
#[test]
fn lone_transmission_is_reciprocal() {
    let m = matrix(&KlemsBasis::full(), &custom(), 0.02, 10);
    let component = Component::new(Side::Back, Side::Front, m);
    let bsdf = Bsdf::new(Metadata::default(), vec![component], Lambertian::default());
    let random = &mut Random(11);
    let mut nonzero = 0;
    for _ in 0..1000 {
        let (front, back) = (random.direction(Side::Front), random.direction(Side::Back));
        let value: Xyz = bsdf.eval_xyz(front, back);
        assert_eq!(value, bsdf.eval_xyz(back, front));
        nonzero += usize::from(value.y > 0.1);
    }
    assert!(nonzero > 100, "{nonzero}");
}
