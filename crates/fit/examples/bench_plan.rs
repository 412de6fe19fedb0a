//! Error against number of incidences: planned, on a regular grid, and at random.
//!
//!     cargo run --release -p bsdfkit-fit --example bench_plan [--others] [material ...]
//!
//! `--others`: the same materials with other parameters. Rings and what goes on past the rim were
//! chosen with these in sight, too.
//!
//! Virtual specimens are measured, fitted and compared with their closed form at incident
//! directions spread evenly (by projected solid angle) to 75 degrees. Printed, for the mean of
//! their L1 and for the L1 of all their light together: the errors of regular grids, of plans with
//! 30 % fewer incidences, of plans continued (half of as many to begin with, the rest as these
//! show) and of as many at random; then how many incidences either plan saves by the power laws
//! through all of them.

use bsdfkit::{DVec3, Side};
use bsdfkit_fit::interpolant::build;
use bsdfkit_fit::interpolant::{Component, FitSettings};
use bsdfkit_fit::survey::{Limits, Subject, begin, propose};
use bsdfkit_fit::validate::{ErrorModel, Validation};
use bsdfkit_measure::{Colorimetry, Incidence, Measurement, Mirror, Symmetry};
use bsdfkit_represent::Watch;
use bsdfkit_simulate::material::{
    BrushedMetal, Fabric, FrittedGlass, PrismFilm, RotatedMetal, RoughDielectric,
};
use bsdfkit_simulate::random::Random;
use bsdfkit_simulate::{Goniophotometer, Material, SymmetryHint, six};
use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::concentric::square_to_hemisphere;
use bsdfkit_sphere::direction::{from_degrees, to_degrees};
use rayon::prelude::*;

const MAX_THETA: f64 = 75.0;
const LIMITS: Limits = Limits { max_theta_degrees: MAX_THETA, spacing_degrees: 4.0 };
/// Incident directions at which errors are averaged.
const TESTS: usize = 192;

/// Two errors of one interpolant.
#[derive(Clone, Copy)]
struct Errors {
    /// Mean L1 over the test directions.
    mean: f64,
    /// L1 of all their light together: nearly dark directions count little.
    together: f64,
}

/// A number of incidences and what they came to.
type Outcome = (usize, Errors);

/// A regular grid, and the other ways with fewer incidences.
struct Level {
    regular: Outcome,
    planned: Outcome,
    continued: Outcome,
    /// As many as planned, from several seeds.
    random: Vec<Errors>,
}

/// Share of a grid's incidences that a plan has.
const SHARE: f64 = 0.7;
/// Plans of fewer incidences are not continued: leaving out one of the half of them shows too
/// little.
const FEW: usize = 10;
/// Polar angles of grids and chains times these.
const STRETCHES: [f64; 3] = [0.997, 1.0, 1.003];

fn main() {
    let (options, asked): (Vec<_>, Vec<_>) =
        std::env::args().skip(1).partition(|a| a.starts_with("--"));
    for material in if options.is_empty() { six() } else { others() } {
        if asked.is_empty() || asked.iter().any(|a| a == material.name()) {
            compare(&*material);
        }
    }
}

/// The six with other parameters.
fn others() -> Vec<Box<dyn Material>> {
    vec![
        Box::new(BrushedMetal { roughness_x: 0.07, roughness_y: 0.3, specular: 0.5, diffuse: 0.2 }),
        Box::new(RotatedMetal {
            roughness_x: 0.13,
            roughness_y: 0.42,
            rotation_degrees: 55.0,
            reflectance: 0.8,
        }),
        Box::new(Fabric {
            roughness_x: 0.16,
            roughness_y: 0.45,
            twist_degrees: 40.0,
            tilt_degrees: 6.0,
            specular: 0.2,
            diffuse: 0.3,
        }),
        Box::new(PrismFilm {
            index: 1.53,
            tilts_degrees: [23.0, -18.0],
            areas: [0.5, 0.4],
            beam_degrees: 4.0,
            diffuse: 0.05,
        }),
        Box::new(FrittedGlass { index: 1.5, beam_degrees: 2.6, forward: 0.4, diffuse: 0.35 }),
        Box::new(RoughDielectric { index: 1.55, roughness: 0.2, diffuse: 0.02 }),
    ]
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
    let frame = Some(found.motion().frame);
    let specimen = Specimen { material, settings: FitSettings { frame, ..settings } };
    let levels: Vec<Level> = grids(material).iter().map(|g| specimen.level(g)).collect();
    report(" mean L1", &levels, |e| e.mean);
    report(" L1 of all light", &levels, |e| e.together);
}

fn report(name: &str, levels: &[Level], of: impl Fn(&Errors) -> f64) {
    println!("{name}");
    for Level { regular, planned, continued, random } in levels {
        let [grid, plan, more] = [regular, planned, continued].map(|outcome| of(&outcome.1));
        let chance = random.iter().map(&of).sum::<f64>() / random.len() as f64;
        println!(
            "  regular {:2}: {grid:.4}   planned {:2}: {plan:.4} ({:+3.0} %)   continued {:2}: {more:.4}   random {chance:.4}",
            regular.0,
            planned.0,
            100.0 * (plan / grid - 1.0),
            continued.0,
        );
    }
    let curve = |way: &dyn Fn(&Level) -> Outcome| {
        PowerLaw::through(levels.iter().map(way).map(|(n, e)| (n as f64, of(&e))))
    };
    let regular = curve(&|l| l.regular);
    for (way, plan) in [("planned", curve(&|l| l.planned)), ("continued", curve(&|l| l.continued))]
    {
        let level = 0.5 * (regular.log_error + plan.log_error);
        let saved = 1.0 - (plan.log_count(level) - regular.log_count(level)).exp();
        println!("  {way}: {:.0} % fewer incidences to {:.4}", 100.0 * saved, level.exp());
    }
}

