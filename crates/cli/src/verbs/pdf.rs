//! `bsdf pdf`: how densely samples are drawn.

use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

use bsdfkit::{Components, DVec3};
use clap::Args;

use crate::files::load::{Reading, bsdf};
use crate::terminal::queries::{Notation, Queries};
use crate::terminal::stop::{Outcome, Verdict};

const EXAMPLES: &str = "\
Examples:
  echo 30 0 30 180 | bsdf pdf fabric.xml
  bsdf pdf fabric.safetensors --vectors < rows.txt";

/// Density with which `bsdf sample` draws directions
///
/// Reads rows `theta_i phi_i theta_o phi_o` in degrees, as `bsdf eval` does; prints the density of
/// the scattered direction in 1/sr of solid angle, one row for each.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML, interpolant, compiled BSDF or Radiance interpolant
    file: PathBuf,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    notation: Notation,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let bsdf = bsdf(&arguments.file, arguments.reading)?;
    let mut queries = Queries::<2>::new(arguments.notation);
    let mut out = BufWriter::new(io::stdout().lock());
    loop {
        let block = queries.block()?;
        if block.is_empty() {
            return Ok(Verdict::Good);
        }
        let [wi, wo] = [0, 1].map(|k| block.iter().map(|q| q.0[k]).collect::<Vec<DVec3>>());
        let mut densities = vec![0.0; block.len()];
        bsdf.pdf_many(&wi, &wo, Components::ALL, &mut densities)?;
        for density in densities {
            writeln!(out, "{}", arguments.notation.number(density))?;
        }
        out.flush()?;
    }
}
