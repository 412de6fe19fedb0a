//! `bsdf simulate`: measurements without an instrument.

use std::io::{self, Write};
use std::path::PathBuf;

use bsdfkit::{Error, Side};
use bsdfkit_represent::Progress;
use bsdfkit_simulate::{Goniophotometer, Material, every, write_measurements};
use clap::Args;
use serde_json::json;

use crate::terminal::progress::Bar;
use crate::terminal::stop::{Outcome, Verdict};
use crate::terminal::table::Table;

const EXAMPLES: &str = "\
Examples:
  bsdf simulate --list
  bsdf simulate fabric -o measurements
  bsdf simulate prism-film -o measurements --noise 0.02 --seed 7
  bsdf simulate rotated-metal -o front && bsdf simulate fabric --back-to-front -o back && bsdf fit front back -o both.xml";

/// Measure an analytic material with a virtual goniophotometer
///
/// Writes one Mountain file an incidence into DIR: sweeps over the hemisphere, spirals round the
/// peaks, a hole where the detector would stand in the light, nothing beyond the grazing limit.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Which material; see --list
    #[arg(required_unless_present = "list")]
    material: Option<String>,
    /// Folder for the files, new or empty
    #[arg(short, long, value_name = "DIR", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// List the materials
    #[arg(long)]
    list: bool,
    /// Between incident azimuths, degrees
    #[arg(long, value_name = "DEG")]
    azimuth_step: Option<f64>,
    /// Great circles that the detector moves on
    #[arg(long, value_name = "N")]
    sweeps: Option<usize>,
    /// Points on each great circle
    #[arg(long, value_name = "N")]
    points_per_sweep: Option<usize>,
    /// Points of the spiral round the brightest peak
    #[arg(long, value_name = "N")]
    spiral_points: Option<usize>,
    /// Standard deviation of the noise, as a fraction of the value
    #[arg(long, value_name = "FRACTION")]
    noise: Option<f64>,
    /// Standard deviation of the noise where there is no light, 1/sr
    #[arg(long, value_name = "F")]
    absolute_noise: Option<f64>,
    /// Radius of the hole around the light, degrees
    #[arg(long, value_name = "DEG")]
    retro_hole: Option<f64>,
    /// Largest scattered angle from the normal, degrees
    #[arg(long, value_name = "DEG")]
    grazing_limit: Option<f64>,
    /// Diameter of the cone that the detector sees at once, degrees: widens peaks that have no width
    #[arg(long, value_name = "DEG")]
    aperture: Option<f64>,
    /// The specimen is mounted back to front, turned about its up axis: its front is seen on the back
    #[arg(long)]
    back_to_front: bool,
    /// Same seed, same points and noise
    #[arg(long)]
    seed: Option<u64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Arguments {
    fn instrument(&self) -> Goniophotometer {
        let usual = Goniophotometer::default();
        Goniophotometer {
            azimuth_step_degrees: self.azimuth_step.unwrap_or(usual.azimuth_step_degrees),
            sweeps: self.sweeps.unwrap_or(usual.sweeps),
            points_per_sweep: self.points_per_sweep.unwrap_or(usual.points_per_sweep),
            spiral_points: self.spiral_points.unwrap_or(usual.spiral_points),
            relative_noise: self.noise.unwrap_or(usual.relative_noise),
            absolute_noise: self.absolute_noise.unwrap_or(usual.absolute_noise),
            retro_hole_degrees: self.retro_hole.unwrap_or(usual.retro_hole_degrees),
            grazing_limit_degrees: self.grazing_limit.unwrap_or(usual.grazing_limit_degrees),
            aperture_degrees: self.aperture.unwrap_or(usual.aperture_degrees),
            back_to_front: self.back_to_front,
            seed: self.seed.unwrap_or(usual.seed),
        }
    }
}

/// The material of that name.
///
/// Errors: argument, with the names there are.
pub(crate) fn material(name: &str) -> bsdfkit::Result<Box<dyn Material>> {
    let mut all = every();
    match all.iter().position(|m| m.name() == name) {
        Some(at) => Ok(all.swap_remove(at)),
        None => {
            let names: Vec<&str> = all.iter().map(|m| m.name()).collect();
            let names = names.join(", ");
            Err(Error::argument(format!("material: expected one of {names}, found {name:?}")))
        }
    }
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let mut out = io::stdout().lock();
    let (Some(name), Some(folder), false) =
        (&arguments.material, &arguments.output, arguments.list)
    else {
        return list(&mut out, arguments.json);
    };
    let material = material(name)?;
    let bar = Bar::new("incidences");
    let summary =
        write_measurements(folder, &*material, &arguments.instrument(), |done, total| {
            bar.report(Progress { done, total });
            Ok(())
        })?;
    drop(bar);
    let (files, points) = (summary.files.len(), summary.points);
    if arguments.json {
        let summary = json!({
            "material": name, "folder": folder.display().to_string(), "incidences": files, "points": points
        });
        writeln!(out, "{summary}")?;
    } else {
        writeln!(out, "{}: {name}, {files} incidences, {points} points", folder.display())?;
    }
    Ok(Verdict::Good)
}

fn list(out: &mut impl Write, as_json: bool) -> Outcome {
    let way = |m: &dyn Material| match m.scattered() {
        Side::Front => "reflection",
        Side::Back => "transmission",
    };
    if as_json {
        let materials: Vec<_> = every()
            .iter()
            .map(|m| {
                let (symmetry, scattering) = (m.symmetry().name(), way(&**m));
                json!({"name": m.name(), "scattering": scattering, "symmetry": symmetry})
            })
            .collect();
        writeln!(out, "{}", serde_json::Value::from(materials))?;
    } else {
        let mut table = Table::new(["material", "scattering", "symmetry"]);
        for m in every() {
            table.row([m.name().into(), way(&*m).into(), m.symmetry().name().into()]);
        }
        table.print(out, 0)?;
    }
    Ok(Verdict::Good)
}
