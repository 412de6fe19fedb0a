//! Verbs that the Python package does: where an interpreter is, and what to install where it is not.

use std::env;
use std::ffi::OsString;
use std::process::{Command, Stdio};

use bsdfkit::Error;

use crate::terminal::stop::{Outcome, Stop, Verdict};

/// Names an interpreter that has the package.
const INTERPRETER: &str = "BSDFKIT_PYTHON";

/// Tells the package which command it works for: a report asks it for the verdict of `check`.
const COMMAND: &str = "BSDFKIT_COMMAND";

/// Prints which of the packages are missing.
const MISSING: &str = "from importlib.util import find_spec as f
print(*(n for n in ('numpy', 'matplotlib', 'bsdfkit') if not f(n)))";

/// A module of the Python package that does what a verb is asked for.
pub(crate) struct Module {
    /// As `python3 -m` takes it.
    pub(crate) name: &'static str,
    /// The verb.
    pub(crate) verb: &'static str,
}

impl Module {
    /// Runs it with `words`, in our place: what it prints and its exit status are ours.
    ///
    /// Errors: argument where there is no interpreter, or one that lacks the package.
    pub(crate) fn run(&self, words: &[OsString]) -> Outcome {
        let given = env::var_os(INTERPRETER).filter(|given| !given.is_empty());
        let python = given.unwrap_or_else(|| "python3".into());
        let lacking = |what: String| {
            Error::argument(format!(
                "{}: {what}: `pip install '.[plot]'` in a checkout of bsdfkit installs all it needs; {INTERPRETER} names an \
                 interpreter that has it",
                self.verb
            ))
        };
        let place = python.to_string_lossy();
        let looked =
            Command::new(&python).args(["-c", MISSING]).stdin(Stdio::null()).output().map_err(
                |e| lacking(format!("expected a Python interpreter, could not run {place} ({e})")),
            )?;
        let missing = String::from_utf8_lossy(&looked.stdout);
        let missing: Vec<&str> = missing.split_whitespace().collect();
        if !looked.status.success() {
            return Err(lacking(format!("expected a Python interpreter, found {place}")).into());
        }
        if !missing.is_empty() {
            let what = format!(
                "expected the Python packages bsdfkit and matplotlib, {place} lacks {}",
                missing.join(" and ")
            );
            return Err(lacking(what).into());
        }
        let mut module = Command::new(&python);
        if let Ok(own) = env::current_exe() {
            module.env(COMMAND, own);
        }
        let status = module.args(["-m", self.name]).args(words).status();
        let status = status.map_err(|e| Error::io(&place, &e))?;
        match status.code() {
            Some(0) => Ok(Verdict::Good),
            code => Err(Stop::Status(code.and_then(|c| u8::try_from(c).ok()).unwrap_or(2))),
        }
    }
}
