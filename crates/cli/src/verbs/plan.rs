//! `bsdf plan`: what to measure next.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bsdfkit::{DVec3, Error, Result, Side};
use bsdfkit_fit::interpolant::FitSettings;
use bsdfkit_fit::interpolant::build;
use bsdfkit_fit::survey::{Limits, Proposal, ScanRegion, begin, next};
use bsdfkit_measure::{Measurement, ReadOptions, Symmetry, SymmetryKind};
use bsdfkit_represent::{Progress, Watch};
use bsdfkit_sphere::direction::to_degrees;
use clap::Args;
use serde_json::{Value, json};

use crate::files::component::name;
use crate::files::instrument::{Instrument, beside_peaks};
use crate::files::surface::SIDES;
use crate::files::target::expect_writable;
use crate::terminal::progress::Bar;
use crate::terminal::stop::{Outcome, Verdict, remark};

const EXAMPLES: &str = "\
Examples:
  bsdf plan --symmetry quadrilateral --max-theta 75 --budget 8
  bsdf plan --symmetry bilateral-y --transmission --max-theta 75 --budget 12
  bsdf plan measurements/ --budget 8
  bsdf plan measurements/ --budget 12 --max-theta 80 --spacing 3 --json next.json

Without files, the directions to begin with, theta phi in degrees, most useful first. With files, each
line is an incident direction to measure next, most useful first: theta phi in degrees; behind #, the L1 to expect there now, and the L1 of all incident light together once all down to this line are
measured. Lines with 'scan' follow it: theta phi radius of regions to scan densely, round the peaks to
expect.";

/// Propose the next incident directions to measure
///
/// Leaves out every incidence to see how errors grow with the spacing, then places new ones so that
/// together they take away most of the error to expect. Begin without files; measure what is
/// proposed, and ask again with a budget of as many as there are: doubling wastes least. With --aperture or --signature the
/// error is that of what lies beside the peaks of no width.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Files and folders of one specimen; none to begin with, given --symmetry and --max-theta
    #[arg(value_name = "PATH")]
    paths: Vec<PathBuf>,
    /// How many incident directions to propose, for each side that was lit; to begin with 3 for an
    /// isotropic specimen, about 4 for each quarter of the hemisphere for others
    #[arg(long, value_name = "N", default_value_t = 6,
          value_parser = clap::value_parser!(u16).range(1..=1000))]
    budget: u16,
    /// Largest incident angle from the normal that the instrument reaches
    /// [default: the largest measured]
    #[arg(long, value_name = "DEG")]
    max_theta: Option<f64>,
    /// Least distance between incident directions
    #[arg(long, value_name = "DEG", default_value_t = 4.0)]
    spacing: f64,
    /// Write the proposals as JSON, too
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// isotropic, quadrilateral, bilateral, bilateral-x, bilateral-y, rotational180 or none
    /// [default: what the incidences show]
    #[arg(long, value_name = "S")]
    symmetry: Option<SymmetryKind>,
    /// To begin with: only transmitted light is to be measured. Directions are then spread evenly over the disk; for reflected
    /// light they lie denser toward grazing
    #[arg(long, conflicts_with = "paths")]
    transmission: bool,
    #[command(flatten)]
    instrument: Instrument,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    if let Some(path) = &arguments.json {
        expect_writable(path)?;
    }
    if arguments.paths.is_empty() {
        return first(arguments);
    }
    let options = ReadOptions { symmetry: arguments.symmetry, ..ReadOptions::default() };
    let measurements = bsdfkit_measure::read(&arguments.paths, &options)?;
    let budget = usize::from(arguments.budget);
    let all = proposals(arguments, measurements)?;
    if let Some(path) = &arguments.json {
        write_json(path, &all)?;
    }
    let mut out = BufWriter::new(io::stdout().lock());
    for (side, proposals) in &all {
        if all.len() > 1 {
            writeln!(out, "# {} side", if *side == Side::Front { "front" } else { "back" })?;
        }
        proposals.iter().try_for_each(|p| print(&mut out, p))?;
        note_room(budget, proposals.len());
    }
    out.flush()?;
    Ok(Verdict::Good)
}

/// Directions to begin with.
fn first(arguments: &Arguments) -> Outcome {
    let (Some(kind), Some(max_theta_degrees)) = (arguments.symmetry, arguments.max_theta) else {
        let text = "expected files, or --symmetry and --max-theta to begin with, found neither";
        return Err(Error::argument(text).into());
    };
    let limits = Limits { max_theta_degrees, spacing_degrees: arguments.spacing };
    let budget = usize::from(arguments.budget);
    let scattered = if arguments.transmission { Side::Back } else { Side::Front };
    let directions = begin(settled(kind)?, scattered, &limits, budget, &Watch::default())?;
    if let Some(path) = &arguments.json {
        let one = |&wi: &DVec3| {
            let (theta, phi) = angles(wi);
            json!({"theta_degrees": theta, "phi_degrees": phi})
        };
        write_list(path, &directions.iter().map(one).collect::<Vec<_>>())?;
    }
    let mut out = BufWriter::new(io::stdout().lock());
    for &wi in &directions {
        let (theta, phi) = angles(wi);
        writeln!(out, "{theta:.2} {phi:.2}")?;
    }
    out.flush()?;
    note_room(budget, directions.len());
    Ok(Verdict::Good)
}

