//! Functions that a file holds whole.

use std::sync::Arc;

use bsdfkit::Result;
use bsdfkit::foreign::Measured;
use bsdfkit_represent::Dense;

use super::Format;

/// Such functions, as one file holds them.
pub struct DenseFile {
    /// Name of the specimen.
    pub name: Option<String>,
    /// No two of the same pair of sides.
    pub functions: Vec<Arc<dyn Dense>>,
}

impl DenseFile {
    /// Whether files of this format are such functions.
    pub fn holds(kind: Measured) -> bool {
        Format::of(kind).is_dense()
    }

    /// What the bytes of a file hold, if it is of a format of such functions.
    ///
    /// Errors: format; `place` is where the bytes come from, for messages.
    pub fn from_bytes(place: &str, bytes: &[u8]) -> Option<Result<Self>> {
        let found = bsdfkit::foreign::recognise(bytes)?.measured()?;
        Format::of(found).dense(place.as_ref(), bytes)
    }
}
