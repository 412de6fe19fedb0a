//! Error against number of incidences: planned, on a regular grid, and at random.
//!
//!     cargo run --release -p bsdfkit-fit --example bench_plan [material ...]
//!
//! Virtual specimens are measured, fitted and compared with their closed form at incident directions
//! spread evenly (by projected solid angle) to 75 degrees. Printed, for the mean of their L1 and for the
//! L1 of all their light together: the error for each number of incidences, then how many incidences
//! each way takes to the errors of the regular grids.

use bsdfkit::{DVec3, Side};
use bsdfkit_fit::interpolant::build::build;
use bsdfkit_fit::interpolant::{Component, FitSettings};
use bsdfkit_fit::measurement::{Colorimetry, Incidence, Measurement, Mirror, Symmetry};
use bsdfkit_fit::survey::{Limits, Subject, propose};
use bsdfkit_fit::tabulate::Watch;
use bsdfkit_fit::validate::{ErrorModel, Validation};
use bsdfkit_simulate::random::Random;
use bsdfkit_simulate::{Goniophotometer, Material, SymmetryHint, registry};
use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::concentric::square_to_hemisphere;
use bsdfkit_sphere::direction::{from_degrees, to_degrees};
use rayon::prelude::*;

const MAX_THETA: f64 = 75.0;
/// Incident directions at which errors are averaged.
const TESTS: usize = 96;

/// (incidences, error), by number of incidences.
type Curve = Vec<(usize, f64)>;

/// Two errors of one interpolant.
#[derive(Clone, Copy)]
struct Errors {
    /// Mean L1 over the test directions.
    mean: f64,
    /// L1 of all their light together: nearly dark directions count little.
    together: f64,
}

/// What each way came to, by number of incidences.
struct Ways {
    regular: Vec<(usize, Errors)>,
    planned: Vec<(usize, Errors)>,
    /// From several seeds.
    random: Vec<Vec<(usize, Errors)>>,
}

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    for material in registry() {
        if asked.is_empty() || asked.iter().any(|a| a == material.name()) {
            compare(&*material);
        }
    }
}

/// A material and how it is fitted: the frame, which costs most to find, is found once.
struct Specimen<'a> {
    material: &'a dyn Material,
    settings: FitSettings,
}

fn compare(material: &dyn Material) {
    println!("{}", material.name());
    let (settings, watch) = (FitSettings::default(), Watch::default());
    let found = build(&measured(material, &grid(material, 4)), &settings, &watch).expect("fitted");
    let frame = Some(found.motion.frame);
    let specimen = Specimen { material, settings: FitSettings { frame, ..settings } };
    let error =
        |angles: &Vec<(f64, f64)>| (angles.len(), specimen.error(&specimen.fitted(angles).1));
    let regular: Vec<_> = grids(material).iter().map(error).collect();
    let planned = specimen.planned(regular.last().map_or(0, |r| r.0));
    let seed = |seed: u64| regular.iter().map(|r| error(&random(material, r.0, seed))).collect();
    let ways = Ways { random: [1, 2].map(seed).into(), regular, planned };
    println!(" mean L1");
    ways.report(|e| e.mean);
    println!(" L1 of all light");
    ways.report(|e| e.together);
}

impl Ways {
    fn report(&self, of: impl Fn(&Errors) -> f64) {
        let curve = |way: &[(usize, Errors)]| way.iter().map(|(n, e)| (*n, of(e))).collect();
        let (regular, planned): (Curve, Curve) = (curve(&self.regular), curve(&self.planned));
        let seeds: Vec<Curve> = self.random.iter().map(|way| curve(way)).collect();
        let mean = |k: usize| seeds.iter().map(|s| s[k].1).sum::<f64>() / seeds.len() as f64;
        let random: Curve = (0..regular.len()).map(|k| (regular[k].0, mean(k))).collect();
        for (name, curve) in [("regular", &regular), ("planned", &planned), ("random", &random)] {
            show(name, curve);
        }
        for &(_, l1) in &regular[1..] {
            let Some(grid) = first(&regular, l1) else { continue };
            let takes = |curve: &Curve| match for_good(curve, l1) {
                Some(m) => format!("{m:.1} ({:+.0} %)", 100.0 * (m / grid - 1.0)),
                None => "more than tried".to_owned(),
            };
            println!(
                "  to {l1:.4}: regular {grid:.1}, planned {}, random {}",
                takes(&planned),
                takes(&random)
            );
        }
    }
}

fn show(name: &str, curve: &Curve) {
    let text: Vec<String> = curve.iter().map(|(n, l1)| format!("{n}: {l1:.4}")).collect();
    println!("  {name:8} {}", text.join("  "));
}

/// Incidences that a curve takes to an error, once below it.
fn first(curve: &Curve, l1: f64) -> Option<f64> {
    match curve.iter().position(|c| c.1 <= l1)? {
        0 => Some(curve[0].0 as f64),
        k => Some(between(curve[k - 1], curve[k], l1)),
    }
}

/// Incidences that a curve takes to stay below an error.
fn for_good(curve: &Curve, l1: f64) -> Option<f64> {
    match curve.iter().rposition(|c| c.1 > l1) {
        None => Some(curve[0].0 as f64),
        Some(k) => Some(between(curve[k], *curve.get(k + 1)?, l1)),
    }
}

/// Between two points of a curve, by powers.
fn between((n, a): (usize, f64), (m, b): (usize, f64), l1: f64) -> f64 {
    let t = (a / l1).ln() / (a / b).ln();
    n as f64 * (m as f64 / n as f64).powf(t)
}

