//! Two random numbers a sample: what is stratified in their square stays it, better than along a curve.

#[allow(dead_code, reason = "some of it is for others")]
mod support;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::tree::{Rank, TreeBuilder, TreeDistribution};
use bsdfkit::{Bsdf, Component, Components, DVec2, DVec3, Lambertian, Metadata, Side};
use bsdfkit_sphere::concentric::square_to_hemisphere;
use bsdfkit_sphere::direction::from_degrees;
use bsdfkit_sphere::hilbert;
use support::{Random, random_tree};

/// A lobe about the mirror direction, tabulated where the library looks values up.
fn lobe(wi: DVec3, wo: DVec3) -> f32 {
    let h = (wi + wo).normalize();
    ((-DVec2::new(h.x / 0.3, h.y / 0.5).length_squared() / (h.z * h.z)).exp() + 0.05) as f32
}

fn cases() -> [(&'static str, Bsdf); 4] {
    let of = |c| Bsdf::new(Metadata::default(), vec![c], Lambertian::default());
    let tree = |t| of(Component::new(Side::Front, Side::Front, TreeDistribution::new(t)));
    let log2 = 3;
    let cell = |n: usize| (n as f64 + 0.5) / f64::from(1 << log2);
    let values = (0..1 << (4 * log2)).map(|i| {
        let at = |d: u32| cell(i >> ((3 - d) * log2) & ((1 << log2) - 1));
        let travel = square_to_hemisphere(DVec2::new(at(0), at(1)), Side::Front);
        let wo = square_to_hemisphere(DVec2::new(at(2), at(3)), Side::Front);
        lobe(DVec3::new(-travel.x, -travel.y, travel.z), wo)
    });
    let mut four = TreeBuilder::new(Rank::Four);
    four.grid(log2, &values.collect::<Vec<_>>()).unwrap();
    let full = KlemsBasis::full();
    let values = (0..145 * 145).map(|n| {
        let (travel, wo) = (full.centre(n / 145), full.centre(n % 145));
        lobe(DVec3::new(-travel.x, -travel.y, travel.z), wo)
    });
    let matrix = KlemsMatrix::new(full.clone(), full.clone(), values.collect()).unwrap();
    [
        ("rank 4", tree(four.finish().unwrap())),
        ("rank 4, uneven", tree(random_tree(Rank::Four, 3, 0.0, &mut Random(1)))),
        ("rank 3, uneven", tree(random_tree(Rank::Three, 4, 0.0, &mut Random(3)))),
        ("Klems Full", of(Component::new(Side::Front, Side::Front, matrix))),
    ]
}

/// Variance of the mean over n × n draws, one at random in each stratum, or anywhere.
fn variance(n: u32, random: &mut Random, jitter: Jitter, draw: impl Fn(DVec2) -> f64) -> f64 {
    let runs = 100;
    let mut means = vec![0.0; runs];
    for mean in &mut means {
        let shift = DVec2::new(random.unit(), random.unit());
        for i in 0..n * n {
            let corner = DVec2::new(f64::from(i % n), f64::from(i / n));
            let u = DVec2::new(random.unit(), random.unit());
            let inside = (corner + u) / f64::from(n);
            let u = match jitter {
                Jitter::None => u,
                Jitter::Strata => inside,
                Jitter::Shifted => (inside + shift).fract(),
            };
            *mean += draw(u) / f64::from(n * n);
        }
    }
    let mean = means.iter().sum::<f64>() / runs as f64;
    means.iter().map(|m| (m - mean) * (m - mean)).sum::<f64>() / runs as f64
}

#[derive(Clone, Copy)]
enum Jitter {
    None,
    Strata,
    /// Strata moved round the square by the same random amount, as renderers do from pixel to pixel.
    Shifted,
}

/// Less variance than random numbers; and than the same strata folded along a Hilbert curve, unless they are
/// just the squares that the curve visits in one go.
#[test]
fn strata_of_the_square_beat_random_numbers_and_the_curve() {
    let all = Components::ALL;
    for (name, bsdf) in cases() {
        for (n, jitter) in [(16, Jitter::Strata), (16, Jitter::Shifted), (23, Jitter::Strata)] {
            let [mut plain, mut curve, mut warped] = [0.0; 3];
            for (theta, phi) in [(5.0, 10.0), (33.0, 70.0), (62.0, 201.0)] {
                let wi = from_degrees(theta, phi);
                let f = |s: Option<bsdfkit::Sample>| {
                    let w = s.unwrap().wo;
                    w.x + 2.0 * w.y * w.y
                };
                let two = |u| f(bsdf.sample2(wi, u, all));
                let one = |u| f(bsdf.sample(wi, hilbert::fold(u), all));
                plain += variance(n, &mut Random(7), Jitter::None, two);
                warped += variance(n, &mut Random(8), jitter, two);
                curve += variance(n, &mut Random(8), jitter, one);
            }
            let figures = format!("random {plain:.2e}, curve {curve:.2e}, warped {warped:.2e}");
            let aligned = n == 16 && matches!(jitter, Jitter::Strata);
            println!("{name}, {n} × {n}: {figures}");
            assert!(warped < 0.2 * plain, "{name}, {n}: {figures}");
            assert!(warped < curve || aligned, "{name}, {n}: {figures}");
        }
    }
}
