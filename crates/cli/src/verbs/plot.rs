//! `bsdf plot`: pictures. Panels side by side are drawn here; all other kinds by the Python package.

use std::ffi::OsString;

use clap::{Args, Parser};

use crate::terminal::python::Module;
use crate::terminal::stop::Outcome;
use crate::verbs::panels;

/// Draw files and measurements: panels of one incidence, or `--kind KIND` (hemisphere, slice, lobe, …)
///
/// Without `--kind`, or with `--kind panels`: measurements, files and the truth of one incidence side by side, as PNG.
/// Other kinds are drawn by the Python package bsdfkit, as PNG or SVG.
#[derive(Args, Debug)]
#[command(disable_help_flag = true)]
pub(crate) struct Arguments {
    /// Files and options: `bsdf plot --help`, `bsdf plot --kind hemisphere --help`
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENT")]
    words: Vec<OsString>,
}

/// The kind that needs no Python.
const PANELS: &str = "panels";

// The command line of panels alone; what it says of itself is theirs.
#[derive(Parser)]
#[command(name = "bsdf plot", bin_name = "bsdf plot", after_long_help = panels::EXAMPLES)]
struct Panels {
    #[command(flatten)]
    arguments: panels::Arguments,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    match kind(&arguments.words).as_deref() {
        None | Some(PANELS) => {
            let words = std::iter::once(OsString::from("bsdf plot"));
            let line = Panels::try_parse_from(words.chain(arguments.words.iter().cloned()));
            panels::run(&line.unwrap_or_else(|e| e.exit()).arguments)
        }
        Some(_) => Module::drawing("bsdfkit.plot", "plot").run(&arguments.words),
    }
}

/// What follows `--kind`.
fn kind(words: &[OsString]) -> Option<String> {
    let texts = words.iter().map(|w| w.to_string_lossy());
    let mut texts = texts.take_while(|w| w != "--");
    while let Some(text) = texts.next() {
        if text == "--kind" {
            return Some(texts.next().unwrap_or_default().into_owned());
        }
        if let Some(kind) = text.strip_prefix("--kind=") {
            return Some(kind.to_owned());
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kind_is_found_wherever_it_stands() {
        let of = |line: &str| kind(&line.split(' ').map(OsString::from).collect::<Vec<_>>());
        assert_eq!(of("a.xml -o a.png"), None);
        assert_eq!(of("a.xml --kind lobe -o a.png").as_deref(), Some("lobe"));
        assert_eq!(of("--kind=slice a.xml").as_deref(), Some("slice"));
        assert_eq!(of("a.xml --kind").as_deref(), Some(""));
        assert_eq!(of("a.xml -- --kind lobe"), None);
    }
}
