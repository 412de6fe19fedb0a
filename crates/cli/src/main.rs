//! The command `bsdf`.

mod batch;
mod files;
mod picture;
mod terminal;
mod verbs;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::terminal::{stop, ward};
use crate::verbs::{
    batch as batch_verb, catalog, check, compile, convert, eval, export, fit, hemispherical, info,
    pdf, plan, plot, report, sample, simulate, solid_angle, validate, view,
};

/// Goniophotometer files in, a BSDF that any renderer loads out
#[derive(Parser)]
#[command(name = "bsdf", version, after_help = stop::STATUSES)]
struct Line {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    Fit(fit::Arguments),
    Batch(batch_verb::Arguments),
    Convert(convert::Arguments),
    Export(export::Arguments),
    Eval(eval::Arguments),
    Pdf(pdf::Arguments),
    Sample(sample::Arguments),
    Hemispherical(hemispherical::Arguments),
    SolidAngle(solid_angle::Arguments),
    Info(info::Arguments),
    Check(check::Arguments),
    Simulate(simulate::Arguments),
    Plot(plot::Arguments),
    Report(report::Arguments),
    Compile(compile::Arguments),
    Validate(validate::Arguments),
    Plan(plan::Arguments),
    View(view::Arguments),
    Catalog(catalog::Arguments),
}

fn main() -> ExitCode {
    ward::begin();
    stop::exit(match &Line::parse().verb {
        Verb::Fit(arguments) => fit::run(arguments),
        Verb::Batch(arguments) => batch_verb::run(arguments),
        Verb::Convert(arguments) => convert::run(arguments),
        Verb::Export(arguments) => export::run(arguments),
        Verb::Eval(arguments) => eval::run(arguments),
        Verb::Pdf(arguments) => pdf::run(arguments),
        Verb::Sample(arguments) => sample::run(arguments),
        Verb::Hemispherical(arguments) => hemispherical::run(arguments),
        Verb::SolidAngle(arguments) => solid_angle::run(arguments),
        Verb::Info(arguments) => info::run(arguments),
        Verb::Check(arguments) => check::run(arguments),
        Verb::Simulate(arguments) => simulate::run(arguments),
        Verb::Plot(arguments) => plot::run(arguments),
        Verb::Report(arguments) => report::run(arguments),
        Verb::Compile(arguments) => compile::run(arguments),
        Verb::Validate(arguments) => validate::run(arguments),
        Verb::Plan(arguments) => plan::run(arguments),
        Verb::View(arguments) => view::run(arguments),
        Verb::Catalog(arguments) => catalog::run(arguments),
    })
}
