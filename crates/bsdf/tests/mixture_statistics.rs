//! Mixtures of matrices, trees and Lambertian parts: do samples follow the density of the whole?
//!
//! Seeds are fixed.

mod chi_squared;
mod stratified;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use std::f64::consts::PI;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix, Ring};
use bsdfkit::tree::{Rank, TreeDistribution};
use bsdfkit::{
    Bsdf, Component, Components, DVec2, DVec3, Lambertian, Lookup, Metadata, Part, Side, Xyz,
};
use bsdfkit_sphere::concentric::{hemisphere_to_square, square_to_hemisphere};
use bsdfkit_sphere::direction::from_degrees;
use support::{Random, random_tree};

fn matrix(incident: &KlemsBasis, scattered: &KlemsBasis, floor: f32, seed: u64) -> KlemsMatrix {
    let random = &mut Random(seed);
    let n = incident.directions() * scattered.directions();
    let values = (0..n).map(|_| floor + random.unit().powi(6) as f32).collect();
    KlemsMatrix::new(incident.clone(), scattered.clone(), values).unwrap()
}

fn tree(rank: Rank, depth: u32, floor: f32, seed: u64) -> TreeDistribution {
    TreeDistribution::new(random_tree(rank, depth, floor, &mut Random(seed)))
}

fn cases() -> Vec<(&'static str, Bsdf)> {
    use Side::{Back, Front};
    let [full, half, quarter] = [KlemsBasis::full(), KlemsBasis::half(), KlemsBasis::quarter()];
    let rings = [(15.0, 2), (50.0, 9), (72.0, 5), (90.0, 4)];
    let rings = rings.map(|(upper_degrees, patches)| Ring { upper_degrees, patches });
    let custom = KlemsBasis::new("custom", rings.into()).unwrap();
    let of = |components, explicit| Bsdf::new(Metadata::default(), components, explicit);
    let none = Lambertian::default();
    let both = Lambertian {
        reflection_front: Xyz::grey(0.2),
        transmission_front: Xyz::grey(0.3),
        ..Lambertian::default()
    };
    let of_matrices = vec![
        Component::new(Front, Front, matrix(&full, &full, 0.0, 1)),
        Component::new(Front, Front, matrix(&quarter, &quarter, 0.0, 2)),
        Component::new(Front, Back, matrix(&half, &custom, 0.0, 3)),
    ];
    let of_either = vec![
        Component::new(Front, Front, matrix(&half, &half, 0.02, 4)),
        Component::new(Front, Front, tree(Rank::Four, 3, 0.0, 5)),
        Component::new(Front, Back, tree(Rank::Three, 4, 0.02, 6)),
    ];
    let with_lambertian = vec![Component::new(Front, Front, matrix(&full, &full, 0.1, 7))];
    let reversed = vec![
        Component::new(Back, Front, matrix(&custom, &quarter, 0.02, 8)),
        Component::new(Back, Front, tree(Rank::Four, 2, 0.0, 9)),
    ];
    let smooth = of(of_either.clone(), none).with_lookup(Lookup::Smooth).unwrap();
    vec![
        ("matrices", of(of_matrices, none)),
        ("matrix and trees", of(of_either, none)),
        ("matrix and trees, smooth", smooth),
        ("matrix and Lambertian parts", of(with_lambertian, both)),
        ("matrix and tree in reverse", of(reversed, none)),
    ]
}

const INCIDENCES: [(f64, f64); 3] = [(0.0, 0.0), (33.0, 70.0), (81.0, 201.0)];

/// Cells of the square per side and hemisphere.
const GRID: usize = 16;

fn bin(w: DVec3) -> usize {
    let s = hemisphere_to_square(w) * GRID as f64;
    let cell = |c: f64| (c as usize).min(GRID - 1);
    let side = usize::from(Side::of(w) == Side::Back) * GRID * GRID;
    side + cell(s.y) * GRID + cell(s.x)
}

