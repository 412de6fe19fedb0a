//! Any file of a material, told apart by its content.

use std::io::Read;
use std::path::Path;

use bsdfkit::xml::{self, Limits, Warning};
use bsdfkit::{Bsdf, Error, Result, container, foreign, limits};

use crate::interpolant::Interpolant;
use bsdfkit_measure::{DenseFile, ReadOptions};

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// The XML of WINDOW and Radiance.
    Xml,
    /// A compiled BSDF.
    Compiled,
    /// An interpolant of ours.
    Interpolant,
    /// Radiance's interpolant.
    Sir,
    /// Goniophotometer files, or a folder of them; a file of another format may be a function as well.
    Measurement,
}

/// What a container of ours says that it is.
const INTERPOLANT: &str = "interpolant";

/// How Radiance's own files start.
const RADIANCE: &[u8] = b"#?RADIANCE";

impl Content {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Xml => "BSDF in XML",
            Self::Compiled => "compiled BSDF",
            Self::Interpolant => "interpolant",
            Self::Sir => "Radiance interpolant",
            Self::Measurement => "measurement",
        }
    }

    /// What `path` holds, from its first bytes; the suffix decides only who complains of rubbish.
    ///
    /// Errors: io; argument: no regular file; format: a known format that is not read ([`bsdfkit::foreign`]).
    pub fn of(path: &Path) -> Result<Self> {
        let io = |e: std::io::Error| Error::io(path.display(), &e);
        if path.metadata().map_err(io)?.is_dir() {
            return Ok(Self::Measurement);
        }
        let file = limits::open_file(path)?;
        let content = bsdfkit::Content::of(path)?;
        let mut head = Vec::new();
        file.take(RADIANCE.len() as u64).read_to_end(&mut head).map_err(io)?;
        if head == RADIANCE {
            return Ok(Self::Sir);
        }
        let sir = path.extension().is_some_and(|s| s.eq_ignore_ascii_case("sir"));
        Ok(match content {
            bsdfkit::Content::Xml => Self::Xml,
            bsdfkit::Content::Container => match container::kind(path)?.as_deref() {
                Some(INTERPOLANT) => Self::Interpolant,
                _ => Self::Compiled,
            },
            bsdfkit::Content::Other if sir => Self::Sir,
            bsdfkit::Content::Measured(_) | bsdfkit::Content::Other => Self::Measurement,
        })
    }
}

/// How a compiled BSDF is opened; other files are read in any case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Read and checked whole: [`container::load`].
    Checked,
    /// In less than a millisecond, damage in it not found: [`container::open`].
    InPlace,
}

/// What answers queries.
#[derive(Clone, Debug)]
pub enum Opened {
    /// A stored BSDF, and what its reader found questionable.
    Bsdf(Box<Bsdf>, Vec<Warning>),
    /// A function to be evaluated.
    Interpolant(Interpolant),
}

impl Opened {
    /// As a BSDF: the five verbs, whatever it is made of.
    pub fn into_bsdf(self) -> Bsdf {
        match self {
            Self::Bsdf(bsdf, _) => *bsdf,
            Self::Interpolant(interpolant) => interpolant.bsdf(),
        }
    }
}

/// Opens any file that answers queries as a BSDF; a compiled one stays in its file.
///
/// Errors: as [`open`].
pub fn bsdf(path: &Path) -> Result<Bsdf> {
    open(path, Access::InPlace).map(|(_, opened)| opened.into_bsdf())
}

/// The same from the content of such a file.
///
/// Errors: as [`open_bytes`].
pub fn bsdf_from_bytes(bytes: &[u8]) -> Result<Bsdf> {
    open_bytes(bytes).map(|(_, opened)| opened.into_bsdf())
}

/// [`open`] from the content of a file.
///
/// Errors: as [`open`], without io and without the file's name; format for a measurement.
pub fn open_bytes(bytes: &[u8]) -> Result<(Content, Opened)> {
    if bytes.starts_with(RADIANCE) {
        return Ok((Content::Sir, Opened::Interpolant(Interpolant::from_sir(bytes)?)));
    }
    if container::kind_of_bytes(bytes).as_deref() == Some(INTERPOLANT) {
        return Ok((Content::Interpolant, Opened::Interpolant(Interpolant::from_bytes(bytes)?)));
    }
    if let Some(read) = Interpolant::from_tables("bytes", bytes) {
        return Ok((Content::Measurement, Opened::Interpolant(read?)));
    }
    if bsdfkit::Content::of_bytes(bytes) == bsdfkit::Content::Container {
        let bsdf = container::from_bytes(bytes)?;
        return Ok((Content::Compiled, Opened::Bsdf(bsdf.into(), Vec::new())));
    }
    foreign::refuse(bytes)?;
    let (bsdf, warnings) = xml::from_bytes(bytes, &Limits::default())?;
    Ok((Content::Xml, Opened::Bsdf(bsdf.into(), warnings)))
}

/// Opens a file that answers queries, with what [`Content::of`] says that it is.
///
/// A measurement whose format is a function on a grid (RGL's tensors, MERL, Zemax) answers as it is.
///
/// Errors: as its reader; argument for another sound measurement, which has no values between its points.
pub fn open(path: &Path, access: Access) -> Result<(Content, Opened)> {
    let content = Content::of(path)?;
    let opened = match (content, access) {
        (Content::Xml, _) => {
            let (bsdf, warnings) = xml::read_with(path, &Limits::default())?;
            Opened::Bsdf(bsdf.into(), warnings)
        }
        (Content::Compiled, Access::Checked) => {
            Opened::Bsdf(container::load(path)?.into(), Vec::new())
        }
        (Content::Compiled, Access::InPlace) => {
            Opened::Bsdf(container::open(path)?.into(), Vec::new())
        }
        (Content::Interpolant, _) => Opened::Interpolant(Interpolant::open(path)?),
        (Content::Sir, _) => Opened::Interpolant(Interpolant::read_sir(&[path])?),
        (Content::Measurement, _) => {
            if let Some(tables) = tables(path)? {
                return Ok((content, Opened::Interpolant(tables)));
            }
            // Rubbish is a fault of the file, a measurement one of the caller.
            let whatever = ReadOptions { incomplete: true, ..ReadOptions::default() };
            bsdfkit_measure::read(&[path.to_owned()], &whatever)?;
            return Err(Error::argument(
                "expected a BSDF or an interpolant, found a measurement: `fit` makes one of it",
            )
            .context(path.display()));
        }
    };
    Ok((content, opened))
}

/// The functions that a file of another format holds, if it is one of these.
fn tables(path: &Path) -> Result<Option<Interpolant>> {
    if path.is_dir() {
        return Ok(None);
    }
    match bsdfkit::Content::of(path)? {
        bsdfkit::Content::Measured(kind) if DenseFile::holds(kind) => {
            let bytes = bsdfkit_measure::whole(path)?;
            Interpolant::from_tables(&path.display().to_string(), &bytes).transpose()
        }
        _ => Ok(None),
    }
}
