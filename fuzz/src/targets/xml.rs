//! The XML of WINDOW and Radiance: read, examined, mended, written and read again.

use bsdfkit::xml::{self, Limits, WriteOptions, doctor};

use crate::ask::{Trust, ask};

/// What a person's file would need at most; larger ones take time and show nothing new.
fn limits() -> Limits {
    Limits { values: 1 << 20, tree_depth: 8, ..Limits::default() }
}

/// Any bytes as an XML file.
pub fn xml(bytes: &[u8]) {
    let limits = limits();
    let Ok((bsdf, _)) = xml::from_bytes(bytes, &limits) else {
        doctor::examine(bytes, &limits);
        return;
    };
    ask(&bsdf, Trust::Checked);
    let mut written = Vec::new();
    if xml::write_to(&bsdf, &mut written, &WriteOptions::default()).is_ok() {
        let read = xml::from_bytes(&written, &Limits::default());
        read.unwrap_or_else(|e| panic!("what was written cannot be read: {e}"));
    }
    // An examination draws thousands of samples: once of some.
    if bytes.len().is_multiple_of(8)
        && let Ok(mended) = doctor::mend(bytes, &[], &limits)
    {
        let again = doctor::mend(&mended.bytes, &[], &limits).expect("a copy is read");
        assert_eq!(again.bytes, mended.bytes, "mending twice changes nothing");
    }
}
