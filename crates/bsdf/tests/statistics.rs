//! Do samples follow their density? χ², furnace, normalisation, stratification.
//!
//! Seeds are fixed.

mod chi_squared;
mod stratified;
mod support;

use std::f64::consts::PI;

use bsdfkit::tree::{Rank, TreeDistribution};
use bsdfkit::{Bsdf, Component, Components, DVec2, DVec3, Lambertian, Lookup, Metadata, Side, Xyz};
use bsdfkit_sphere::concentric::{hemisphere_to_square, square_to_hemisphere};
use bsdfkit_sphere::direction::from_degrees;
use support::{Random, random_tree};

fn tree(rank: Rank, depth: u32, floor: f32, seed: u64) -> TreeDistribution {
    TreeDistribution::new(random_tree(rank, depth, floor, &mut Random(seed)))
}

fn of(components: Vec<Component>) -> Bsdf {
    Bsdf::new(Metadata::default(), components, Lambertian::default())
}

/// Named BSDFs of every kind that samples in its own way, by both lookups.
fn cases() -> Vec<(String, Bsdf)> {
    let smooth = stored()
        .into_iter()
        .map(|(name, bsdf)| (format!("{name}, smooth"), bsdf.with_lookup(Lookup::Smooth).unwrap()));
    let stored = stored().into_iter().map(|(name, bsdf)| (name.to_owned(), bsdf));
    stored.chain(smooth).collect()
}

fn stored() -> Vec<(&'static str, Bsdf)> {
    use Side::{Back, Front};
    let one = |incident, scattered, t| of(vec![Component::new(incident, scattered, t)]);
    let mixture = Bsdf::new(
        Metadata::default(),
        vec![
            Component::new(Front, Front, tree(Rank::Four, 3, 0.05, 5)),
            Component::new(Front, Front, tree(Rank::Four, 2, 0.0, 6)),
            Component::new(Front, Back, tree(Rank::Four, 3, 0.02, 7)),
            Component::new(Back, Back, tree(Rank::Four, 2, 0.0, 8)),
        ],
        Lambertian { reflection_front: Xyz::grey(0.2), ..Lambertian::default() },
    );
    vec![
        ("rank 4", one(Front, Front, tree(Rank::Four, 3, 0.0, 1))),
        ("rank 4, floor taken out", one(Front, Front, tree(Rank::Four, 3, 0.1, 2))),
        ("rank 3", one(Front, Front, tree(Rank::Three, 4, 0.0, 3))),
        ("rank 3 from the back", one(Back, Back, tree(Rank::Three, 4, 0.02, 4))),
        ("rank 4, transmission in reverse", one(Back, Front, tree(Rank::Four, 3, 0.02, 9))),
        ("rank 3, transmission in reverse", one(Back, Front, tree(Rank::Three, 4, 0.02, 10))),
        ("mixture", mixture),
    ]
}

const INCIDENCES: [(f64, f64); 4] = [(0.0, 0.0), (33.0, 70.0), (71.0, 201.0), (89.0, 300.0)];

fn incidences(bsdf: &Bsdf) -> impl Iterator<Item = DVec3> {
    let only_back =
        bsdf.components().iter().all(|c| c.incident == Side::Back && c.scattered == Side::Back);
    INCIDENCES
        .into_iter()
        .map(move |(theta, phi)| from_degrees(if only_back { 180.0 - theta } else { theta }, phi))
}

/// Cells of the square per side and hemisphere.
const GRID: usize = 16;

fn bin(w: DVec3) -> usize {
    let s = hemisphere_to_square(w) * GRID as f64;
    let cell = |c: f64| (c as usize).min(GRID - 1);
    let side = usize::from(Side::of(w) == Side::Back) * GRID * GRID;
    side + cell(s.y) * GRID + cell(s.x)
}

/// Step `i` of a rule on a line, in units of its mean step: two points a pair of steps, which have the
/// mean of any quadratic. [Gauss–Legendre]
fn node(i: usize) -> f64 {
    i as f64 + [0.422_649_730_810_374_2, 0.577_350_269_189_625_8][i % 2]
}

/// ∫ pdf over each bin, by `n` × `n` points a bin; `n` is even.
fn expected(bsdf: &Bsdf, wi: DVec3, components: Components, n: usize) -> Vec<f64> {
    let mut bins = vec![0.0; 2 * GRID * GRID];
    let steps = GRID * n;
    for side in [Side::Front, Side::Back] {
        for i in 0..steps * steps {
            let (x, y) = (node(i % steps), node(i / steps));
            let wo = square_to_hemisphere(DVec2::new(x, y) / steps as f64, side);
            // Equal areas are equal projected solid angles: π / steps² = |cos θ| dω.
            let density = bsdf.pdf(wi, wo, components) / wo.z.abs();
            bins[bin(wo)] += density * PI / (steps * steps) as f64;
        }
    }
    bins
}

#[test]
fn pdf_integrates_to_one() {
    for (name, bsdf) in cases() {
        for wi in incidences(&bsdf) {
            let sum: f64 = expected(&bsdf, wi, Components::ALL, 8).iter().sum();
            // Exact for a tree read forward or at rank 4; the others are quadrature.
            let tolerance =
                if name.starts_with("rank 4") || name.starts_with("mixture") { 1e-6 } else { 5e-3 };
            assert!((sum - 1.0).abs() < tolerance, "{name}, {wi}: ∫ pdf = {sum}");
        }
    }
}

