//! Any file, told apart by its content.

use std::path::{Path, PathBuf};

use bsdfkit::xml::Warning;
use bsdfkit::{Error, Lookup, Metadata, Result};
use bsdfkit_fit::interpolant::Interpolant;
use bsdfkit_fit::measurement::{self, Measurement, ReadOptions};
use bsdfkit_fit::open::{self, Access, Content, Opened};
use clap::Args;

use crate::surface::Surface;

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

/// Loads a file that answers queries, a compiled BSDF whole and checked.
///
/// Errors: as its reader; argument for a measurement, which has no values between its points.
pub(crate) fn load(path: &Path) -> Result<Loaded> {
    loaded(path, Access::Checked)
}

/// The same for queries alone: a compiled BSDF stays in its file.
pub(crate) fn surface(path: &Path) -> Result<Surface> {
    loaded(path, Access::InPlace).map(|loaded| loaded.surface)
}

/// How values between those stored are found.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct Reading {
    /// Read trees smoothly, not leaf by leaf as Radiance does; other files are as without
    #[arg(long)]
    smooth: bool,
}

/// As [`surface`], read as asked for.
pub(crate) fn surface_read(path: &Path, reading: Reading) -> Result<Surface> {
    Ok(match surface(path)? {
        Surface::Stored(bsdf) if reading.smooth => {
            let smooth = bsdf.with_lookup(Lookup::Smooth);
            Surface::Stored(Box::new(smooth.map_err(|e| e.context(path.display()))?))
        }
        surface => surface,
    })
}

fn loaded(path: &Path, access: Access) -> Result<Loaded> {
    let (content, opened) = open::open(path, access)?;
    let (surface, warnings) = match opened {
        Opened::Bsdf(bsdf, warnings) => (Surface::Stored(bsdf), warnings),
        Opened::Interpolant(interpolant) => (Surface::Continuous(interpolant), Vec::new()),
    };
    Ok(Loaded { content, surface, warnings })
}

/// Loads several files as one surface: any number of SIR files, or one file of another kind.
pub(crate) fn load_all(paths: &[PathBuf]) -> Result<Loaded> {
    match paths {
        [path] => load(path),
        _ => {
            for path in paths {
                let content = Content::of(path)?;
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
