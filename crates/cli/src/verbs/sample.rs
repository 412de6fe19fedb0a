//! `bsdf sample`: drawn scattered directions.

use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

use bsdfkit::{Bsdf, Components, DVec2, DVec3, Error, Part, Sample};
use bsdfkit_simulate::random::Random;
use bsdfkit_sphere::direction;
use clap::Args;
use serde_json::json;

use crate::files::load::{Reading, bsdf};
use crate::terminal::angles::Angles;
use crate::terminal::queries::{Notation, Queries};
use crate::terminal::stop::{Outcome, Verdict};

const EXAMPLES: &str = "\
Examples:
  bsdf sample fabric.xml --incident 30,0 -n 1000
  bsdf sample fabric.safetensors --incident 30,0 -n 5 --seed 7 --json
  echo 30 0 0.25 0.75 | bsdf sample fabric.xml --stdin --square";

/// Scattered directions drawn from a BSDF
///
/// Prints `theta phi weight pdf part` a row: degrees, f cos/pdf, 1/sr, and the number of the component
/// that it is of (or lambertian_reflection, lambertian_transmission; specular_N for the peak of no width N, whose pdf
/// is the probability of drawing it). Drawn values are stratified; the
/// same seed draws the same directions. Weights of a tree or a matrix are all the same; an interpolant
/// is drawn from by a table near it, and they vary.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML, interpolant, compiled BSDF or Radiance interpolant
    file: PathBuf,
    #[command(flatten)]
    reading: Reading,
    /// Incident direction in degrees, away from the surface
    #[arg(
        long,
        value_name = "THETA,PHI",
        allow_hyphen_values = true,
        required_unless_present = "stdin"
    )]
    incident: Option<Angles>,
    /// How many directions
    #[arg(short, long, value_name = "N", default_value_t = 1)]
    number: u32,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Read rows `theta phi u` from standard input and draw one direction by each u in 0-1; what scatters
    /// nothing gives `none`
    #[arg(long, conflicts_with_all = ["incident", "number", "seed"])]
    stdin: bool,
    /// Rows end with two numbers, points of the unit square, instead of one along the Hilbert curve
    #[arg(long, requires = "stdin")]
    square: bool,
    #[command(flatten)]
    notation: Notation,
    /// One JSON object a row
    #[arg(long)]
    json: bool,
}

/// Directions drawn between two looks at how standard output takes them.
const BLOCK: usize = 1 << 16;

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let bsdf = bsdf(&arguments.file, arguments.reading)?;
    match arguments.incident {
        Some(incident) => draw(arguments, &bsdf, incident.direction()),
        None if arguments.square => answer::<2>(arguments, &bsdf, |bsdf, wi, u, out| {
            let u: Vec<DVec2> = u.iter().map(|&u| u.into()).collect();
            bsdf.sample2_many(wi, &u, Components::ALL, out)
        }),
        None => answer::<1>(arguments, &bsdf, |bsdf, wi, u, out| {
            bsdf.sample_many(wi, u.as_flattened(), Components::ALL, out)
        }),
    }
}

/// Stratified directions of one incident one.
fn draw(arguments: &Arguments, bsdf: &Bsdf, wi: DVec3) -> Outcome {
    let mut random = Random::new(arguments.seed);
    let mut out = BufWriter::new(io::stdout().lock());
    let count = f64::from(arguments.number);
    let mut numbers = 0..arguments.number;
    loop {
        let u: Vec<f64> =
            numbers.by_ref().take(BLOCK).map(|k| (f64::from(k) + random.unit()) / count).collect();
        let mut samples = vec![None; u.len()];
        bsdf.sample_many(&[wi], &u, Components::ALL, &mut samples)?;
        // What scatters nothing has no directions to print.
        for sample in samples.iter().flatten() {
            writeln!(out, "{}", text(arguments, Some(sample)))?;
        }
        if numbers.is_empty() {
            out.flush()?;
            return Ok(Verdict::Good);
        }
    }
}

/// One direction for each row of standard input.
fn answer<const N: usize>(
    arguments: &Arguments,
    bsdf: &Bsdf,
    draw: impl Fn(&Bsdf, &[DVec3], &[[f64; N]], &mut [Option<Sample>]) -> bsdfkit::Result<()>,
) -> Outcome {
    let mut queries = Queries::<1, N>::new(arguments.notation);
    let mut out = io::stdout().lock();
    loop {
        let block = queries.block()?;
        if block.is_empty() {
            return Ok(Verdict::Good);
        }
        let (wi, u): (Vec<DVec3>, Vec<[f64; N]>) =
            block.into_iter().map(|([wi], u)| (wi, u)).unzip();
        if let Some(u) = u.as_flattened().iter().find(|u| !(0.0..=1.0).contains(*u)) {
            let text = format!("standard input: u: expected a number from 0 to 1, found {u}");
            return Err(Error::format(text).into());
        }
        let mut samples = vec![None; wi.len()];
        draw(bsdf, &wi, &u, &mut samples)?;
        for sample in &samples {
            writeln!(out, "{}", text(arguments, sample.as_ref()))?;
        }
        out.flush()?;
    }
}

fn text(arguments: &Arguments, sample: Option<&Sample>) -> String {
    let Some(&Sample { wo, weight, pdf, part }) = sample else {
        return if arguments.json { "null".into() } else { "none".into() };
    };
    let part = match part {
        Part::LambertianReflection => "lambertian_reflection".into(),
        Part::LambertianTransmission => "lambertian_transmission".into(),
        Part::Component(number) => number.to_string(),
        Part::Specular(number) => format!("specular_{number}"),
    };
    if arguments.json {
        let (theta, phi) = direction::to_degrees(wo);
        let row = json!({
            "theta_degrees": theta, "phi_degrees": phi, "wo": wo.to_array(), "weight": weight,
            "pdf": pdf, "part": part
        });
        return row.to_string();
    }
    let [weight, pdf] = [weight, pdf].map(|x| arguments.notation.number(x));
    format!("{} {weight} {pdf} {part}", arguments.notation.text(wo))
}
