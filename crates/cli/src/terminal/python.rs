//! Verbs that the Python package does: where an interpreter is, and what to install where it is not.

use std::env;
use std::ffi::OsString;
use std::process::{Command, Stdio};

use bsdfkit::{Error, Result};

use crate::terminal::stop::{Outcome, Stop, Verdict};

/// Names an interpreter that has the package.
const INTERPRETER: &str = "BSDFKIT_PYTHON";

/// Tells the package which command it works for: a report asks it for the verdict of `check`.
const COMMAND: &str = "BSDFKIT_COMMAND";

/// Prints which of the packages that it is told are missing.
const MISSING: &str = "import sys
from importlib.util import find_spec as f
print(*(n for n in sys.argv[1:] if not f(n)))";

/// A module of the Python package that does what a verb is asked for.
pub(crate) struct Module {
    /// As `python3 -m` takes it.
    pub(crate) name: &'static str,
    /// The verb.
    pub(crate) verb: &'static str,
    /// The extra that installs all it needs.
    pub(crate) extra: &'static str,
    /// What it imports.
    pub(crate) packages: &'static [&'static str],
}

impl Module {
    /// One that draws.
    pub(crate) fn drawing(name: &'static str, verb: &'static str) -> Self {
        Self { name, verb, extra: "plot", packages: &["numpy", "matplotlib", "bsdfkit"] }
    }

    /// Runs it with `words`, in our place: what it prints and its exit status are ours.
    ///
    /// Errors: argument where there is no interpreter, or one that lacks a package.
    pub(crate) fn run(&self, words: &[OsString]) -> Outcome {
        let mut module = self.command()?;
        let status = module.args(words).status();
        let status = status.map_err(|e| Error::io(self.name, &e))?;
        match status.code() {
            Some(0) => Ok(Verdict::Good),
            code => Err(Stop::Status(code.and_then(|c| u8::try_from(c).ok()).unwrap_or(2))),
        }
    }

    /// A command that runs it, once its words are added.
    ///
    /// Errors: argument where there is no interpreter, or one that lacks a package.
    pub(crate) fn command(&self) -> Result<Command> {
        let given = env::var_os(INTERPRETER).filter(|given| !given.is_empty());
        let python = given.unwrap_or_else(|| "python3".into());
        let lacking = |what: String| {
            Error::argument(format!(
                "{}: {what}: `pip install '.[{}]'` in a checkout of bsdfkit installs all it needs; {INTERPRETER} names an \
                 interpreter that has it",
                self.verb, self.extra
            ))
        };
        let place = python.to_string_lossy();
        let mut look = Command::new(&python);
        let look = look.args(["-c", MISSING]).args(self.packages).stdin(Stdio::null());
        let looked = look.output().map_err(|e| {
            lacking(format!("expected a Python interpreter, could not run {place} ({e})"))
        })?;
        let missing = String::from_utf8_lossy(&looked.stdout);
        let missing: Vec<&str> = missing.split_whitespace().collect();
        if !looked.status.success() {
            return Err(lacking(format!("expected a Python interpreter, found {place}")));
        }
        if !missing.is_empty() {
            let what = format!(
                "expected the Python packages {}, {place} lacks {}",
                self.packages.join(" and "),
                missing.join(" and ")
            );
            return Err(lacking(what));
        }
        let mut module = Command::new(&python);
        if let Ok(own) = env::current_exe() {
            module.env(COMMAND, own);
        }
        module.args(["-m", self.name]);
        Ok(module)
    }
}
