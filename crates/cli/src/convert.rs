//! `bsdf convert`: from any form to any other that holds no more than it.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;

use crate::load::load_all;
use crate::output::{self, Labels, Tabulation, Targets};
use crate::stop::{Outcome, Verdict, remark};

const EXAMPLES: &str = "\
Examples:
  bsdf convert fabric.safetensors -o fabric.xml --to klems-full -o fabric_klems.xml
  bsdf convert front_refl.sir front_trans.sir -o glass.xml
  bsdf convert window.xml --to tensor-tree -o window_tree.xml";

/// Convert interpolants, trees and matrices
///
/// Several inputs are Radiance interpolants, one a component. Components that already have the form
/// asked for are copied value by value; others are averaged over the new cells, in luminance.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML, interpolant, compiled BSDF or Radiance interpolants
    #[arg(required = true, value_name = "IN")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    targets: Targets,
    #[command(flatten)]
    tabulation: Tabulation,
    #[command(flatten)]
    labels: Labels,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let input = load_all(&arguments.files)?;
    remark("warning", &input.warnings);
    let metadata = arguments.labels.over(input.metadata())?;
    arguments.targets.expect_writable()?;
    let mut out = io::stdout().lock();
    for target in &arguments.targets.0 {
        let written = output::write(target, &input.surface, &metadata, &arguments.tabulation)?;
        if written.loses_colour {
            remark("note", &[format!("{}: luminance only", target.path.display())]);
        }
        if arguments.json {
            writeln!(out, "{}", written.json(target))?;
        } else {
            writeln!(out, "{}", written.line(target))?;
        }
    }
    Ok(Verdict::Good)
}
