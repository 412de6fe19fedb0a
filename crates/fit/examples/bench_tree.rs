//! What trees of several sizes make of an interpolant: size against L1 and the error of energy.
//!
//!     bsdf simulate brushed-metal -o measured && bsdf fit measured -o brushed-metal.safetensors
//!     cargo run --release -p bsdfkit-fit --example bench_tree -- [--leaves N,N,…] [--depth N] FILE.safetensors ...
//!
//! A row a tree: its values, MB in XML and seconds; then, of stored values and of smooth lookup, against the interpolant that it
//! was made of: L1 over the scattered hemisphere, mean over incidences from 5 to 70 degrees and, apart, at 80 and 85; and of the
//! directional-hemispherical value from 0 to 80 degrees the root mean square of the difference and the largest. `default` is the
//! tree that is made unless something else is asked for.

use std::path::Path;
use std::time::Instant;

use bsdfkit::{Bsdf, Components, DVec3, Lambertian, Lookup, Metadata, Side};
use bsdfkit_fit::interpolant::{Interpolant, Part};
use bsdfkit_represent::Source;
use bsdfkit_represent::Watch;
use bsdfkit_represent::tabulate::{Form, Report, TreeReport, TreeSettings, component};
use bsdfkit_sphere::concentric::square_to_hemisphere;
use bsdfkit_sphere::direction::from_degrees;
use bsdfkit_sphere::sequence::plastic;

/// Scattered directions at which values are compared.
const COMPARED: usize = 40_000;

fn main() {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    let mut option = |name: &str| {
        let at = words.iter().position(|w| w == name)?;
        words.remove(at);
        Some(words.remove(at))
    };
    let depth = option("--depth").map(|n| n.parse::<u32>().expect("a number"));
    let sizes = option("--leaves")
        .map(|list| list.split(',').map(|n| Some(n.parse::<usize>().expect("a number"))).collect());
    let sizes: Vec<Option<usize>> = sizes.unwrap_or_else(|| vec![None]);
    println!(
        "{:<20} {:>9} {:>7} {:>6} | {:^28} | {:^28}",
        "", "values", "MB", "s", "stored: L1 85 dhr max", "smooth: L1 85 dhr max"
    );
    for file in &words {
        let interpolant = Interpolant::open(Path::new(file)).expect("an interpolant");
        let name = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        for part in &interpolant.components {
            let truth = Truth::of(part);
            for size in &sizes {
                let settings =
                    TreeSettings { max_leaves: *size, max_depth: depth, ..TreeSettings::default() };
                row(&name, part, &truth, settings);
            }
        }
    }
}

fn row(name: &str, part: &Part, truth: &Truth, settings: TreeSettings) {
    let start = Instant::now();
    let made = component(part, &Form::Tree(settings), &Watch::default()).expect("a tree");
    let seconds = start.elapsed().as_secs_f64();
    let Report::Tree(TreeReport { leaves, bytes, .. }) = made.report else { panic!("a tree") };
    let of = |lookup| {
        let components = vec![made.component.clone()];
        let bsdf = Bsdf::new(Metadata::default(), components, Lambertian::default());
        truth.errors(&bsdf.with_lookup(lookup).expect("a lookup"))
    };
    let shown =
        |[l1, grazing, rms, most]: [f64; 4]| format!("{l1:.4} {grazing:.4} {rms:.4} {most:.4}");
    println!(
        "{name:<20} {leaves:>9} {:>7.2} {seconds:>6.1} | {:^28} | {:^28}",
        bytes / 1e6,
        shown(of(Lookup::Stored)),
        shown(of(Lookup::Smooth)),
    );
}

/// What the interpolant says.
struct Truth {
    /// Scattered directions, even in projected solid angle.
    wo: Vec<DVec3>,
    /// Incident directions, whether they are grazing, and values.
    slices: Vec<(DVec3, bool, Vec<f32>)>,
    /// Incident directions and directional-hemispherical values.
    energies: Vec<(DVec3, f64)>,
}

impl Truth {
    fn of(part: &Part) -> Self {
        let azimuths: &[f64] = if part.isotropic() {
            &[37.0]
        } else {
            &[0.0, 37.0, 90.0, 143.0, 180.0, 251.0, 270.0, 322.0]
        };
        let side = |w: DVec3, side: Side| DVec3::new(w.x, w.y, side.sign() * w.z.abs());
        let wo: Vec<DVec3> =
            (1..=COMPARED).map(|k| square_to_hemisphere(plastic(k), part.scattered())).collect();
        let mut slices = Vec::new();
        for theta in [5.0, 15.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 85.0] {
            for azimuth in azimuths.iter().step_by(2) {
                let wi = side(from_degrees(theta, azimuth + 0.7 * theta), part.incident());
                let mut values = vec![0.0f32; wo.len() * part.channels()];
                part.slice(wi).eval(&wo, &mut values);
                let luminance = values.iter().step_by(part.channels()).copied().collect();
                slices.push((wi, theta > 75.0, luminance));
            }
        }
        let bsdf = Interpolant { components: vec![part.clone()], ..Interpolant::default() }.bsdf();
        let mut energies = Vec::new();
        for k in 0..=32 {
            for azimuth in azimuths {
                let wi = side(from_degrees(2.5 * f64::from(k), *azimuth), part.incident());
                energies.push((wi, bsdf.directional_hemispherical(wi, Components::ALL)));
            }
        }
        Self { wo, slices, energies }
    }

    /// L1, of grazing incidences, root mean square difference of the hemispherical value, the largest.
    fn errors(&self, bsdf: &Bsdf) -> [f64; 4] {
        let l1 = |grazing: bool| {
            let of = self.slices.iter().filter(|s| s.1 == grazing).map(|(wi, _, values)| {
                let (mut off, mut all) = (0.0, 0.0);
                for (wo, truth) in self.wo.iter().zip(values) {
                    let truth = f64::from(truth.max(0.0));
                    off += (bsdf.eval(*wi, *wo) - truth).abs();
                    all += truth;
                }
                off / all.max(1e-12)
            });
            let all: Vec<f64> = of.collect();
            all.iter().sum::<f64>() / all.len() as f64
        };
        let off = self.energies.iter().map(|(wi, truth)| {
            (bsdf.directional_hemispherical(*wi, Components::ALL) - truth).abs()
        });
        let off: Vec<f64> = off.collect();
        let square = off.iter().map(|e| e * e).sum::<f64>() / off.len() as f64;
        [l1(false), l1(true), square.sqrt(), off.iter().copied().fold(0.0, f64::max)]
    }
}
