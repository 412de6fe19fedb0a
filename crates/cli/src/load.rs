//! Any file, told apart by its content.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use bsdfkit::xml::{self, Limits, Warning};
use bsdfkit::{Error, Metadata, Result, container};
use bsdfkit_fit::interpolant::Interpolant;
use bsdfkit_fit::measurement::{self, Measurement, ReadOptions};

use crate::surface::Surface;

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Content {
    /// The XML of WINDOW and Radiance.
    Xml,
    /// A compiled BSDF.
    Compiled,
    /// An interpolant of ours.
    Interpolant,
    /// Radiance's interpolant.
    Sir,
    /// Goniophotometer files.
    Measurement,
}

impl Content {
    /// In words.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Xml => "BSDF in XML",
            Self::Compiled => "compiled BSDF",
            Self::Interpolant => "interpolant",
            Self::Sir => "Radiance interpolant",
            Self::Measurement => "measurement",
        }
    }
}

/// A file that answers queries.
pub(crate) struct Loaded {
    pub(crate) content: Content,
    pub(crate) surface: Surface,
    /// What the reader found questionable.
    pub(crate) warnings: Vec<Warning>,
}

impl Loaded {
    /// What is known of the material.
    pub(crate) fn metadata(&self) -> Metadata {
        match &self.surface {
            Surface::Stored(bsdf) => bsdf.metadata().clone(),
            Surface::Continuous(interpolant) => {
                let name = interpolant.name.clone().unwrap_or_default();
                Metadata { name, ..Metadata::default() }
            }
        }
    }
}

/// What `path` holds, from its first bytes; the suffix decides only who complains of rubbish.
pub(crate) fn sniff(path: &Path) -> Result<Content> {
    let io = |e: std::io::Error| Error::io(path.display(), &e);
    let mut file = File::open(path).map_err(io)?;
    if file.metadata().map_err(io)?.is_dir() {
        return Ok(Content::Measurement);
    }
    let mut head = Vec::new();
    Read::by_ref(&mut file).take(512).read_to_end(&mut head).map_err(io)?;
    if head.starts_with(b"#?RADIANCE") {
        return Ok(Content::Sir);
    }
    if let Some(kind) = container_kind(&head, &mut file)? {
        return Ok(if kind == "bsdf" { Content::Compiled } else { Content::Interpolant });
    }
    let markup = |bytes: &[u8]| {
        let zero = |b: &u8| *b == 0 || b.is_ascii_whitespace() || *b >= 0x80;
        bytes.iter().find(|b| !zero(b)) == Some(&b'<')
    };
    let suffix = path.extension().and_then(|s| s.to_str()).map(str::to_ascii_lowercase);
    Ok(match suffix.as_deref() {
        _ if markup(&head) => Content::Xml,
        Some("xml") => Content::Xml,
        Some("safetensors") => Content::Interpolant,
        Some("sir") => Content::Sir,
        _ => Content::Measurement,
    })
}

/// The `kind` that a safetensors file of ours states.
fn container_kind(head: &[u8], file: &mut File) -> Result<Option<String>> {
    /// Longest header looked at; ours take a few kilobytes.
    const MOST: u64 = 1 << 24;
    let Some((length, text)) = head.split_first_chunk::<8>() else { return Ok(None) };
    let length = u64::from_le_bytes(*length);
    if length > MOST || text.first() != Some(&b'{') {
        return Ok(None);
    }
    let mut header = text.to_vec();
    let left = length.saturating_sub(header.len() as u64);
    file.take(left).read_to_end(&mut header).map_err(|e| Error::io("cannot read", &e))?;
    header.truncate(length as usize);
    let Ok(json) = serde_json::from_slice::<serde_json::Value>(&header) else { return Ok(None) };
    let ours = json["__metadata__"]["bsdfkit"].as_str();
    let ours = ours.and_then(|text| serde_json::from_str::<serde_json::Value>(text).ok());
    Ok(ours.and_then(|h| h["kind"].as_str().map(str::to_owned)))
}

/// Loads a file that answers queries.
///
/// Errors: as its reader; argument for a measurement, which has no values between its points.
pub(crate) fn load(path: &Path) -> Result<Loaded> {
    let content = sniff(path)?;
    let mut warnings = Vec::new();
    let surface = match content {
        Content::Xml => {
            let (bsdf, found) = xml::read_with(path, &Limits::default())?;
            warnings = found;
            Surface::Stored(bsdf.into())
        }
        Content::Compiled => Surface::Stored(container::load(path)?.into()),
        Content::Interpolant => Surface::Continuous(Interpolant::open(path)?),
        Content::Sir => Surface::Continuous(Interpolant::read_sir(&[path])?),
        Content::Measurement => {
            // Rubbish is a fault of the file, a measurement one of the command.
            measure(&[path.to_owned()], true)?;
            return Err(Error::argument(
                "expected a BSDF or an interpolant, found a measurement: `bsdf fit` makes one of it",
            )
            .context(path.display()));
        }
    };
    Ok(Loaded { content, surface, warnings })
}

/// Loads several files as one surface: any number of SIR files, or one file of another kind.
pub(crate) fn load_all(paths: &[PathBuf]) -> Result<Loaded> {
    match paths {
        [path] => load(path),
        _ => {
            for path in paths {
                let content = sniff(path)?;
                if content != Content::Sir {
                    return Err(Error::argument(format!(
                        "{}: expected several inputs to be Radiance interpolants, one a component, found a {}",
                        path.display(),
                        content.name()
                    )));
                }
            }
            let surface = Surface::Continuous(Interpolant::read_sir(paths)?);
            Ok(Loaded { content: Content::Sir, surface, warnings: Vec::new() })
        }
    }
}

/// Reads a measurement to look at it, whatever it lacks.
pub(crate) fn measure(paths: &[PathBuf], incomplete: bool) -> Result<Vec<Measurement>> {
    measurement::read(paths, &ReadOptions { incomplete, ..ReadOptions::default() })
}
