//! `bsdf validate`: every measured incidence predicted from the others.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use bsdfkit::{DVec3, Error, Result};
use bsdfkit_fit::interpolant::FitSettings;
use bsdfkit_fit::interpolant::build;
use bsdfkit_fit::validate::{ErrorModel, Expected, LeftOut, Summary, Validated, Validation};
use bsdfkit_measure::{Measurement, ReadOptions, Symmetry, SymmetryKind};
use bsdfkit_represent::{Progress, Watch};
use bsdfkit_sphere::direction::to_degrees;
use clap::Args;
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::files::component::name;
use crate::files::instrument::{Instrument, beside_peaks};
use crate::files::target::expect_writable;
use crate::files::told;
use crate::picture::error_map::{self, ErrorMap};
use crate::terminal::angles::Angles;
use crate::terminal::progress::Bar;
use crate::terminal::stop::{Outcome, Verdict, remark};
use crate::terminal::table::Table;

const EXAMPLES: &str = "\
Examples:
  bsdf validate measurements/
  bsdf validate measurements/ --json errors.json --picture errors.png";

/// Predict every measured incidence from the others
///
/// Leaves out one incidence at a time, interpolates it from the rest, and compares with its points:
/// L1 (the share of light in a wrong place, doubled), hemispherical value, place and height of each
/// peak. What lies past the rim of the others is extrapolated: marked *, and summed up apart. With --aperture or
/// --signature all of it is of what lies beside the peaks of no width; of these it is told what they are, and how well the other
/// incidences foretell each one's coefficient.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Files and folders of one specimen
    #[arg(required = true, value_name = "PATH")]
    paths: Vec<PathBuf>,
    /// Write all figures as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Draw the errors over the disk of incident directions: rings where incidences were left out,
    /// behind them the error to expect of the interpolant that has all
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
    /// Print the error to expect at these incident directions, too: L1, and the interval that holds
    /// f for 9 in 10 scattered directions
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true)]
    incident: Vec<Angles>,
    /// isotropic, quadrilateral, bilateral, bilateral-x, bilateral-y, rotational180 or none
    /// [default: what the incidences show]
    #[arg(long, value_name = "S")]
    symmetry: Option<SymmetryKind>,
    #[command(flatten)]
    instrument: Instrument,
}

/// A component's name and symmetry, with its errors.
struct Named {
    component: String,
    symmetry: Symmetry,
    /// A sentence a peak of no width.
    specular: Vec<String>,
    validation: Validation,
    model: ErrorModel,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    for path in arguments.json.iter().chain(&arguments.picture) {
        expect_writable(path)?;
    }
    let options = ReadOptions { symmetry: arguments.symmetry, ..ReadOptions::default() };
    let signature = arguments.instrument.signature()?;
    let mut validated = Vec::new();
    for m in bsdfkit_measure::read(&arguments.paths, &options)? {
        let component = name(m.incident, m.scattered);
        let notes: Vec<String> = m.notes.iter().map(|n| format!("{component}: {n}")).collect();
        remark("note", &notes);
        m.expect_enough().map_err(|e| e.context(&component))?;
        told::warn_scant(&component, &m);
        let (m, specular) =
            beside_peaks(m, signature.as_ref()).map_err(|e| e.context(&component))?;
        let Validated { validation, model } =
            validate(&m, &component).map_err(|e| e.context(&component))?;
        validated.push(Named { component, symmetry: m.symmetry, specular, validation, model });
    }
    if let Some(path) = &arguments.json {
        write_json(path, &validated, &arguments.incident)?;
    }
    if let Some(path) = &arguments.picture {
        let maps: Vec<ErrorMap> = validated.iter().map(map).collect();
        error_map::save(path, &maps, "L1: rings left out, behind them to expect")?;
    }
    let mut out = BufWriter::new(io::stdout().lock());
    for v in &validated {
        print(&mut out, v)?;
        for at in &arguments.incident {
            let (Angles { theta, phi }, Expected { l1, spread, background }) =
                (at, v.model.at(at.direction()));
            writeln!(
                out,
                "  expected at theta {theta} phi {phi}: L1 {l1:.4}; of 9 in 10 directions f ± {spread:.4} (f + {background:.2e})"
            )?;
        }
    }
    out.flush()?;
    Ok(Verdict::Good)
}

fn validate(m: &Measurement, component: &str) -> Result<Validated> {
    let whole = {
        let bar = Bar::new(format!("{component}: fit"));
        let report = |progress: Progress| bar.report(progress);
        let watch = Watch { progress: Some(&report), cancel: None };
        build(m, &FitSettings::default(), &watch)?
    };
    let bar = Bar::new(format!("{component}: leave out"));
    let report = |progress: Progress| bar.report(progress);
    let watch = Watch { progress: Some(&report), cancel: None };
    Validated::of(m, &whole, &watch)
}