/// The symmetry that was named, if the name tells which.
fn settled(kind: SymmetryKind) -> Result<Symmetry> {
    Ok(match kind {
        SymmetryKind::Isotropic => Symmetry::Isotropic,
        SymmetryKind::Quadrilateral => Symmetry::Quadrilateral,
        SymmetryKind::Bilateral(Some(mirror)) => Symmetry::Bilateral(mirror),
        SymmetryKind::Bilateral(None) => {
            let text =
                "symmetry: expected bilateral-x or bilateral-y to begin with, found bilateral";
            return Err(Error::argument(text));
        }
        SymmetryKind::Rotational180 => Symmetry::Rotational180,
        SymmetryKind::None => Symmetry::None,
    })
}

fn note_room(asked: usize, found: usize) {
    if found < asked {
        remark("note", &[format!("room for {found} of {asked} directions at this spacing")]);
    }
}

/// For each side that was lit.
fn proposals(
    arguments: &Arguments,
    measurements: Vec<Measurement>,
) -> Result<Vec<(Side, Vec<Proposal>)>> {
    let signature = arguments.instrument.signature()?;
    let mut measured = Vec::new();
    for m in measurements {
        remark("note", &m.notes);
        let place = name(m.incident, m.scattered);
        m.expect_enough().map_err(|e| e.context(&place))?;
        let (m, peaks) = beside_peaks(m, signature.as_ref()).map_err(|e| e.context(&place))?;
        remark("note", &peaks);
        let bar = Bar::new(format!("{place}: fit"));
        let report = |progress: Progress| bar.report(progress);
        let watch = Watch { progress: Some(&report), cancel: None };
        let component =
            build(&m, &FitSettings::default(), &watch).map_err(|e| e.context(&place))?;
        measured.push((Arc::new(component), m));
    }
    let bar = Bar::new("proposals");
    let report = |progress: Progress| bar.report(progress);
    let watch = Watch { progress: Some(&report), cancel: None };
    let (reach, spacing) = (arguments.max_theta, arguments.spacing);
    let found = next(&measured, reach, spacing, arguments.budget.into(), &watch)?;
    let lit = SIDES.into_iter().filter(|&side| measured.iter().any(|(_, m)| m.incident == side));
    let of = |side| found.iter().filter(|p| Side::of(p.wi) == side).cloned().collect();
    Ok(lit.map(|side| (side, of(side))).collect())
}

/// θ, and φ within 0–360 where it has a meaning.
fn angles(w: DVec3) -> (f64, f64) {
    let (theta, phi) = to_degrees(w);
    let axial = w.truncate().length() < 1e-9;
    (theta, if axial { 0.0 } else { phi.rem_euclid(360.0) })
}

fn print(out: &mut impl Write, p: &Proposal) -> io::Result<()> {
    let (theta, phi) = angles(p.wi);
    writeln!(out, "{theta:.2} {phi:.2}  # L1 {:.4} here, {:.4} after", p.expected_l1, p.mean_l1)?;
    for ScanRegion { direction, radius_degrees } in &p.regions {
        let (theta, phi) = angles(*direction);
        writeln!(out, "  scan {theta:.2} {phi:.2} {radius_degrees:.1}")?;
    }
    Ok(())
}

fn write_json(path: &Path, all: &[(Side, Vec<Proposal>)]) -> Result<()> {
    let region = |r: &ScanRegion| {
        let (theta, phi) = angles(r.direction);
        json!({"theta_degrees": theta, "phi_degrees": phi, "radius_degrees": r.radius_degrees})
    };
    let proposal = |p: &Proposal| {
        let (theta, phi) = angles(p.wi);
        json!({
            "theta_degrees": theta, "phi_degrees": phi, "expected_l1": p.expected_l1,
            "mean_l1_after": p.mean_l1, "scan": p.regions.iter().map(region).collect::<Vec<_>>()
        })
    };
    let list: Vec<Value> = all.iter().flat_map(|(_, p)| p.iter().map(proposal)).collect();
    write_list(path, &list)
}

fn write_list(path: &Path, list: &[Value]) -> Result<()> {
    let text = json!({"incidences": list});
    bsdfkit::replace_file(path, |out| {
        writeln!(out, "{text:#}").map_err(|e| Error::io("writing", &e))
    })
}
