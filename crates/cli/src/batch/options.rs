//! What of `bsdf fit` a manifest may set: its own options, under their names.

use std::path::PathBuf;

use bsdfkit::{Error, Result};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgAction, Args, Command, value_parser};

use crate::verbs::fit;

/// What the batch itself decides.
const OWN: [&str; 10] = [
    "paths",
    "output",
    "to",
    "for",
    "name",
    "manufacturer",
    "cache",
    "cache_size",
    "threads",
    "json",
];

/// How an option takes its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    /// It is there or not.
    Flag,
    One,
    /// It may be repeated.
    Many,
    /// A file, which is an input.
    File,
}

/// An option of `bsdf fit`.
#[derive(Debug)]
pub(crate) struct FitOption {
    /// As a manifest names it: with _.
    pub(crate) key: String,
    /// As the command line does, with its hyphens.
    pub(crate) long: String,
    pub(crate) shape: Shape,
}

/// Every option of `bsdf fit` that a manifest may set.
pub(crate) fn all() -> Vec<FitOption> {
    let path = value_parser!(PathBuf).type_id();
    let option = |arg: &Arg| {
        let key = arg.get_id().to_string();
        let long = format!("--{}", arg.get_long()?);
        let shape = match arg.get_action() {
            ArgAction::SetTrue => Shape::Flag,
            ArgAction::Append => Shape::Many,
            _ if arg.get_value_parser().type_id() == path => Shape::File,
            _ => Shape::One,
        };
        (!OWN.contains(&&*key)).then_some(FitOption { key, long, shape })
    };
    fit().get_arguments().filter_map(option).collect()
}

fn fit() -> Command {
    fit::Arguments::augment_args(Command::new("fit").disable_help_flag(true))
}

/// Whether `bsdf fit` takes `options` after the files.
///
/// Errors: argument, with what was expected and found.
pub(crate) fn expect_taken(options: &[String]) -> Result<()> {
    let words = ["fit", "x", "-o", "x.xml"].map(str::to_owned);
    let taken = fit().try_get_matches_from(words.iter().chain(options));
    taken.map(drop).map_err(|e| Error::argument(reason(&e)))
}

/// The reason alone, in one line.
fn reason(error: &clap::Error) -> String {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => text.clone(),
        Some(ContextValue::Strings(all)) => all.join(", "),
        _ => String::new(),
    };
    let found = text(ContextKind::InvalidValue);
    match error.kind() {
        ErrorKind::InvalidValue => {
            format!("expected one of {}, found {found:?}", text(ContextKind::ValidValue))
        }
        ErrorKind::ValueValidation => match std::error::Error::source(error) {
            Some(source) if source.to_string().contains(&*found) => source.to_string(),
            Some(source) => format!("{source}, found {found:?}"),
            None => format!("found {found:?}"),
        },
        ErrorKind::ArgumentConflict => {
            format!("cannot stand beside {}", text(ContextKind::PriorArg))
        }
        _ => {
            let text = error.to_string();
            let line = text.lines().next().unwrap_or_default();
            line.strip_prefix("error: ").unwrap_or(line).to_owned()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_fit_are_keys() {
        let shape = |key: &str| all().into_iter().find(|o| o.key == key).map(|o| o.shape);
        assert_eq!(shape("symmetry"), Some(Shape::One));
        assert_eq!(shape("reversed"), Some(Shape::Flag));
        assert_eq!(shape("signature"), Some(Shape::File));
        assert_eq!(shape("property"), Some(Shape::Many));
        for own in OWN {
            assert_eq!(shape(own), None, "{own}");
            // A word here that fit no longer knows would let another slip in.
            assert!(fit().get_arguments().any(|a| a.get_id() == own), "{own}");
        }
    }

    #[test]
    fn what_is_refused_is_told_with_what_was_expected() {
        for (option, words) in [
            ("--symmetry=round", "expected one of isotropic, "),
            ("--reciprocity=maybe", "expected one of auto, on, off, found \"maybe\""),
            ("--max-leaves=many", "found \"many\""),
            ("--grazing-limit=100", "expected auto or degrees"),
        ] {
            let error = expect_taken(&[option.to_owned()]).unwrap_err().to_string();
            assert!(error.contains(words), "{option}: {error}");
        }
        let both = ["--aperture=1", "--signature=x"].map(str::to_owned);
        let error = expect_taken(&both).unwrap_err().to_string();
        assert!(error.contains("cannot stand beside"), "{error}");
    }
}
