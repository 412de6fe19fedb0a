//! `bsdf check`: whether a file can be trusted, and by which program.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use bsdfkit::xml::doctor::{self, Examination, Program};
use bsdfkit::xml::{self, Limits};
use bsdfkit::{Bsdf, DVec2, DVec3, ErrorClass, Side, reciprocity};
use bsdfkit_fit::open::Content;
use bsdfkit_represent::tabulate::disagreement;
use bsdfkit_sphere::concentric::square_to_hemisphere;
use clap::Args;
use clap::builder::PossibleValuesParser;

use crate::files::component::name;
use crate::files::load::{load, measure};
use crate::files::surface::Surface;
use crate::terminal::stop::{Outcome, Stop, Verdict, complain};

mod fix;
mod measured;
mod report;

use report::{Energy, Report};

const EXAMPLES: &str = "\
Examples:
  bsdf check material.xml
  bsdf check measurements/ material.safetensors material.xml --json
  bsdf check shade.xml --for window
  bsdf check shade.xml --for window --fix -o shade_window.xml";

/// Check structure, energy, reciprocity, negative values and coverage; say which program each finding breaks
///
/// The verdict is negative (exit status 1) where an incidence scatters more light than it gets, a
/// value is negative or not finite, or a measurement lacks what its symmetry needs or a lobe does; with --for
/// also where that program refuses the file or answers wrongly for it. Reciprocity,
/// what too little was seen of and whatever the reader remarked are reported. A file that cannot be read ends with its own
/// status after the others were checked.
///
/// With --fix the verdict is that of the corrected copy. The findings, by their codes: docs/guide/check.md.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML, interpolants, compiled BSDFs, measurements
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Only what matters to this program: radiance, window, energyplus, frads, honeybee or mitsuba
    #[arg(long = "for", value_name = "PROGRAM")]
    program: Option<Program>,
    /// Write a corrected copy of an XML file to --output, and say what was changed; with --for also what that program lacks
    #[arg(long, requires = "output")]
    fix: bool,
    /// Where the corrected copy goes
    #[arg(short, long, value_name = "OUT", requires = "fix")]
    output: Option<PathBuf>,
    /// Mend this, too, though it may be meant
    #[arg(long, value_name = "CODE", requires = "fix", value_parser = PossibleValuesParser::new(askable()))]
    also: Vec<String>,
    /// One JSON object a file
    #[arg(long)]
    json: bool,
}

/// The codes that are mended where they are asked for.
fn askable() -> Vec<&'static str> {
    let asked = doctor::KINDS.iter().filter(|k| matches!(k.mends, doctor::Mends::Asked(_)));
    asked.map(|k| k.code).collect()
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let mut out = io::stdout().lock();
    if let (true, Some(output)) = (arguments.fix, &arguments.output) {
        return fix::run(arguments, output, &mut out);
    }
    let (mut verdict, mut unreadable) = (Verdict::Good, None);
    for file in &arguments.files {
        let found = examine(file).map(|report| report.judged(arguments.program));
        let error = match found {
            Ok(mut report) => {
                if arguments.json {
                    writeln!(out, "{}", report.json(file))?;
                } else {
                    report.print(&mut out, file)?;
                }
                if !report.is_good() {
                    verdict = Verdict::Bad;
                }
                report.error.take()
            }
            Err(error) => Some(error),
        };
        if let Some(error) = error
            && let Some(earlier) = unreadable.replace(error)
        {
            complain(&earlier);
        }
    }
    unreadable.map_or(Ok(verdict), |error| Err(Stop::Error(error)))
}

fn examine(file: &Path) -> bsdfkit::Result<Report> {
    match Content::of(file) {
        Ok(Content::Measurement) => {}
        // What is no XML but another format the doctor names.
        Ok(Content::Xml) => return examine_xml(file),
        Err(e) if e.class() == ErrorClass::Format => return examine_xml(file),
        Err(e) => return Err(e),
        Ok(_) => return Ok(examine_surface(&load(file)?.surface)),
    }
    let mut found = Report::default();
    let paths = [file.to_owned()];
    if let Err(lacking) = measure(&paths, false) {
        found.faults.push(lacking.to_string());
    }
    for m in measure(&paths, true)? {
        measured::examine_measurement(&m, &mut found);
    }
    Ok(found)
}

/// A file of our XML, or what is called one.
fn examine_xml(file: &Path) -> bsdfkit::Result<Report> {
    let limits = Limits::default();
    let bytes = xml::bytes_of(file, &limits)?;
    Ok(of_examination(doctor::examine(&bytes, &limits), file))
}

fn of_examination(examination: Examination, file: &Path) -> Report {
    let Examination { findings, bsdf, error } = examination;
    let mut found =
        bsdf.map(|bsdf| examine_surface(&Surface::Stored(bsdf.into()))).unwrap_or_default();
    found.findings = findings;
    found.error = error.map(|e| e.context(file.display()));
    found
}

fn examine_surface(surface: &Surface) -> Report {
    let mut found = Report::default();
    let bsdf = surface.bsdf();
    if surface.pairs().is_empty() {
        found.remarks.push("nothing scatters".into());
    }
    for side in surface.incident_sides() {
        if let Some(most) = doctor::largest_total(&bsdf, side) {
            let place = if side == Side::Front { "front" } else { "back" };
            found.energy.push(Energy {
                place: place.to_owned(),
                total: most.total,
                wi: most.wi,
                extrapolated: false,
            });
        }
    }
    for (incident, scattered) in surface.pairs() {
        let defect = match surface {
            Surface::Stored(bsdf) => reciprocity::defect(bsdf, incident, scattered, 4096),
            Surface::Continuous(i) => i.part(incident, scattered).and_then(|p| disagreement(p)),
        };
        found.reciprocity.extend(defect.map(|d| (name(incident, scattered), d)));
        let bad = bad_values(&bsdf, incident, scattered);
        if bad > 0 {
            let place = name(incident, scattered);
            found.faults.push(format!("{place}: {bad} values negative or not finite"));
        }
    }
    found
}

/// How many of 16,384 values are no BSDF.
fn bad_values(bsdf: &Bsdf, incident: Side, scattered: Side) -> usize {
    const CELLS: u32 = 16;
    let point = |k: u32| {
        let cell = DVec2::new(f64::from(k % CELLS) + 0.5, f64::from(k / CELLS) + 0.5);
        cell / f64::from(CELLS)
    };
    let wo: Vec<DVec3> =
        (0..CELLS * CELLS).map(|k| square_to_hemisphere(point(k), scattered)).collect();
    let mut values = vec![0.0; wo.len()];
    let mut bad = 0;
    for k in (0..CELLS * CELLS).step_by(4) {
        let wi = square_to_hemisphere(point(k), incident);
        bsdf.eval_many(&[wi], &wo, &mut values).expect("one value for each direction");
        bad += values.iter().filter(|f| !(f.is_finite() && **f >= 0.0)).count();
    }
    bad
}
