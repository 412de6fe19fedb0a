//! What one file holds before it is sorted.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use bsdfkit::{DVec3, Error, Result};

use super::{Colorimetry, Directions};

/// A row nearer than this to the horizon (as a cosine, 0.006°) belongs to neither side, and a DSF
/// there holds no BSDF: one part in 10⁴ is the last digit that files of DSF carry.
pub(super) const HORIZON_COSINE: f64 = 1e-4;

/// One incident direction in one file; its points may lie on both sides.
pub(super) struct Block {
    pub(super) wi: DVec3,
    pub(super) wo: Directions,
    pub(super) values: Vec<f32>,
}

impl Block {
    /// No points yet.
    pub(super) fn new(wi: DVec3) -> Self {
        Self { wi, wo: Directions::new(), values: Vec::new() }
    }

    /// Gives back the memory that growing took too much.
    pub(super) fn shrink_to_fit(&mut self) {
        self.wo.shrink_to_fit();
        self.values.shrink_to_fit();
    }
}

/// The rows that may still be read, shared by the files under way.
pub(super) struct Budget {
    max: u64,
    spent: AtomicU64,
}

impl Budget {
    pub(super) fn new(max: u64) -> Self {
        Self { max, spent: AtomicU64::new(0) }
    }

    /// Rows a file reads between two looks at what the others did.
    const STEP: u64 = 4096;

    /// Counts so many rows at once.
    pub(super) fn spend_all(&self, count: u64, path: &Path) -> Result<()> {
        if self.spent.fetch_add(count, Ordering::Relaxed).saturating_add(count) > self.max {
            let message = format!("expected at most {} rows in all, found more", self.max);
            return Err(Error::limit(message).context(path.display()));
        }
        Ok(())
    }

    /// Counts one more row of a file.
    pub(super) fn spend(&self, count: &mut u64, path: &Path) -> Result<()> {
        *count += 1;
        if count.is_multiple_of(Self::STEP)
            && self.spent.fetch_add(Self::STEP, Ordering::Relaxed) + Self::STEP > self.max
        {
            let message = format!("expected at most {} rows in all, found more", self.max);
            return Err(Error::limit(message).context(path.display()));
        }
        Ok(())
    }
}

/// What one file holds.
pub(super) struct FileContent {
    pub(super) path: PathBuf,
    pub(super) sample_name: Option<String>,
    pub(super) colorimetry: Colorimetry,
    pub(super) blocks: Vec<Block>,
    pub(super) remarks: Vec<Remark>,
    /// Of its values in nanometres, where the file holds one wavelength of several.
    pub(super) wavelength: Option<f64>,
}

/// What a reader did in one file that a person may want to know.
pub(super) struct Remark {
    /// Where, if it is about one line.
    pub(super) line: Option<u64>,
    pub(super) text: String,
}

impl Remark {
    /// A remark about the file as a whole.
    pub(super) fn of_file(text: String) -> Self {
        Self { line: None, text }
    }
}