/// log error = its mean + slope (log incidences − their mean), by least squares.
struct PowerLaw {
    log_incidences: f64,
    log_error: f64,
    slope: f64,
}

impl PowerLaw {
    fn through(points: impl Iterator<Item = (f64, f64)>) -> Self {
        let logs: Vec<(f64, f64)> = points.map(|(n, e)| (n.ln(), e.ln())).collect();
        let mean =
            |of: &dyn Fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / logs.len() as f64;
        let (log_incidences, log_error) = (mean(&|p| p.0), mean(&|p| p.1));
        let both = mean(&|p| (p.0 - log_incidences) * (p.1 - log_error));
        let slope = both / mean(&|p| (p.0 - log_incidences).powi(2));
        Self { log_incidences, log_error, slope }
    }

    fn log_count(&self, log_error: f64) -> f64 {
        self.log_incidences + (log_error - self.log_error) / self.slope
    }
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
    let rings = if material.symmetry() == SymmetryHint::Isotropic { 5..=9 } else { 3..=6 };
    rings.map(|r| grid(material, r)).collect()
}

impl Specimen<'_> {
    fn level(&self, grid: &[(f64, f64)]) -> Level {
        let count = (SHARE * grid.len() as f64) as usize;
        let random =
            [1, 2].map(|seed| self.error(&self.fitted(&random(self.material, count, seed)).1));
        let planned = self.about(count, &|n| self.begun(n));
        let continued = || self.about(count, &|n| self.continued(n));
        Level {
            regular: (grid.len(), self.usual_error(grid)),
            planned,
            continued: if count < FEW { planned } else { continued() },
            random: random.into(),
        }
    }

    /// Plans of `count` incidences, one more and one fewer (geometric mean): layouts that differ by
    /// one incidence have little else in common, and each is a draw. Chains have only one way to
    /// lie.
    fn about(&self, count: usize, plan: &dyn Fn(usize) -> Vec<(f64, f64)>) -> Outcome {
        if self.material.symmetry() == SymmetryHint::Isotropic {
            return (count, self.usual_error(&plan(count)));
        }
        let near = [count - 1, count, count + 1];
        let errors = near.map(|n| self.error(&self.fitted(&plan(n)).1));
        let mean = |of: fn(&Errors) -> f64| {
            (errors.iter().map(|e| of(e).ln()).sum::<f64>() / errors.len() as f64).exp()
        };
        (count, Errors { mean: mean(|e| e.mean), together: mean(|e| e.together) })
    }

    fn begun(&self, count: usize) -> Vec<(f64, f64)> {
        let (symmetry, scattered) = (symmetry(self.material), self.material.scattered());
        let first = begin(symmetry, scattered, &LIMITS, count, &Watch::default());
        first.expect("directions").into_iter().map(to_degrees).collect()
    }

    /// The first half as nothing is known, the rest as the first half shows.
    fn continued(&self, count: usize) -> Vec<(f64, f64)> {
        let mut angles = self.begun(count / 2);
        let watch = Watch::default();
        let (m, component) = self.fitted(&angles);
        let validation = Validation::of(&m, &component, &watch).expect("validated");
        let model = ErrorModel::of(&component, &validation);
        let subject = Subject { component: &component, validation: &validation, model: &model };
        let more = count - angles.len();
        let proposals = propose(&[subject], &LIMITS, more, &watch).expect("proposals");
        angles.extend(proposals.iter().map(|p| to_degrees(p.wi)));
        angles
    }

    fn fitted(&self, angles: &[(f64, f64)]) -> (Measurement, Component) {
        let m = measured(self.material, angles);
        let component = build(&m, &self.settings, &Watch::default()).expect("fitted");
        (m, component)
    }

    /// Mean over sets that differ by a fifth of a degree at most: fits do not go the same way
    /// twice, and errors of one set alone scatter by a fifth.
    fn usual_error(&self, angles: &[(f64, f64)]) -> Errors {
        let stretched = STRETCHES.map(|stretch| {
            let angles: Vec<_> = angles.iter().map(|&(t, p)| (t * stretch, p)).collect();
            self.error(&self.fitted(&angles).1)
        });
        let mean =
            |of: fn(&Errors) -> f64| stretched.iter().map(of).sum::<f64>() / stretched.len() as f64;
        Errors { mean: mean(|e| e.mean), together: mean(|e| e.together) }
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
    let gonio = Goniophotometer::default();
    let scan = |&(theta, phi): &(f64, f64)| {
        let scan = gonio.scan(material, theta, phi);
        Incidence::new(scan.wi, scan.wo, scan.values)
    };
    Measurement {
        incident: Side::Front,
        scattered: material.scattered(),
        colorimetry: Colorimetry::Luminance,
        symmetry: symmetry(material),
        incidences: angles.par_iter().map(scan).collect(),
        sample_name: None,
        notes: Vec::new(),
    }
}

fn symmetry(material: &dyn Material) -> Symmetry {
    match material.symmetry() {
        SymmetryHint::Isotropic => Symmetry::Isotropic,
        SymmetryHint::Quadrilateral => Symmetry::Quadrilateral,
        SymmetryHint::Bilateral => Symmetry::Bilateral(Mirror::Y),
        SymmetryHint::None => Symmetry::None,
    }
}