/// ∫ pdf over each bin by 64 × 64 points: patches of a matrix end anywhere in a bin.
fn expected(bsdf: &Bsdf, wi: DVec3) -> Vec<f64> {
    let steps = GRID * 64;
    let point = |n: usize| (n as f64 + 0.5) / steps as f64;
    let mut bins = vec![0.0; 2 * GRID * GRID];
    for side in [Side::Front, Side::Back] {
        for row in 0..steps {
            let wo: Vec<DVec3> = (0..steps)
                .map(|n| square_to_hemisphere(DVec2::new(point(n), point(row)), side))
                .collect();
            let mut densities = vec![0.0; steps];
            bsdf.pdf_many(&[wi], &wo, Components::ALL, &mut densities).unwrap();
            // Equal areas are equal projected solid angles: π / steps² = |cos θ| dω.
            for (wo, density) in wo.iter().zip(densities) {
                bins[bin(*wo)] += density / wo.z.abs() * PI / (steps * steps) as f64;
            }
        }
    }
    bins
}

#[test]
fn samples_follow_the_density() {
    let draws = 100_000;
    let cases = cases();
    let level = chi_squared::level(2 * cases.len() * INCIDENCES.len());
    for (seed, (name, bsdf)) in cases.iter().enumerate() {
        let random = &mut Random(100 + seed as u64);
        for (theta, phi) in INCIDENCES {
            let wi = from_degrees(theta, phi);
            let expected = expected(bsdf, wi);
            let sum: f64 = expected.iter().sum();
            assert!((sum - 1.0).abs() < 1e-3, "{name} at {theta}°: ∫ pdf = {sum}");
            let expected: Vec<f64> = expected.iter().map(|e| e * f64::from(draws)).collect();
            let mut observed = [vec![0.0; expected.len()], vec![0.0; expected.len()]];
            for _ in 0..draws {
                let u = DVec2::new(random.unit(), random.unit());
                let drawn =
                    [bsdf.sample(wi, u.x, Components::ALL), bsdf.sample2(wi, u, Components::ALL)];
                for (observed, sample) in observed.iter_mut().zip(drawn) {
                    observed[bin(sample.expect(name).wo)] += 1.0;
                }
            }
            for (numbers, observed) in observed.iter().enumerate() {
                let name = format!("{name} at {theta}°, sample{}", numbers + 1);
                chi_squared::expect(&name, observed, &expected, level);
            }
        }
    }
}

/// The weight is the total of all parts, and each part is drawn as often as its share of it.
#[test]
fn parts_are_drawn_by_their_totals() {
    let draws = 20_000;
    for (name, bsdf) in cases() {
        for (theta, phi) in INCIDENCES {
            let wi = from_degrees(theta, phi);
            let total = bsdf.directional_hemispherical(wi, Components::ALL);
            // Reflection and transmission, each Lambertian or not.
            let mut counts = [[0.0; 2]; 2];
            for i in 0..draws {
                let u = (f64::from(i) + 0.5) / f64::from(draws);
                let s = bsdf.sample(wi, u, Components::ALL).expect(name);
                assert!((s.weight - total).abs() < 1e-12 * total, "{name}: {} {total}", s.weight);
                let estimate = bsdf.eval(wi, s.wo) * s.wo.z.abs() / s.pdf;
                assert!((estimate / total - 1.0).abs() < 1e-6, "{name}: {estimate} {total}");
                let other = usize::from(matches!(s.part, Part::Component(_)));
                counts[usize::from(s.wo.z <= 0.0)][other] += 1.0 / f64::from(draws);
            }
            for (way, counts) in
                [Components::REFLECTION, Components::TRANSMISSION].into_iter().zip(counts)
            {
                for (kind, count) in
                    [Components::LAMBERTIAN, Components::NON_LAMBERTIAN].into_iter().zip(counts)
                {
                    let share = bsdf.directional_hemispherical(wi, way & kind) / total;
                    // u is stratified: each interval is counted but for its ends.
                    let error = (count - share).abs();
                    assert!(error < 4.0 / f64::from(draws), "{name}: {count} {share}");
                }
            }
        }
    }
}

#[test]
fn stratified_numbers_give_stratified_directions() {
    for (name, bsdf) in cases() {
        for (theta, phi) in INCIDENCES {
            let wi = from_degrees(theta, phi);
            let (one, two) =
                (stratified::one_number(&bsdf, wi), stratified::two_numbers(&bsdf, wi));
            // Twice what was found; the part that is drawn takes its share of the first number.
            let figures = format!("{one:.4} and {two:.4} of the variance by random numbers");
            assert!(one < 0.08 && two < 0.7, "{name} at {theta}°: {figures}");
        }
    }
}
