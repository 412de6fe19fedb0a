//! What is wrong with a file.

use std::path::PathBuf;

use bsdfkit::xml::doctor::{self, Program};
use bsdfkit::xml::{self, Limits};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::raised;

/// What is wrong with an XML file, which programs that breaks and how; a list of `Finding`.
///
/// A file that cannot be read has the finding "unreadable", "web-page" or "other-format". The codes are listed in the
/// guide (docs/guide/check.md); `bsdf check --fix` mends.
///
/// Args:
///     path: A file of WINDOW's and Radiance's XML.
///     program: Only what matters to it: "radiance", "window", "energyplus", "frads", "honeybee" or "mitsuba".
///
/// Raises:
///     IoError: It cannot be opened.
///     ArgumentError: Another program.
///     LimitError: It is larger than a documented limit.
#[pyfunction]
#[pyo3(signature = (path, *, program = None))]
pub(crate) fn check(py: Python<'_>, path: PathBuf, program: Option<&str>) -> PyResult<Py<PyAny>> {
    let program = program.map(str::parse::<Program>).transpose().map_err(|e| raised(&e))?;
    let found = py.detach(|| {
        let limits = Limits::default();
        xml::bytes_of(&path, &limits).map(|bytes| doctor::examine(&bytes, &limits).findings)
    });
    let found = found.map_err(|e| raised(&e))?;
    let finding = py.import("bsdfkit._types")?.getattr("Finding")?;
    let object = |f: &doctor::Finding| {
        let programs = PyDict::new(py);
        for harm in f.kind.harms {
            for program in harm.programs {
                programs.set_item(program.name(), (harm.how.name(), harm.text))?;
            }
        }
        let mended = f.kind.mends.name();
        finding.call1((f.kind.code, &f.place, &f.text, programs, f.kind.remedy, mended))
    };
    let all = found.iter().filter(|f| f.matters(program)).map(object);
    Ok(all.collect::<PyResult<Vec<_>>>()?.into_pyobject(py)?.into_any().unbind())
}
