//! `bsdf compile`: a BSDF that opens without parsing.

use std::io::{self, Write};
use std::path::PathBuf;

use bsdfkit::{Error, container};
use clap::Args;

use crate::files::load::load;
use crate::files::surface::Surface;
use crate::files::target::expect_writable;
use crate::terminal::stop::{Outcome, Verdict, remark};

const EXAMPLES: &str = "\
Examples:
  bsdf compile fabric.xml -o fabric_compiled.safetensors";

/// Compile a tree or matrix into a file that opens in milliseconds
///
/// Same values, colour included, as named arrays in a safetensors file.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML or compiled BSDF
    file: PathBuf,
    /// File to write, *.safetensors
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let (file, path) = (&arguments.file, &arguments.output);
    if path.extension().is_none_or(|s| s != "safetensors") {
        let text = "expected a name ending in .safetensors";
        return Err(Error::argument(text).context(path.display()).into());
    }
    let input = load(file)?;
    input.warn(&arguments.file);
    let Surface::Stored(bsdf) = &input.surface else {
        let text =
            "expected a tree or a matrix, found an interpolant: `bsdf convert` makes one of it";
        return Err(Error::argument(text).context(file.display()).into());
    };
    let bands: Vec<&str> = bsdf.bands().iter().map(|b| b.name.as_str()).collect();
    if !bands.is_empty() {
        let bands = bands.join(", ");
        let text = format!("left out: band {bands}; `bsdf convert --band` makes a file of one");
        remark("note", &[format!("{}: {text}", path.display())]);
    }
    expect_writable(path)?;
    container::save(bsdf, path)?;
    writeln!(io::stdout(), "{}: {} components", path.display(), bsdf.components().len())?;
    Ok(Verdict::Good)
}