#[test]
fn samples_follow_the_density() {
    let draws = 200_000;
    let cases = cases();
    let level = chi_squared::level(2 * cases.len() * INCIDENCES.len());
    for (seed, (name, bsdf)) in cases.iter().enumerate() {
        for (wi, two) in incidences(bsdf).flat_map(|wi| [(wi, false), (wi, true)]) {
            let mut random = Random(1000 + seed as u64);
            let mut observed = vec![0.0; 2 * GRID * GRID];
            for _ in 0..draws {
                let s = if two {
                    let u = DVec2::new(random.unit(), random.unit());
                    bsdf.sample2(wi, u, Components::ALL)
                } else {
                    bsdf.sample(wi, random.unit(), Components::ALL)
                };
                let s = s.expect(name);
                observed[bin(s.wo)] += 1.0;
            }
            let expected = expected(bsdf, wi, Components::ALL, 24);
            let expected: Vec<f64> = expected.iter().map(|e| e * f64::from(draws)).collect();
            chi_squared::expect(&format!("{name}, {wi}"), &observed, &expected, level);
        }
    }
}

#[test]
fn weight_is_constant_and_is_the_total() {
    let mut random = Random(77);
    for (name, bsdf) in cases() {
        for wi in incidences(&bsdf) {
            let total = bsdf.directional_hemispherical(wi, Components::ALL);
            for _ in 0..2000 {
                let s = bsdf.sample(wi, random.unit(), Components::ALL).expect(&name);
                assert_eq!(s.weight, total);
                assert_eq!(s.pdf, bsdf.pdf(wi, s.wo, Components::ALL));
                let estimate = bsdf.eval(wi, s.wo) * s.wo.z.abs() / s.pdf;
                assert!((estimate / total - 1.0).abs() < 1e-9, "{name}: {estimate} {total}");
                assert!((s.wo.length() - 1.0).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn total_is_the_integral_of_eval() {
    for (name, bsdf) in cases() {
        for wi in incidences(&bsdf) {
            let n = 384;
            let mut sum = 0.0;
            for i in 0..n * n {
                let square = DVec2::new(node(i % n), node(i / n)) / n as f64;
                sum += bsdf.eval(wi, square_to_hemisphere(square, Side::Front));
                sum += bsdf.eval(wi, square_to_hemisphere(square, Side::Back));
            }
            let integral = sum * PI / (n * n) as f64;
            let total = bsdf.directional_hemispherical(wi, Components::ALL);
            let exact = !name.starts_with("rank 3");
            let tolerance = if exact { 1e-6 } else { 5e-3 };
            assert!((integral / total - 1.0).abs() < tolerance, "{name}: {integral} vs {total}");
        }
    }
}

#[test]
fn each_selection_draws_only_what_it_selects() {
    let (_, bsdf) = cases().pop().unwrap();
    let wi = from_degrees(40.0, 10.0);
    let mut random = Random(5);
    let all = bsdf.directional_hemispherical(wi, Components::ALL);
    let mut parts = 0.0;
    for kind in [Components::LAMBERTIAN, Components::NON_LAMBERTIAN] {
        for way in [Components::REFLECTION, Components::TRANSMISSION] {
            let selection = kind & way;
            parts += bsdf.directional_hemispherical(wi, selection);
            for _ in 0..500 {
                let s = bsdf.sample(wi, random.unit(), selection).unwrap();
                assert_eq!(Side::of(s.wo) == Side::Front, way == Components::REFLECTION);
                assert!(s.pdf > 0.0);
            }
        }
    }
    assert!((parts - all).abs() < 1e-12);
    assert!(bsdf.sample(wi, 0.5, Components::BACK).is_none());
}

/// N stratified u give N stratified directions, of one number or two: the error of a smooth integral falls
/// far faster than with random u. [WKB14 §2.4]
#[test]
fn stratified_numbers_give_stratified_directions() {
    for (name, bsdf) in cases() {
        for wi in incidences(&bsdf) {
            let one = stratified::one_number(&bsdf, wi);
            let two = stratified::two_numbers(&bsdf, wi);
            // Twice what was found. Smooth lookup, and rank 3 in reverse, fold two numbers into one.
            let most = match name.as_str() {
                "rank 4" => (0.016, 0.045),
                "mixture" | "mixture, smooth" => (0.06, 0.36),
                _ if name.contains("rank 3, transmission in reverse") => (0.09, 0.38),
                _ if name.ends_with("smooth") => (0.035, 0.32),
                _ => (0.035, 0.13),
            };
            let figures = format!("{one:.4} and {two:.4} of the variance by random numbers");
            assert!(one < most.0 && two < most.1, "{name}, {wi:.2}: {figures}");
        }
    }
}

/// Helmholtz: a lone transmission component answers both ways with the same value.
#[test]
fn lone_transmission_is_reciprocal() {
    let mut random = Random(11);
    for rank in [Rank::Three, Rank::Four] {
        let bsdf = of(vec![Component::new(Side::Back, Side::Front, tree(rank, 4, 0.02, 12))]);
        assert!(bsdf.lambertian().transmission_back.y > 0.0);
        assert_eq!(bsdf.lambertian().transmission_back, bsdf.lambertian().transmission_front);
        for _ in 0..1000 {
            let (front, back) = (random.direction(Side::Front), random.direction(Side::Back));
            assert_eq!(bsdf.eval(front, back), bsdf.eval(back, front));
            assert_eq!(bsdf.eval(front, front), 0.0);
        }
    }
}
