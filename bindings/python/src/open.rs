//! Opens any file that answers queries, told apart by its content.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use bsdfkit::xml::{self, Limits};
use bsdfkit::{Error, Result, container};
use pyo3::prelude::*;

use crate::bsdf::Bsdf;
use crate::error::raised;
use crate::interpolant::Interpolant;

/// What a file opened as.
enum Opened {
    Bsdf(Box<bsdfkit::Bsdf>, Vec<String>),
    Interpolant(bsdfkit_fit::interpolant::Interpolant),
}

/// Longest header of a container that is looked at; ours take kilobytes.
const MOST_HEADER: u64 = 1 << 24;

/// The `kind` that the container in `file` states; `None` where it is none of ours.
fn container_kind(file: File) -> std::io::Result<Option<String>> {
    let mut file = file.take(MOST_HEADER);
    let mut length = [0; 8];
    let mut header = Vec::new();
    if file.read_exact(&mut length).is_err() {
        return Ok(None);
    }
    file.take(u64::from_le_bytes(length)).read_to_end(&mut header)?;
    let ours = serde_json::from_slice::<serde_json::Value>(&header)
        .ok()
        .and_then(|h| serde_json::from_str(h["__metadata__"]["bsdfkit"].as_str()?).ok());
    Ok(ours.and_then(|h: serde_json::Value| Some(h["kind"].as_str()?.to_owned())))
}

fn read(path: &Path, in_place: bool) -> Result<Opened> {
    use bsdfkit_fit::interpolant::Interpolant;
    let io = |e: std::io::Error| Error::io(path.display(), &e);
    let mut file = File::open(path).map_err(io)?;
    let mut head = Vec::new();
    Read::by_ref(&mut file).take(10).read_to_end(&mut head).map_err(io)?;
    if head.starts_with(b"#?RADIANCE") {
        return Ok(Opened::Interpolant(Interpolant::read_sir(&[path])?));
    }
    let suffix = path.extension().is_some_and(|s| s.eq_ignore_ascii_case("safetensors"));
    if (head.get(8) == Some(&b'{') && head.contains(&0)) || suffix {
        let kind = container_kind(File::open(path).map_err(io)?).map_err(io)?;
        return Ok(match kind.as_deref() {
            Some("interpolant") => Opened::Interpolant(Interpolant::open(path)?),
            _ if in_place => Opened::Bsdf(container::open(path)?.into(), Vec::new()),
            _ => Opened::Bsdf(container::load(path)?.into(), Vec::new()),
        });
    }
    let (bsdf, warnings) = xml::read_with(path, &Limits::default())?;
    Ok(Opened::Bsdf(bsdf.into(), warnings.iter().map(ToString::to_string).collect()))
}

/// Opens a BSDF or an interpolant; the file's content tells which.
///
/// XML of WINDOW and Radiance (matrix or tensor tree) and compiled containers give a `Bsdf`; containers
/// of an interpolant and Radiance's SIR files an `Interpolant`. What the reader finds questionable
/// is warned of (`bsdfkit.FileWarning`).
///
/// Args:
///     path: The file.
///     in_place: Map a compiled container into memory instead of reading it: it opens in less than a
///         millisecond, whatever its size. Damage within it is not found, and the file must
///         stay as it is while it is open. Other files are read as ever.
///
/// Raises:
///     IoError: It cannot be read.
///     FormatError: Its content is wrong; all faults are listed.
///     LimitError: It is larger than a documented limit.
#[pyfunction]
#[pyo3(signature = (path, *, in_place = false))]
pub(crate) fn open(py: Python<'_>, path: PathBuf, in_place: bool) -> PyResult<Py<PyAny>> {
    match py.detach(|| read(&path, in_place)).map_err(|e| raised(&e))? {
        Opened::Bsdf(bsdf, warnings) => {
            if !warnings.is_empty() {
                let category = py.import("bsdfkit._errors")?.getattr("FileWarning")?;
                let warn = py.import("warnings")?.getattr("warn")?;
                for warning in warnings {
                    warn.call1((format!("{}: {warning}", path.display()), &category))?;
                }
            }
            Ok(Py::new(py, Bsdf::from(*bsdf))?.into_any())
        }
        Opened::Interpolant(interpolant) => {
            Ok(Py::new(py, Interpolant::from(interpolant))?.into_any())
        }
    }
}
