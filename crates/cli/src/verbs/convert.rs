//! `bsdf convert`: from any form to any other that holds no more than it.

use std::io::{self, Write};
use std::path::PathBuf;

use bsdfkit::{Bsdf, Error};
use bsdfkit_fit::deliver::{Consumer, alone};
use clap::Args;

use crate::files::component;
use crate::files::labels::Labels;
use crate::files::load::load_all;
use crate::files::output::{self, placeholders};
use crate::files::surface::Surface;
use crate::files::tabulation::Tabulation;
use crate::files::target::{Target, Targets};
use crate::terminal::stop::{Outcome, Verdict, remark};

const EXAMPLES: &str = "\
Examples:
  bsdf convert fabric.safetensors -o fabric.xml --to klems-full -o fabric_klems.xml
  bsdf convert front_refl.sir front_trans.sir -o glass.xml
  bsdf convert window.xml --to tensor-tree -o window_tree.xml
  bsdf convert shade.xml --extract-peaks -o shade_peaks.xml
  bsdf convert fabric.xml --for window -o fabric_w.xml --name 'Fabric 3' --thickness 0.0004";

/// Convert interpolants, trees and matrices
///
/// Several inputs are Radiance interpolants, one a component. Components that already have the form
/// asked for are copied value by value; others are averaged over the new cells, in luminance. Further
/// bands (Solar, NIR, …) are converted alike.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML, interpolant, compiled BSDF, Radiance interpolants, or tables of RGL, MERL or Zemax
    #[arg(required = true, value_name = "IN")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    targets: Targets,
    #[command(flatten)]
    tabulation: Tabulation,
    #[command(flatten)]
    labels: Labels,
    /// This further band alone, in the place of Visible
    #[arg(long, value_name = "NAME")]
    band: Option<String>,
    /// Take peaks of no width out of narrow cells: mirror-like ones, straight through, back to the light
    #[arg(long)]
    extract_peaks: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let mut input = load_all(&arguments.files)?;
    input.warn(&arguments.files[0]);
    if let Some(band) = &arguments.band {
        let place = |e: bsdfkit::Error| e.context(arguments.files[0].display());
        let both = |t: &&Target| t.consumer.is_some_and(|c| c != Consumer::Radiance);
        if let Some(consumer) = arguments.targets.0.iter().find(both).and_then(|t| t.consumer) {
            let text = format!(
                "--band {band}: expected without --for {}, which reads Visible and Solar both",
                consumer.name()
            );
            return Err(bsdfkit::Error::argument(text).into());
        }
        let alone = alone(input.surface.subject(), band).map_err(place)?;
        input.surface = Surface::Stored(alone.into());
    }
    if arguments.extract_peaks {
        input.surface = Surface::Stored(extracted(&input.surface)?.into());
    }
    let metadata = arguments.labels.over(input.metadata())?;
    arguments.targets.expect_writable()?;
    let mut out = io::stdout().lock();
    let targets = arguments.targets.settled(&input.surface);
    for target in &targets {
        let written = output::write(target, &input.surface, &metadata, &arguments.tabulation)?;
        written.remark(target);
        if arguments.json {
            writeln!(out, "{}", written.json(target))?;
        } else {
            writeln!(out, "{}", written.line(target))?;
        }
    }
    remark("note", placeholders(&metadata, &targets).as_slice());
    Ok(Verdict::Good)
}

/// A stored BSDF with its peaks taken out of their cells; which they are is said.
fn extracted(surface: &Surface) -> bsdfkit::Result<Bsdf> {
    let Surface::Stored(bsdf) = surface else {
        return Err(Error::argument(
            "--extract-peaks: expected a tree or a matrix, found an interpolant: `fit --aperture` separates its peaks",
        ));
    };
    let extracted = bsdf.with_peaks_extracted()?;
    let found = extracted.specular().iter().map(component::peak);
    let mut said: Vec<String> = found.collect();
    if said.is_empty() {
        said.push("no peaks of no width found".to_owned());
    }
    remark("note", &said);
    Ok(extracted)
}