/// Errors over incident directions, images of the incidences drawn too.
fn map(v: &Named) -> ErrorMap {
    let images = v.symmetry.images();
    let left_out = v.validation.incidences.iter();
    let spots = left_out.flat_map(|i| images.iter().map(|image| (image.apply(i.wi), i.l1)));
    let expected = |wi: &[DVec3]| wi.par_iter().map(|&w| v.model.at(w).l1).collect();
    ErrorMap::new(v.component.clone(), spots.collect(), expected)
}

/// Figures of all peaks, the highest first.
fn of_peaks(i: &LeftOut, digits: usize, of: impl Fn(usize) -> f64) -> String {
    (0..i.peaks.len()).map(|k| format!("{:.digits$}", of(k))).collect::<Vec<_>>().join(" ")
}

fn print(out: &mut impl Write, validated: &Named) -> io::Result<()> {
    let incidences = &validated.validation.incidences;
    writeln!(out, "{}: {} incidences", validated.component, incidences.len())?;
    validated.specular.iter().try_for_each(|peak| writeln!(out, "  {peak}"))?;
    let mut table = Table::new([
        "theta",
        "phi",
        "",
        "L1",
        "fit",
        "noise",
        "hemispherical %",
        "peaks off by °",
        "height",
    ]);
    for i in incidences {
        let (theta, phi) = to_degrees(i.wi);
        table.row([
            format!("{theta:.1}"),
            format!("{phi:.1}"),
            if i.extrapolated { "*".into() } else { String::new() },
            format!("{:.4}", i.l1),
            format!("{:.4}", i.fit_l1),
            format!("{:.4}", i.noise),
            format!("{:.2}", 100.0 * i.hemispherical_error),
            of_peaks(i, 2, |k| i.peaks[k].offset_degrees),
            of_peaks(i, 3, |k| i.peaks[k].height_ratio),
        ]);
    }
    table.print(out, 2)?;
    for (words, extrapolated) in [("interpolated", false), ("* extrapolated", true)] {
        if let Some(s) = validated.validation.summary(extrapolated) {
            writeln!(
                out,
                "  {words}: {} incidences, L1 mean {:.4} largest {:.4} (fit {:.4}), hemispherical rms {:.2} %, \
                 highest peak off by {:.2}°, height {:.3}",
                s.incidences,
                s.l1,
                s.largest_l1,
                s.fit_l1,
                100.0 * s.hemispherical_rms,
                s.peak_offset_degrees,
                s.peak_height_ratio
            )?;
        }
    }
    Ok(())
}

fn write_json(path: &Path, validated: &[Named], asked: &[Angles]) -> Result<()> {
    let components = validated.iter().map(|v| of_component(v, asked));
    let text = Value::from(components.collect::<Vec<_>>());
    bsdfkit::replace_file(path, |out| {
        writeln!(out, "{text:#}").map_err(|e| Error::io("writing", &e))
    })
}

fn of_component(validated: &Named, asked: &[Angles]) -> Value {
    let summary = |s: Summary| {
        json!({
            "incidences": s.incidences, "l1_mean": s.l1, "l1_largest": s.largest_l1, "fit_l1_mean": s.fit_l1,
            "hemispherical_error_rms": s.hemispherical_rms, "peak_offset_degrees_mean": s.peak_offset_degrees,
            "peak_height_ratio_mean": s.peak_height_ratio
        })
    };
    let v = &validated.validation;
    let expected = asked.iter().map(|a| {
        let Expected { l1, spread, background } = validated.model.at(a.direction());
        json!({
            "theta_degrees": a.theta, "phi_degrees": a.phi, "l1": l1, "spread": spread, "background": background
        })
    });
    json!({
        "component": validated.component,
        "specular": validated.specular,
        "interpolated": v.summary(false).map(summary),
        "extrapolated": v.summary(true).map(summary),
        "expected": expected.collect::<Vec<_>>(),
        "incidences": v.incidences.iter().map(of_incidence).collect::<Vec<_>>(),
    })
}

fn of_incidence(i: &LeftOut) -> Value {
    let (theta, phi) = to_degrees(i.wi);
    let peaks = i.peaks.iter().map(|p| {
        let (theta, phi) = to_degrees(p.direction);
        json!({
            "theta_degrees": theta, "phi_degrees": phi, "f_cos": p.height,
            "offset_degrees": p.offset_degrees, "height_ratio": p.height_ratio
        })
    });
    json!({
        "theta_degrees": theta, "phi_degrees": phi, "extrapolated": i.extrapolated, "l1": i.l1,
        "fit_l1": i.fit_l1, "noise_l1": i.noise, "hemispherical_error": i.hemispherical_error, "peaks": peaks.collect::<Vec<_>>()
    })
}
