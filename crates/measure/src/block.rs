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

/// What the points may still take, shared by the files under way.
pub(super) struct Budget {
    most: u64,
    spent: AtomicU64,
}

impl Budget {
    /// So many bytes of points.
    pub(super) fn new(most: u64) -> Self {
        Self { most, spent: AtomicU64::new(0) }
    }

    /// Rows a file reads between two looks at what the others did.
    const STEP: u64 = 4096;

    /// Counts so many rows of `channels` values at once.
    pub(super) fn spend_all(&self, rows: u64, channels: usize, path: &Path) -> Result<()> {
        let bytes = rows.saturating_mul(bytes_of_point(channels));
        if self.spent.fetch_add(bytes, Ordering::Relaxed).saturating_add(bytes) > self.most {
            return Err(too_much(self.most, None).context(path.display()));
        }
        Ok(())
    }

    /// Counts one more row of a file, of `channels` values.
    pub(super) fn spend(&self, count: &mut u64, channels: usize, path: &Path) -> Result<()> {
        *count += 1;
        if count.is_multiple_of(Self::STEP) {
            return self.spend_all(Self::STEP, channels, path);
        }
        Ok(())
    }

    /// Points of `rows` rows are held no more.
    pub(super) fn give_back(&self, rows: u64, channels: usize) {
        let bytes = rows / Self::STEP * Self::STEP * bytes_of_point(channels);
        let less = |spent: u64| Some(spent.saturating_sub(bytes));
        // It never fails: there is always a number.
        let _ = self.spent.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less);
    }
}

/// What a point of `channels` values takes: its direction, its values.
pub(super) fn bytes_of_point(channels: usize) -> u64 {
    12 + 4 * channels as u64
}

/// More points than may be held at once: `found` bytes, where that is known.
pub(super) fn too_much(most: u64, found: Option<u64>) -> Error {
    let megabytes = |bytes: u64| format!("{:.2} MB", bytes as f64 * 1e-6);
    let found = found.map_or("more".into(), megabytes);
    let text = format!("expected points of at most {}, found {found}", megabytes(most));
    Error::limit(format!("{text} (12 bytes and 4 a value each)"))
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
