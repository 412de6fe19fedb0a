//! Opens any file that answers queries, told apart by its content.

use std::path::PathBuf;

use bsdfkit::Lookup;
use bsdfkit_fit::open::{Access, Opened};
use pyo3::prelude::*;

use crate::bsdf::Bsdf;
use crate::error::raised;
use crate::interpolant::object;

/// Opens a BSDF or an interpolant; the file's content tells which.
///
/// XML of WINDOW and Radiance (matrix or tensor tree) and compiled containers give a `Bsdf`; containers
/// of an interpolant and Radiance's SIR files an `Interpolant`. What the reader finds questionable
/// is warned of (`bsdfkit.FileWarning`).
///
/// Args:
///     path: The file.
///     in_place: Leave a compiled container in its file, mapped into memory, as Rust and C do: it opens in
///         less than a millisecond, whatever its size. Damage within it is not found (wrong values
///         come out, nothing worse), and while it is open its file must be replaced by renaming, as
///         `save` does, never changed in place: cut short, it would end the process by a signal.
///         False: read and check all of it (15 ns a value), for a file that others may
///         overwrite or that may be damaged. Other files are read and checked whole in any case.
///     smooth: Read tensor trees smoothly: a value varies within its leaf, as the neighbours suggest,
///         about the same mean, instead of being the same all over it as in Radiance. All verbs
///         agree; other files, and what `save` writes, are as without.
///
/// Raises:
///     IoError: It cannot be read.
///     FormatError: Its content is wrong; all faults are listed.
///     ArgumentError: It is a measurement, of which `fit` makes an interpolant.
///     LimitError: It is larger than a documented limit.
#[pyfunction]
#[pyo3(signature = (path, *, in_place = true, smooth = false))]
pub(crate) fn open(
    py: Python<'_>,
    path: PathBuf,
    in_place: bool,
    smooth: bool,
) -> PyResult<Py<PyAny>> {
    let access = if in_place { Access::InPlace } else { Access::Checked };
    let (_, opened) =
        py.detach(|| bsdfkit_fit::open::open(&path, access)).map_err(|e| raised(&e))?;
    match opened {
        Opened::Bsdf(bsdf, warnings) => {
            if !warnings.is_empty() {
                let category = py.import("bsdfkit._errors")?.getattr("FileWarning")?;
                let warn = py.import("warnings")?.getattr("warn")?;
                for warning in warnings {
                    warn.call1((format!("{}: {warning}", path.display()), &category))?;
                }
            }
            let lookup = if smooth { Lookup::Smooth } else { Lookup::Stored };
            let bsdf = py.detach(|| bsdf.with_lookup(lookup));
            let bsdf = bsdf.map_err(|e| raised(&e.context(path.display())))?;
            Ok(Py::new(py, Bsdf::from(bsdf))?.into_any())
        }
        Opened::Interpolant(interpolant) => Ok(object(py, interpolant, None)?.into_any()),
    }
}
