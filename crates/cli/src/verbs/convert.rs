//! `bsdf convert`: from any form to any other that holds no more than it.

use std::io::{self, Write};
use std::path::PathBuf;

use bsdfkit::spectrum::View;
use bsdfkit::{Bsdf, Error};
use bsdfkit_fit::deliver::{Consumer, Kind, alone};
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
  bsdf convert paint.safetensors --each-band --max-leaves 20000 -o paint.xml
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
    /// A file a wavelength of a spectral measurement's interpolant, for programs that take one at a time: OUT with 450nm at
    /// the end of its name, and so on
    #[arg(long, conflicts_with_all = ["view", "band"])]
    each_band: bool,
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
    let jobs = match arguments.each_band {
        true => each_band(&input.surface, &targets, &arguments.tabulation)?,
        false => targets.iter().map(|t| (t.clone(), arguments.tabulation.clone())).collect(),
    };
    for (target, tabulation) in &jobs {
        let written = output::write(target, &input.surface, &metadata, tabulation)?;
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

/// Every target once a wavelength.
///
/// Errors: argument, without wavelengths, and for forms that keep all of them.
fn each_band(
    surface: &Surface,
    targets: &[Target],
    tabulation: &Tabulation,
) -> bsdfkit::Result<Vec<(Target, Tabulation)>> {
    let bands = match surface {
        Surface::Continuous(interpolant) => interpolant.bands(),
        Surface::Stored(_) => None,
    };
    let bands = bands.ok_or_else(|| {
        Error::argument(
            "--each-band: expected the interpolant of a spectral measurement, found no bands",
        )
    })?;
    let mut jobs = Vec::new();
    for target in targets {
        if target.kind == Kind::Interpolant || target.kind.channels().is_some() {
            let text = format!(
                "--each-band: expected a form of one band (a tree, a matrix, the render form), found {}, which keeps all",
                target.kind.name()
            );
            return Err(Error::argument(text).context(target.path.display()));
        }
        let stem = target.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let suffix = target.path.extension().unwrap_or_default().to_string_lossy().into_owned();
        for w in bands.nanometres() {
            let mut one = target.clone();
            one.path.set_file_name(format!("{stem}_{w}nm.{suffix}"));
            jobs.push((one, tabulation.seen_as(View::Wavelength(*w))));
        }
    }
    Ok(jobs)
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
