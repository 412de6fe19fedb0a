//! Do samples of matrices follow their density? χ² over quarters of patches, furnace, integral.
//!
//! Seeds are fixed.

mod chi_squared;
mod stratified;
#[allow(dead_code, reason = "trees are for others")]
mod support;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix, Ring};
use bsdfkit::{Bsdf, Component, Components, DVec2, DVec3, Lambertian, Metadata, Sense, Side, Xyz};
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
    let level = chi_squared::level(2 * cases.len() * INCIDENCES.len());
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
            let each = |k: usize| expected[k / 4] / 4.0 * f64::from(draws);
            let expected: Vec<f64> = (0..observed.len()).map(each).collect();
            let name = format!("{} at {theta}°", case.name);
            chi_squared::expect(&name, &observed, &expected, level);
        }
    }
}

/// As of trees (`statistics.rs`); one number walks patch by patch, ring by ring.
#[test]
fn stratified_numbers_give_stratified_directions() {
    for case in cases() {
        for (theta, phi) in INCIDENCES {
            let wi = from_degrees(theta, phi);
            let one = stratified::one_number(&case.bsdf, wi);
            let two = stratified::two_numbers(&case.bsdf, wi);
            // Twice what was found.
            let figures = format!("{one:.4} and {two:.4} of the variance by random numbers");
            assert!(one < 0.05 && two < 0.25, "{} at {theta}°: {figures}", case.name);
        }
    }
}

/// A surface that loses nothing stays so: every weight is 1. Of each basis, of one for light and another for
/// what it scatters, and of a lone transmission in reverse, where it is columns that sum up to 1.
#[test]
fn furnace() {
    let [full, half, old_half] = [KlemsBasis::full(), KlemsBasis::half(), KlemsBasis::half_73()];
    let [quarter, custom] = [KlemsBasis::quarter(), custom()];
    let pairs = [
        (&full, &full),
        (&half, &half),
        (&old_half, &old_half),
        (&quarter, &quarter),
        (&custom, &custom),
        (&full, &custom),
        (&old_half, &half),
    ];
    for ((known, drawn), sense) in
        pairs.into_iter().flat_map(|p| [(p, Sense::Forward), (p, Sense::Reverse)])
    {
        let random = &mut Random(9);
        let omega: Vec<f64> =
            (0..drawn.directions()).map(|k| drawn.projected_solid_angle(k)).collect();
        let rows: Vec<Vec<f32>> = (0..known.directions())
            .map(|_| {
                let row: Vec<f64> = omega.iter().map(|_| random.unit().powi(4)).collect();
                let total: f64 = row.iter().zip(&omega).map(|(f, omega)| f * omega).sum();
                row.iter().map(|f| (f / total) as f32).collect()
            })
            .collect();
        let (sides, incident, scattered, values) = match sense {
            Sense::Forward => ((Side::Front, Side::Front), known, drawn, rows.concat()),
            Sense::Reverse => {
                let columns = (0..omega.len()).flat_map(|k| rows.iter().map(move |row| row[k]));
                ((Side::Back, Side::Front), drawn, known, columns.collect())
            }
        };
        let matrix = KlemsMatrix::new(incident.clone(), scattered.clone(), values).unwrap();
        let component = Component::new(sides.0, sides.1, matrix);
        let bsdf = Bsdf::new(Metadata::default(), vec![component], Lambertian::default());
        let name = format!("{} to {}, {sense:?}", known.name(), drawn.name());
        for _ in 0..2000 {
            let wi = random.direction(Side::Front);
            let u = DVec2::new(random.unit(), random.unit());
            for sample in
                [bsdf.sample(wi, u.x, Components::ALL), bsdf.sample2(wi, u, Components::ALL)]
            {
                let sample = sample.expect(&name);
                assert!((sample.weight - 1.0).abs() < 1e-6, "{name}: {}", sample.weight);
                let estimate = bsdf.eval(wi, sample.wo) * sample.wo.z.abs() / sample.pdf;
                assert!((estimate - sample.weight).abs() < 1e-9, "{name}");
            }
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
