//! The render form beside the interpolant that it is made of: fidelity, energy, samples, size, speed.
//!
//!     cargo run --release -p bsdfkit-fit --example bench_render -- MATERIAL.safetensors...
//!
//! A line for each material. L1: the share of light in a wrong place, at measured incidences (the vertices), at others
//! (golden spiral to 75 degrees), at 80 and at 85 degrees. dhr: rms and largest difference of
//! directional-hemispherical values over the same incidences. weight: largest rms of the weights of samples about their mean,
//! over the mean; pdf: largest difference of its integral from 1. ns: a value and a sample at random directions, one thread.
//! With `--tree`, the same of the default tree of the material, stored and smooth.

use std::f64::consts::PI;
use std::path::Path;
use std::time::Instant;

use bsdfkit::{Bsdf, Components, DVec2, DVec3, Lookup, Metadata, Side, container};
use bsdfkit_fit::deliver::{Kind, Order, Subject};
use bsdfkit_fit::interpolant::{Interpolant, Part};
use bsdfkit_represent::{Source, Watch};
use bsdfkit_sphere::concentric::disk_to_hemisphere;
use bsdfkit_sphere::direction::from_degrees;

/// Directions at which one incidence is compared: strata, drawn half by the interpolant and half everywhere.
const STRATA: usize = 4096;

