//! Compiled BSDFs, render forms and interpolants: safetensors files.

use bsdfkit::container;
use bsdfkit_fit::interpolant::{Encoding, Interpolant};
use bsdfkit_fit::open::{self, Access, Opened};

use crate::ask::{Trust, ask};
use crate::scratch::with_file;

/// Any bytes as a container: read whole, and a compiled BSDF opened in place, too.
pub fn container(bytes: &[u8]) {
    if let Ok((_, opened)) = open::open_bytes(bytes) {
        if let Opened::Interpolant(interpolant) = &opened {
            again(interpolant);
        }
        ask(&opened.into_bsdf(), Trust::Checked);
    }
    let in_place = with_file("compiled.safetensors", bytes, |path| {
        container::kind(path).expect("the file is there");
        open::open(path, Access::InPlace)
    });
    if let Ok((_, Opened::Bsdf(bsdf, _))) = in_place {
        ask(&bsdf, Trust::Unchecked);
    }
}

/// Written and read again, it has the same parts.
fn again(interpolant: &Interpolant) {
    for encoding in [Encoding::Plain, Encoding::Compact] {
        let Ok(bytes) = interpolant.to_bytes(encoding) else { continue };
        let read = Interpolant::from_bytes(&bytes);
        let read = read.unwrap_or_else(|e| panic!("what was written cannot be read: {e}"));
        assert_eq!(read.components.len(), interpolant.components.len());
    }
}
