//! Measurements in the formats of others: one file a format, one line in [`FORMATS`].
//!
//! How a file is known stands in [`bsdfkit::foreign`]; here is how it is read. Each reader gets the file whole, so that
//! sizes that it declares are held against what there is before memory is taken.

use std::path::Path;

use bsdfkit::foreign::Measured;
use bsdfkit::limits::{MEASURED_BYTES, read_file};
use bsdfkit::{Error, Result, Xyz};

use super::Colorimetry;
use super::block::{Block, Budget, FileContent, Remark};
use super::line::Lines;

mod alta;
mod astm;
mod bird;
mod cornell;
mod dense_file;
mod fred;
mod lighttools;
mod merl;
mod rgl;
mod words;
mod zemax;

pub use dense_file::DenseFile;

/// A format and its reader.
#[derive(Debug)]
pub(crate) struct Format {
    kind: Measured,
    read: fn(&Whole<'_>) -> Result<FileContent>,
    /// How it answers without a fit, if it is a function on a grid.
    dense: Option<fn(&Whole<'_>) -> Result<DenseFile>>,
}

/// All of them.
const FORMATS: &[Format] = &[
    Format { kind: Measured::Rgl, read: rgl::read, dense: Some(rgl::dense) },
    Format { kind: Measured::Merl, read: merl::read, dense: Some(merl::dense) },
    Format { kind: Measured::Zemax, read: zemax::read, dense: Some(zemax::dense) },
    Format { kind: Measured::LightTools, read: lighttools::read, dense: None },
    Format { kind: Measured::Astm, read: astm::read, dense: None },
    Format { kind: Measured::Fred, read: fred::read, dense: None },
    Format { kind: Measured::Cornell, read: cornell::read, dense: None },
    Format { kind: Measured::Alta, read: alta::read, dense: None },
    Format { kind: Measured::Bird, read: bird::read, dense: None },
];

impl Format {
    /// The format that was recognised.
    pub(crate) fn of(kind: Measured) -> &'static Self {
        FORMATS.iter().find(|f| f.kind == kind).expect("each has a line in the table")
    }

    /// Reads a file of it, and tells what it was taken for.
    pub(super) fn read(&self, path: &Path, budget: &Budget) -> Result<FileContent> {
        let bytes = whole(path)?;
        let mut content = (self.read)(&Whole { path, bytes: &bytes, budget })?;
        let also = if self.is_dense() { ", which answers values without a fit, too" } else { "" };
        let text = format!("read as {}{also}", self.kind.foreign().name);
        content.colorimetry = content
            .colorimetry
            .spectral(&mut content.blocks)
            .map_err(|e| Error::format(e.to_string()).context(path.display()))?;
        content.remarks.insert(0, Remark::of_file(text));
        Ok(content)
    }

    /// Whether it is a function on a grid.
    pub(crate) fn is_dense(&self) -> bool {
        self.dense.is_some()
    }

    /// The functions in the file at `place`, of such formats.
    pub(crate) fn dense(&self, place: &Path, bytes: &[u8]) -> Option<Result<DenseFile>> {
        let budget = Budget::new(u64::MAX);
        self.dense.map(|dense| dense(&Whole { path: place, bytes, budget: &budget }))
    }
}

/// The bytes of the file at `path`.
///
/// Errors: io; limit.
pub fn whole(path: &Path) -> Result<Vec<u8>> {
    read_file(path, MEASURED_BYTES)
}

/// A file, whole.
pub(crate) struct Whole<'a> {
    pub(crate) path: &'a Path,
    pub(crate) bytes: &'a [u8],
    budget: &'a Budget,
}

impl<'a> Whole<'a> {
    /// Its lines.
    fn lines(&self) -> Lines<'a> {
        Lines::of(self.path, self.bytes)
    }

    /// A format error about the file as a whole.
    pub(crate) fn error(&self, message: impl Into<String>) -> Error {
        Error::format(message).context(self.path.display())
    }
}

/// R, G, B as CIE XYZ, other channels as they are; whatever of a colour is below 0 is counted and 0.
fn as_xyz(
    colorimetry: Colorimetry,
    blocks: &mut [Block],
    remarks: &mut Vec<Remark>,
) -> Colorimetry {
    let Colorimetry::Named(names) = &colorimetry else { return colorimetry };
    let of = |known: [&str; 3]| known.map(|k| names.iter().position(|n| n.eq_ignore_ascii_case(k)));
    let found = [of(["r", "g", "b"]), of(["red", "green", "blue"])];
    let found = found.into_iter().find(|f| f.iter().all(Option::is_some));
    let (3, Some([Some(r), Some(g), Some(b)])) = (names.len(), found) else { return colorimetry };
    let mut cut = 0_usize;
    for point in blocks.iter_mut().flat_map(|b| b.values.chunks_exact_mut(3)) {
        let colour = Xyz::from_linear_rgb([point[r], point[g], point[b]].map(f64::from));
        let xyz = [colour.x, colour.y, colour.z];
        cut += xyz.iter().filter(|v| **v < 0.0).count();
        point.copy_from_slice(&xyz.map(|v| v.max(0.0) as f32));
    }
    if cut > 0 {
        remarks.push(Remark::of_file(format!("{cut} tristimulus values below 0 taken as 0")));
    }
    Colorimetry::Xyz
}