fn number(n: usize) -> f64 {
    let mut x = (n as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x2545_f491_4f6c_dd1d;
    x ^= x >> 30;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 27;
    x = x.wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^= x >> 31;
    (x >> 11) as f64 / (1_u64 << 53) as f64
}

/// Directions of one incidence with the inverse of their density: of the interpolant's values their sum is the total.
struct Drawn {
    wi: DVec3,
    wo: Vec<DVec3>,
    over_density: Vec<f64>,
    values: Vec<f64>,
    total: f64,
}

impl Drawn {
    fn new(of: &Bsdf, wi: DVec3, scattered: Side) -> Self {
        let count = STRATA;
        let u: Vec<f64> = (0..count).map(|n| (n as f64 + number(n)) / count as f64).collect();
        let mut samples = vec![None; count];
        of.sample_many(&[wi], &u, Components::ALL, &mut samples).expect("as many");
        let mut wo: Vec<DVec3> = samples.iter().flatten().map(|s| s.wo).collect();
        let drawn = wo.len();
        for n in 0..count {
            let r = ((n as f64 + 0.5) / count as f64).sqrt();
            wo.push(disk_to_hemisphere(DVec2::from_angle(n as f64 * 2.4) * r, scattered));
        }
        let (mut values, mut pdf) = (vec![0.0; wo.len()], vec![0.0; wo.len()]);
        of.eval_many(&[wi], &wo, &mut values).expect("as many");
        of.pdf_many(&[wi], &wo, Components::ALL, &mut pdf).expect("as many");
        let over_density: Vec<f64> = wo
            .iter()
            .zip(&pdf)
            .map(|(w, pdf)| {
                let z = w.z.abs();
                z / (drawn as f64 * pdf + count as f64 * z / PI)
            })
            .collect();
        let total = values.iter().zip(&over_density).map(|(f, d)| f * d).sum();
        Self { wi, wo, over_density, values, total }
    }

    /// L1 and the total's error.
    fn error(&self, of: &Bsdf) -> (f64, f64) {
        let mut found = vec![0.0; self.wo.len()];
        of.eval_many(&[self.wi], &self.wo, &mut found).expect("as many");
        let (mut wrong, mut total) = (0.0, 0.0);
        for ((f, g), d) in self.values.iter().zip(&found).zip(&self.over_density) {
            wrong += (f - g).abs() * d;
            total += g * d;
        }
        (wrong / self.total.max(1e-9), total - self.total)
    }

    /// Relative rms of weights, and the integral of the density less 1.
    fn samples(&self, of: &Bsdf) -> (f64, f64) {
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
        for n in 0..STRATA {
            let u = (n as f64 + number(n + 77)) / STRATA as f64;
            let weight = of.sample(self.wi, u, Components::ALL).map_or(0.0, |s| s.weight);
            (sum, squares, count) = (sum + weight, squares + weight * weight, count + 1.0);
        }
        let mean: f64 = sum / count;
        let rms = (squares / count - mean * mean).max(0.0).sqrt() / mean.max(1e-9);
        let mut integral = 0.0;
        for (w, d) in self.wo.iter().zip(&self.over_density) {
            integral += of.pdf(self.wi, *w, Components::ALL) * d / w.z.abs().max(1e-9);
        }
        (rms, integral - 1.0)
    }
}

fn incidences(interpolant: &Interpolant) -> [Vec<DVec3>; 4] {
    let part = &interpolant.components[0];
    let sign = part.incident().sign();
    let side = |w: DVec3| DVec3::new(w.x, w.y, sign * w.z.abs());
    let mut measured = Vec::new();
    if let Part::Transported(c) = part {
        measured = c.incidences().iter().map(|i| side(i.wi)).collect();
        let step = measured.len().div_ceil(40);
        measured = measured.into_iter().step_by(step).collect();
    }
    let spiral = (0..24).map(|n| {
        let theta = 75.0 * ((f64::from(n) + 0.5) / 24.0).sqrt();
        side(from_degrees(theta, f64::from(n) * 137.5))
    });
    let ring =
        |theta: f64| (0..8).map(move |k| side(from_degrees(theta, f64::from(k) * 45.0 + 7.0)));
    [measured, spiral.collect(), ring(80.0).collect(), ring(85.0).collect()]
}

fn line(label: &str, form: &Bsdf, sets: &[Vec<Drawn>; 4], bytes: u64, seconds: f64) {
    let mut text = format!("{label:32} {:6.2} MB {seconds:6.1} s  L1", bytes as f64 / 1e6);
    let (mut squares, mut most, mut count) = (0.0, 0.0_f64, 0.0);
    for set in sets {
        let errors: Vec<(f64, f64)> = set.iter().map(|d| d.error(form)).collect();
        let mean = errors.iter().map(|e| e.0).sum::<f64>() / errors.len().max(1) as f64;
        text += &format!(" {mean:.4}");
        for (_, e) in errors {
            (squares, most, count) = (squares + e * e, most.max(e.abs()), count + 1.0);
        }
    }
    text += &format!("  dhr {:.4} {most:.4}", (squares / count).sqrt());
    let samples: Vec<(f64, f64)> =
        sets[1].iter().chain(&sets[2]).step_by(4).map(|d| d.samples(form)).collect();
    if std::env::var_os("BENCH_EACH").is_some() {
        for d in sets.iter().flatten() {
            let ((e, t), (w, p)) = (d.error(form), d.samples(form));
            let theta = d.wi.z.abs().acos().to_degrees();
            let phi = d.wi.y.atan2(d.wi.x).to_degrees();
            println!(
                "# {theta:5.1} {phi:6.1} L1 {e:.4} dhr {t:+.4} of {:.3}; weight {w:.3} pdf {p:+.4}",
                d.total
            );
        }
    }
    let worst = samples.iter().fold((0.0_f64, 0.0_f64), |w, s| (w.0.max(s.0), w.1.max(s.1.abs())));
    text += &format!("  weight {:.3} pdf {:.4}", worst.0, worst.1);
    let (value, sample) = speed(form, &sets[0], &sets[1]);
    println!("{text}  ns {value:.0} {sample:.0}");
}

/// Nanoseconds a value and a sample at random directions on the sides that are known.
fn speed(form: &Bsdf, a: &[Drawn], b: &[Drawn]) -> (f64, f64) {
    let any = a.iter().chain(b).next().expect("one");
    let (incident, scattered) = (Side::of(any.wi), Side::of(any.wo[0]));
    let directions = |side: Side, seed: usize| -> Vec<DVec3> {
        let one = |n: usize| {
            let (r, turn) = (number(2 * n + seed).sqrt(), number(2 * n + 1 + seed) * 2.0 * PI);
            disk_to_hemisphere(DVec2::from_angle(turn) * r, side)
        };
        (0..1 << 16).map(one).collect()
    };
    let (wi, wo) = (directions(incident, 1), directions(scattered, 1 << 20));
    let mut best = (f64::INFINITY, f64::INFINITY);
    for _ in 0..5 {
        let start = Instant::now();
        let sum: f64 = wi.iter().zip(&wo).map(|(&wi, &wo)| form.eval(wi, wo)).sum();
        best.0 = best.0.min(start.elapsed().as_nanos() as f64 / wi.len() as f64);
        let start = Instant::now();
        let drawn = |n: usize| form.sample(wi[n], number(n), Components::ALL);
        let sums: f64 = (0..wi.len()).filter_map(drawn).map(|s| s.weight).sum();
        best.1 = best.1.min(start.elapsed().as_nanos() as f64 / wi.len() as f64);
        assert!(sum.is_finite() && sums.is_finite());
    }
    best
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let tree = arguments.iter().any(|a| a == "--tree");
    for file in arguments.iter().filter(|a| !a.starts_with("--")) {
        let path = Path::new(file);
        let interpolant = Interpolant::open(path).expect("an interpolant");
        let bsdf = interpolant.bsdf();
        let scattered = interpolant.components[0].scattered();
        let sets = incidences(&interpolant).map(|set| {
            set.into_iter().map(|wi| Drawn::new(&bsdf, wi, scattered)).collect::<Vec<_>>()
        });
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let kinds: &[Kind] = if tree { &[Kind::Render, Kind::TensorTree] } else { &[Kind::Render] };
        for &kind in kinds {
            let start = Instant::now();
            let made = Order::new(kind)
                .deliver(Subject::Continuous(&interpolant), Metadata::default(), &Watch::default())
                .expect("tabulated");
            let seconds = start.elapsed().as_secs_f64();
            let folder = tempfile::tempdir().expect("a folder");
            let written = folder.path().join("form.safetensors");
            container::save(&made.bsdf, &written).expect("written");
            let bytes = std::fs::metadata(&written).expect("written").len();
            let start = Instant::now();
            let form = Bsdf::open(&written).expect("opened");
            let opened = start.elapsed().as_secs_f64() * 1e3;
            let label = format!("{name} {} ({opened:.1} ms)", kind.name());
            line(&label, &form, &sets, bytes, seconds);
            if kind == Kind::TensorTree {
                let smooth = form.with_lookup(Lookup::Smooth).expect("sound");
                line(&format!("{name} smooth"), &smooth, &sets, bytes, seconds);
            }
        }
    }
}
