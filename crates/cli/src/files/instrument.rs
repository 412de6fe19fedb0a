//! What the instrument shows of a ray that nothing widens, and what is done with it.

use std::path::PathBuf;

use bsdfkit::Result;
use bsdfkit_fit::specular::{Separated, Signature, separate};
use bsdfkit_measure::Measurement;
use clap::Args;

use crate::files::component;

/// How narrow a peak the instrument can show.
#[derive(Args, Clone, Debug)]
pub(crate) struct Instrument {
    /// Diameter of the cone that the detector sees at once, degrees: peaks that are no wider are separated as
    /// specular components, which have no width
    #[arg(long, value_name = "DEG", conflicts_with = "signature", allow_negative_numbers = true)]
    aperture: Option<f64>,
    /// The same, with what the instrument shows of the empty beam: a measurement file of one incident direction
    /// without a specimen
    #[arg(long, value_name = "FILE")]
    signature: Option<PathBuf>,
}

impl Instrument {
    /// What it shows of a ray, if anybody said.
    ///
    /// Errors: as [`Signature::of_aperture`] and [`Signature::read`].
    pub(crate) fn signature(&self) -> Result<Option<Signature>> {
        match (self.aperture, &self.signature) {
            (Some(degrees), _) => {
                Signature::of_aperture(degrees).map_err(|e| e.context("--aperture")).map(Some)
            }
            (None, Some(file)) => {
                Signature::read(file).map_err(|e| e.context("--signature")).map(Some)
            }
            (None, None) => Ok(None),
        }
    }
}

/// A measurement without its peaks of no width, and a sentence about each of these.
pub(crate) fn beside_peaks(
    m: Measurement,
    signature: Option<&Signature>,
) -> Result<(Measurement, Vec<String>)> {
    let Some(signature) = signature else { return Ok((m, Vec::new())) };
    let Separated { measurement, peaks } = separate(&m, signature)?;
    let said = peaks.iter().map(|peak| component::peak(&peak.specular)).collect();
    Ok((measurement, said))
}