/// The azimuths that a symmetry leaves, and whether both ends are mirrors.
fn azimuths(material: &dyn Material) -> (f64, bool) {
    match material.symmetry() {
        SymmetryHint::Isotropic => (0.0, true),
        SymmetryHint::Quadrilateral => (90.0, true),
        SymmetryHint::Bilateral => (180.0, true),
        SymmetryHint::None => (360.0, false),
    }
}

/// A grid of `rings` polar angles and azimuths twice as far apart (30 degrees for 15).
fn grid(material: &dyn Material, rings: usize) -> Vec<(f64, f64)> {
    let step = MAX_THETA / rings as f64;
    let (range, closed) = azimuths(material);
    let steps = (range / (2.0 * step)).round().max(1.0) as usize;
    let count = if range == 0.0 { 1 } else { steps + usize::from(closed) };
    let mut angles = vec![(0.0, 0.0)];
    for ring in 1..=rings {
        let theta = step * ring as f64;
        angles.extend((0..count).map(|k| (theta, range * k as f64 / steps as f64)));
    }
    angles
}

fn grids(material: &dyn Material) -> Vec<Vec<(f64, f64)>> {
    let rings = if material.symmetry() == SymmetryHint::Isotropic { 2..=8 } else { 2..=6 };
    rings.map(|r| grid(material, r)).collect()
}

impl Specimen<'_> {
    /// Starts from the coarsest grid and adds what is proposed, a quarter more each time.
    fn planned(&self, most: usize) -> Vec<(usize, Errors)> {
        let mut angles = grid(self.material, 2);
        let mut curve = Vec::new();
        loop {
            let (m, component) = self.fitted(&angles);
            curve.push((angles.len(), self.error(&component)));
            if angles.len() >= most {
                return curve;
            }
            let watch = Watch::default();
            let validation = Validation::of(&m, &component, &watch).expect("validated");
            let model = ErrorModel::of(&component, &validation);
            let subject = Subject { component: &component, validation: &validation, model: &model };
            let limits = Limits { max_theta_degrees: MAX_THETA, spacing_degrees: 4.0 };
            let budget = (angles.len() / 4).max(1);
            let proposals = propose(&[subject], &limits, budget, &watch).expect("proposals");
            if proposals.is_empty() {
                return curve;
            }
            angles.extend(proposals.iter().map(|p| to_degrees(p.wi)));
        }
    }

    fn fitted(&self, angles: &[(f64, f64)]) -> (Measurement, Component) {
        let m = measured(self.material, angles);
        let component = build(&m, &self.settings, &Watch::default()).expect("fitted");
        (m, component)
    }

    fn error(&self, component: &Component) -> Errors {
        const CELLS: usize = 64;
        let material = self.material;
        let wo: Vec<DVec3> = (0..CELLS * CELLS)
            .map(|k| DVec2::new((k / CELLS) as f64 + 0.5, (k % CELLS) as f64 + 0.5) / CELLS as f64)
            .map(|s| square_to_hemisphere(s, material.scattered()))
            .collect();
        let one = |k: usize| {
            // R2 low-discrepancy sequence over the disk.
            let t = k as f64 + 0.5;
            let (u, v) = ((t * 0.754_877_666_2).fract(), (t * 0.569_840_290_998).fract());
            let theta = (MAX_THETA.to_radians().sin() * u.sqrt()).asin().to_degrees();
            let wi = from_degrees(theta, 360.0 * v);
            let distribution = component.at(wi);
            let (mut error, mut total) = (0.0, 0.0);
            for &w in &wo {
                let truth = material.eval(wi, w);
                error += (distribution.eval(w) - truth).abs();
                total += truth;
            }
            (error, total)
        };
        let each: Vec<(f64, f64)> = (0..TESTS).into_par_iter().map(one).collect();
        let (error, total) = each.iter().fold((0.0, 0.0), |s, e| (s.0 + e.0, s.1 + e.1));
        let mean = each.iter().map(|e| e.0 / e.1).sum::<f64>() / TESTS as f64;
        Errors { mean, together: error / total }
    }
}

/// Evenly by projected solid angle, the normal and the corners of the range among them.
fn random(material: &dyn Material, count: usize, seed: u64) -> Vec<(f64, f64)> {
    let mut random = Random::new(seed);
    let (range, closed) = azimuths(material);
    let mut angles = vec![(0.0, 0.0), (MAX_THETA, 0.0)];
    if range > 0.0 {
        angles.extend([1.0, 2.0].map(|k| (MAX_THETA, range * k / if closed { 2.0 } else { 3.0 })));
    }
    let limit = MAX_THETA.to_radians().sin();
    while angles.len() < count {
        let r = limit * random.unit().sqrt();
        angles.push((r.asin().to_degrees(), range * random.unit()));
    }
    angles.truncate(count.max(4));
    angles
}

fn measured(material: &dyn Material, angles: &[(f64, f64)]) -> Measurement {
    let gonio = Goniophotometer {
        sweeps: 36,
        points_per_sweep: 120,
        spiral_points: 2000,
        ..Goniophotometer::default()
    };
    let scan = |&(theta, phi): &(f64, f64)| {
        let scan = gonio.scan(material, theta, phi);
        Incidence { wi: scan.wi, wo: scan.wo, values: scan.values, files: Vec::new() }
    };
    Measurement {
        incident: Side::Front,
        scattered: material.scattered(),
        colorimetry: Colorimetry::Luminance,
        symmetry: match material.symmetry() {
            SymmetryHint::Isotropic => Symmetry::Isotropic,
            SymmetryHint::Quadrilateral => Symmetry::Quadrilateral,
            SymmetryHint::Bilateral => Symmetry::Bilateral(Mirror::Y),
            SymmetryHint::None => Symmetry::None,
        },
        incidences: angles.par_iter().map(scan).collect(),
        sample_name: None,
        notes: Vec::new(),
    }
}
