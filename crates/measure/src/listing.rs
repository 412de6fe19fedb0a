//! The files that paths name, told apart by content.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use bsdfkit::spectrum::Bands;
use bsdfkit::{Error, Result};

use super::block::{Budget, FileContent};
use super::content::{Content, sniff};
use super::{mountain, table};

/// A measurement file that was not read yet.
pub(super) struct Listed {
    pub(super) path: PathBuf,
    content: Content,
    /// In nanometres, where it was given beside the path.
    wavelength: Option<f64>,
}

impl Listed {
    /// All that the file holds.
    ///
    /// Errors: io, format; limit where `budget` is spent.
    pub(super) fn read(&self, budget: &Budget) -> Result<FileContent> {
        let read = match &self.content {
            Content::Table => table::read(&self.path, budget),
            Content::Format(format) => format.read(&self.path, budget),
            _ => mountain::read(&self.path, budget),
        };
        let content = read?;
        Ok(match self.wavelength {
            None => content,
            given => FileContent { wavelength: given, ..content },
        })
    }
}

/// The wavelength and the path of `550nm=PATH`, unless there is a file of that very name.
fn of_wavelength(path: &Path) -> (Option<f64>, &Path) {
    let parts = path.to_str().filter(|_| !path.exists()).and_then(|text| text.split_once("nm="));
    let given = parts.and_then(|(number, path)| Some((number.parse::<f64>().ok()?, path)));
    given.map_or((None, path), |(wavelength, path)| (Some(wavelength), Path::new(path)))
}

/// The files that `paths` name with their kind and wavelength, if one is given; folders opened (not
/// the folders in them), each once, in order of name.
pub(super) fn list(paths: &[PathBuf], notes: &mut Vec<String>) -> Result<Vec<Listed>> {
    let mut files = Vec::new();
    let mut seen = HashSet::new();
    for path in paths {
        let (wavelength, path) = of_wavelength(path);
        let [least, most] = Bands::RANGE;
        if let Some(w) = wavelength.filter(|w| !(least..=most).contains(w)) {
            let message = format!("wavelength: expected {least} to {most} nm, found {w}");
            return Err(Error::argument(message).context(path.display()));
        }
        let io = |e: std::io::Error| Error::io(path.display(), &e);
        let folder = path.metadata().map_err(io)?.is_dir();
        let mut inside = if folder {
            let entries = path.read_dir().map_err(io)?;
            entries.map(|e| e.map(|e| e.path())).collect::<std::io::Result<Vec<_>>>().map_err(io)?
        } else {
            vec![path.to_owned()]
        };
        inside.sort();
        for file in inside {
            let io = |e: std::io::Error| Error::io(file.display(), &e);
            let hidden = file.file_name().is_some_and(|n| n.as_encoded_bytes().starts_with(b"."));
            let regular = file.metadata().map_err(io)?.is_file();
            if folder && (hidden || !regular) {
                notes.push(format!("{}: skipped, not a measurement file", file.display()));
                continue;
            }
            if !regular {
                return Err(Error::argument("expected a file or a folder, found neither")
                    .context(file.display()));
            }
            if !seen.insert(file.canonicalize().map_err(io)?) {
                notes.push(format!("{}: given more than once, read once", file.display()));
                continue;
            }
            match sniff(&file)? {
                Content::Foreign(found) if folder && found.may_lie_beside(&file) => {
                    notes.push(format!("{}: skipped: {}", file.display(), found.name));
                }
                Content::Foreign(found) => {
                    return Err(Error::format(found.to_string()).context(file.display()));
                }
                Content::Unknown(found) if folder => {
                    notes.push(format!("{}: skipped, no measurement: {found}", file.display()));
                }
                Content::Unknown(found) => {
                    let expected = "expected a Mountain file or a table with columns theta_i, phi_i, theta_o, phi_o";
                    return Err(
                        Error::format(format!("{expected}, found {found}")).context(file.display())
                    );
                }
                content => files.push(Listed { path: file, content, wavelength }),
            }
        }
    }
    if !files.is_empty() {
        return Ok(files);
    }
    match paths.first() {
        Some(path) => {
            Err(Error::format("expected measurement files, found none").context(path.display()))
        }
        None => Err(Error::argument("expected at least one file or folder, found none")),
    }
}
