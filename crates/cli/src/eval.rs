//! `bsdf eval`: values at rows of directions.

use std::io::{self, Write};
use std::path::PathBuf;

use bsdfkit::{DVec3, Xyz};
use clap::Args;
use rayon::prelude::*;

use crate::angles::Angles;
use crate::load::{Reading, surface_read};
use crate::rows::Rows;
use crate::stop::{Outcome, Verdict};
use crate::surface::Surface;

const EXAMPLES: &str = "\
Examples:
  echo 30 0 30 180 | bsdf eval fabric.xml
  bsdf eval fabric.safetensors < rows.txt > values.txt
  bsdf eval --channels glass.xml < rows.txt
  bsdf eval --smooth fabric.xml < rows.txt";

/// Values of a BSDF at rows of directions
///
/// Reads rows `theta_i phi_i theta_o phi_o` in degrees: both directions point away from the
/// surface, theta 0-180 from the front normal (+Z), phi from +X toward +Y. Prints f in 1/sr,
/// without cosine, one row for each. Lines that begin with # are passed over.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML, interpolant, compiled BSDF or Radiance interpolant
    file: PathBuf,
    #[command(flatten)]
    reading: Reading,
    /// Print X, Y and Z instead of the luminance
    #[arg(long)]
    channels: bool,
}

/// Rows answered by one task: a hundred times the cost of handing it out.
const TASK: usize = 512;

/// A row's directions.
type Pair = (DVec3, DVec3);

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let surface = surface_read(&arguments.file, arguments.reading)?;
    let mut rows = Rows::<4>::new(io::stdin());
    let mut out = io::stdout().lock();
    loop {
        let block = rows.block()?;
        if block.is_empty() {
            return Ok(Verdict::Good);
        }
        let pairs: Vec<Pair> = block
            .iter()
            .map(|&(line, [theta_i, phi_i, theta_o, phi_o])| {
                let wi = Angles::new(theta_i, phi_i).map(Angles::direction);
                let wo = Angles::new(theta_o, phi_o).map(Angles::direction);
                wi.and_then(|wi| Ok((wi, wo?))).map_err(|e| {
                    let row = format!("standard input: line {line}");
                    bsdfkit::Error::format(e.to_string()).context(row)
                })
            })
            .collect::<bsdfkit::Result<_>>()?;
        let texts: Vec<String> = pairs
            .par_chunks(TASK)
            .map(|pairs| text(&answers(&surface, pairs), arguments.channels))
            .collect();
        for text in texts {
            out.write_all(text.as_bytes())?;
        }
        out.flush()?;
    }
}

/// Values of the pairs; a run of one incident direction shares its slice.
fn answers(surface: &Surface, pairs: &[Pair]) -> Vec<Xyz> {
    let mut values = Vec::with_capacity(pairs.len());
    for run in pairs.chunk_by(|a, b| a.0 == b.0) {
        let wo: Vec<DVec3> = run.iter().map(|p| p.1).collect();
        surface.eval(run[0].0, &wo, &mut values);
    }
    values
}

/// One line a value, in nine significant digits: every bit of an f32.
fn text(values: &[Xyz], channels: bool) -> String {
    use std::fmt::Write;
    let mut text = String::with_capacity(16 * values.len());
    for v in values {
        let written = match channels {
            true => writeln!(text, "{:.8e} {:.8e} {:.8e}", v.x, v.y, v.z),
            false => writeln!(text, "{:.8e}", v.y),
        };
        written.expect("a string takes everything");
    }
    text
}
