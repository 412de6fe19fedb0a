//! `bsdf sample`: drawn scattered directions.

use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

use bsdfkit::{Components, DVec2};
use bsdfkit_simulate::random::Random;
use bsdfkit_sphere::direction;
use clap::Args;
use serde_json::json;

use crate::angles::Angles;
use crate::load::{Reading, surface_read};
use crate::stop::{Outcome, Verdict};
use crate::surface::Surface;

const EXAMPLES: &str = "\
Examples:
  bsdf sample fabric.xml --incident 30,0 -n 1000
  bsdf sample fabric.safetensors --incident 30,0 -n 5 --seed 7 --json";

/// Scattered directions drawn from a BSDF
///
/// Prints `theta phi weight pdf` a row: degrees, f cos/pdf, 1/sr. Drawn values are stratified;
/// the same seed draws the same directions. An interpolant is drawn from by cells of 0.4 degrees.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML, interpolant, compiled BSDF or Radiance interpolant
    file: PathBuf,
    #[command(flatten)]
    reading: Reading,
    /// Incident direction in degrees, away from the surface
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true)]
    incident: Angles,
    /// How many directions
    #[arg(short, long, value_name = "N", default_value_t = 1)]
    number: u32,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// One JSON object a row
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let surface = surface_read(&arguments.file, arguments.reading)?;
    let wi = arguments.incident.direction();
    let drawn = match &surface {
        Surface::Stored(_) => None,
        Surface::Continuous(_) => Some(surface.drawn(wi)),
    };
    let mut random = Random::new(arguments.seed);
    let mut out = BufWriter::new(io::stdout().lock());
    for k in 0..arguments.number {
        let u = (f64::from(k) + random.unit()) / f64::from(arguments.number);
        let within = DVec2::new(random.unit(), random.unit());
        let sample = match (&surface, &drawn) {
            (Surface::Stored(bsdf), _) => {
                bsdf.sample(wi, u, Components::ALL).map(|s| (s.wo, s.weight, s.pdf))
            }
            (_, Some(drawn)) => drawn.sample(u, within),
            _ => None,
        };
        // What scatters nothing has no directions to print.
        let Some((wo, weight, pdf)) = sample else { break };
        let (theta, phi) = direction::to_degrees(wo);
        if arguments.json {
            let row = json!({
                "theta_degrees": theta, "phi_degrees": phi, "weight": weight, "pdf": pdf
            });
            writeln!(out, "{row}")?;
        } else {
            writeln!(out, "{theta:.6} {phi:.6} {weight:.8e} {pdf:.8e}")?;
        }
    }
    out.flush()?;
    Ok(Verdict::Good)
}
