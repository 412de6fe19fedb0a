//! Goniophotometer files in, incidences with their scattered distributions out. [WKB14 §2.1]
//!
//! One file a reader (Mountain text, tables, the formats of others); [`read`] tells them apart by
//! content, sorts what they hold into components, and settles the [`Symmetry`] of each.
//!
//! # Dialects
//!
//! Every guess is a note of the measurement; what cannot be guessed is an error that says what to
//! write.
//!
//! - Text: UTF-8, UTF-16 with or without its mark, else Windows-1252 (Latin-1) byte by byte; lines
//!   end in LF, CR LF or CR.
//! - Names of keys and columns count by their letters: `theta_i`, `Theta In`, `"θi"`. Incident:
//!   intheta, `theta_in`, `theta_i`, `incident_theta`; scattered: `theta_o`, `theta_out`,
//!   `theta_s`, `theta_r`, `theta_t`; φ alike. Values: BSDF, BRDF, BTDF or any other name are f in
//!   1/sr; DSF, CCBSDF and `brdf*cos` contain |cos θo| and are divided by it. The table is in
//!   `names.rs`.
//! - Units behind a name or a number, `[deg]`, `(rad)`, `_deg`, `°`: degrees without one.
//! - Mountain headers: `#key value`, `#key: value`, `#key = value`, `#key30`. Without a line
//!   `#format` the values are what the suffix (.brdf, .dsf) says, else BSDF. Rows may be parted as
//!   in tables.
//! - Wavelengths: `#lambda 550` of a file with one value a point, `#lambda 450 550 650` of one with
//!   as many; `550nm=FILE` instead of a file or folder. Files of one wavelength each are put
//!   together, where all were scanned at the same directions.
//! - Tables: a line that names the columns, after a `#` or not, then rows. Columns are parted by
//!   blanks, tabs, semicolons or commas; one more may end a row, quotes may enclose a field.
//!   Columns of row numbers and uncertainties are left out.
//! - Decimal commas, unless commas part the columns without quotes. One file has one decimal mark.

use std::borrow::Cow;
use std::path::PathBuf;

pub use bsdfkit::{DVec3, Side};
use bsdfkit::{Error, Result};
use bsdfkit_sphere::direction;

mod agreement;
mod around;
mod block;
mod colorimetry;
mod components;
mod content;
mod detect;
mod directions;
mod extension;
mod fold;
mod form;
mod formats;
pub mod frame;
mod gather;
mod header;
mod joined;
mod line;

pub mod linear;
mod listing;
mod mountain;
mod names;
mod neighbours;
mod noise;
mod pattern;
pub mod quality;
mod scan;
mod scant;
mod seen;
pub mod symmetry;
mod table;

pub use colorimetry::Colorimetry;
pub use components::{Components, Heard, components};
pub use directions::Directions;
pub use formats::{DenseFile, whole};
pub use pattern::{FEWEST, Pattern};
pub use quality::{Hole, IncidenceQuality, Quality};
pub use scan::{ReadOptions, read};
pub use scant::{Sight, scant};
pub use seen::Seen;
pub use symmetry::{Image, Mirror, Symmetry, SymmetryKind};

/// One measured incident direction with its scattered distribution.
///
/// Points are kept in single precision (6e-8 of a value), 12 bytes and 4 a channel: instruments
/// tell no two values apart that differ by less than 1e-5.
#[derive(Clone, Debug)]
pub struct Incidence {
    /// Incident direction, unit, away from the surface.
    pub wi: DVec3,
    /// Scattered directions, unit, away from the surface, all on one side; in file order.
    pub wo: Directions,
    /// f in 1/sr (no cosine), `channels` values a point, point-major; noise may be negative.
    pub values: Vec<f32>,
    /// The files that it came from.
    pub files: Vec<PathBuf>,
}

impl Incidence {
    /// Of no file: one value a direction and channel.
    pub fn new(
        wi: DVec3,
        wo: impl IntoIterator<Item = DVec3>,
        values: impl IntoIterator<Item = f64>,
    ) -> Self {
        let values = values.into_iter().map(|v| v as f32).collect();
        Self { wi, wo: wo.into_iter().collect(), values, files: Vec::new() }
    }

    /// The values of point `index`, one a channel.
    pub fn point(&self, index: usize) -> &[f32] {
        let channels = self.channels();
        &self.values[index * channels..][..channels]
    }

    /// The value of point `index` in `channel`.
    pub fn value(&self, index: usize, channel: usize) -> f64 {
        f64::from(self.point(index)[channel])
    }

