//! `bsdf report`: one page that says what there is to say of a file.

use std::ffi::OsString;

use clap::Args;

use crate::terminal::python::Module;
use crate::terminal::stop::Outcome;

/// One self-contained HTML page about a measurement, an interpolant or a BSDF
///
/// Written by the Python package bsdfkit: coverage, errors, energy, reciprocity, peaks, pictures, verdicts.
#[derive(Args, Debug)]
#[command(disable_help_flag = true)]
pub(crate) struct Arguments {
    /// Files and options: `bsdf report --help`
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENT")]
    words: Vec<OsString>,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    Module::drawing("bsdfkit._report", "report").run(&arguments.words)
}
