//! Any file, told apart by its content.

use std::path::{Path, PathBuf};

use bsdfkit::spectrum::View;
use bsdfkit::xml::Warning;
use bsdfkit::{Bsdf, Error, Lookup, Metadata, Result};
use bsdfkit_fit::interpolant::Interpolant;
use bsdfkit_fit::open::{self, Access, Content, Opened};
use bsdfkit_measure::{Measurement, ReadOptions};
use clap::Args;

use crate::files::surface::Surface;
use crate::terminal::stop::remark;

/// A file that answers queries.
pub(crate) struct Loaded {
    pub(crate) content: Content,
    pub(crate) surface: Surface,
    /// What the reader found questionable.
    pub(crate) warnings: Vec<Warning>,
}

impl Loaded {
    /// Says on standard error what the reader of `path` found questionable.
    pub(crate) fn warn(&self, path: &Path) {
        let place = path.display();
        let warnings = self.warnings.iter().map(|w| format!("{place}: {w}"));
        remark("warning", &warnings.collect::<Vec<_>>());
    }

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
    let (content, opened) = open::open(path, Access::Checked)?;
    let (surface, warnings) = match opened {
        Opened::Bsdf(bsdf, warnings) => (Surface::Stored(bsdf), warnings),
        Opened::Interpolant(interpolant) => (Surface::Continuous(interpolant), Vec::new()),
    };
    Ok(Loaded { content, surface, warnings })
}

/// How values between those stored are found.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct Reading {
    /// Read trees smoothly, not leaf by leaf as Radiance does; other files are as without
    #[arg(long)]
    smooth: bool,
    /// What is made of the bands of a spectrum: photopic, melanopic, xyz or colour (each with -d65, -a or -e), solar, nir, mean, or a
    /// wavelength as 550nm [default: colour in daylight]
    #[arg(long, value_name = "VIEW")]
    view: Option<View>,
}

/// A file for queries alone, read as asked for; a compiled BSDF stays in it.
///
/// Errors: as [`load`].
pub(crate) fn bsdf(path: &Path, reading: Reading) -> Result<Bsdf> {
    let bsdf = match reading.view {
        None => open::bsdf(path)?,
        Some(view) => match load(path)?.surface {
            Surface::Continuous(interpolant) => {
                interpolant.seen_as(view).map_err(|e| e.context(path.display()))?.bsdf()
            }
            Surface::Stored(_) => {
                return Err(Error::argument(format!(
                    "{}: --view {view}: expected the interpolant of a spectral measurement, found a stored BSDF",
                    path.display()
                )));
            }
        },
    };
    reading.looked_up(bsdf, path)
}

impl Reading {
    /// What is made of bands, if that was said.
    pub(crate) fn view(self) -> Option<View> {
        self.view
    }

    /// The same with its trees read as asked for.
    ///
    /// Errors: as [`Bsdf::with_lookup`].
    pub(crate) fn looked_up(self, bsdf: Bsdf, path: &Path) -> Result<Bsdf> {
        let lookup = if self.smooth { Lookup::Smooth } else { Lookup::Stored };
        bsdf.with_lookup(lookup).map_err(|e| e.context(path.display()))
    }
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
    bsdfkit_measure::read(paths, &ReadOptions { incomplete, ..ReadOptions::default() })
}