    /// Values a point; 0 of no points.
    pub fn channels(&self) -> usize {
        self.values.len() / self.wo.len().max(1)
    }

    /// The values of all points in `channel`: luminance in [`Colorimetry::luminance_channel`].
    pub fn channel(&self, channel: usize) -> impl Iterator<Item = f64> + Clone {
        self.values.iter().skip(channel).step_by(self.channels().max(1)).map(|&v| f64::from(v))
    }

    /// All points with their values in `channel`.
    pub fn points(&self, channel: usize) -> impl Iterator<Item = (DVec3, f64)> + Clone {
        self.wo.iter().zip(self.channel(channel))
    }

    /// The same distribution seen through `image`: what symmetry says is scattered from
    /// `image.apply(wi)`.
    #[must_use]
    pub fn transformed(&self, image: Image) -> Incidence {
        Incidence {
            wi: image.apply(self.wi),
            wo: self.wo.iter().map(|w| image.apply(w)).collect(),
            values: self.values.clone(),
            files: self.files.clone(),
        }
    }

    /// Gives back the memory that growing took too much.
    fn shrink_to_fit(&mut self) {
        self.wo.shrink_to_fit();
        self.values.shrink_to_fit();
    }
}

/// One component of a material as measured: every incidence on one side, scattered to one side.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// The side that the light comes from.
    pub incident: Side,
    /// The side that it is scattered to; the same as `incident` for reflection.
    pub scattered: Side,
    /// What the values mean.
    pub colorimetry: Colorimetry,
    /// Detected, or given and checked.
    pub symmetry: Symmetry,
    /// In order of polar angle, then azimuth; no two within [`MERGE_DEGREES`].
    pub incidences: Vec<Incidence>,
    /// As the files name the specimen.
    pub sample_name: Option<String>,
    /// What the reader did that a person may want to know: merged, dropped, skipped.
    pub notes: Vec<String>,
}

impl Measurement {
    /// Points over all incidences.
    pub fn points(&self) -> usize {
        self.incidences.iter().map(|i| i.wo.len()).sum()
    }

    /// What steers lobes and plans: of a spectrum the guide alone, else all.
    pub fn guide(&self) -> Cow<'_, Self> {
        if !matches!(self.colorimetry, Colorimetry::Spectral(_)) {
            return Cow::Borrowed(self);
        }
        let y = self.colorimetry.luminance_channel();
        let alone = |i: &Incidence| Incidence {
            wi: i.wi,
            wo: i.wo.clone(),
            values: i.channel(y).map(|v| v as f32).collect(),
            files: i.files.clone(),
        };
        Cow::Owned(Self {
            colorimetry: Colorimetry::Luminance,
            incidences: self.incidences.iter().map(alone).collect(),
            sample_name: self.sample_name.clone(),
            notes: Vec::new(),
            ..*self
        })
    }

    /// Drops the points further than `degrees` from the normal of their side; how many.
    ///
    /// Errors: class argument where an incidence would keep none; nothing is dropped then.
    pub fn cut_grazing(&mut self, degrees: f64) -> Result<usize> {
        // What single precision leaves of points at the limit itself.
        let lowest = degrees.to_radians().cos() - 1e-7;
        let keeps = |w: DVec3| w.z.abs() >= lowest;
        if let Some(bare) = self.incidences.iter().find(|i| !i.wo.iter().any(keeps)) {
            let (theta, phi) = direction::to_degrees(bare.wi);
            return Err(Error::argument(format!(
                "grazing limit {degrees}: expected points within it at incidence theta {theta:.1} phi {phi:.1}, found none"
            )));
        }
        let before = self.points();
        let channels = self.colorimetry.channels();
        for incidence in &mut self.incidences {
            let mut value = (0..).map(|k: usize| keeps(incidence.wo.at(k / channels)));
            incidence.values.retain(|_| value.next() == Some(true));
            incidence.wo.retain(keeps);
        }
        Ok(before - self.points())
    }

    /// The largest incident angle from the normal of its side, degrees: what an instrument that
    /// cannot measure further in than out can also be trusted with when scattered.
    pub fn largest_incident_degrees(&self) -> f64 {
        let lowest = self.incidences.iter().map(|i| i.wi.z.abs()).fold(1.0, f64::min);
        lowest.acos().to_degrees()
    }
}

/// Incident directions nearer than this are one incidence.
///
/// Four decimals of a degree are lost in writing files and instruments repeat to about 0.02°;
/// doubled, two deliberate steps of a fine scan (0.1°) would merge.
pub const MERGE_DEGREES: f64 = 0.05;
