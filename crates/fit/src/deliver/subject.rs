//! What a file is made of.

use std::borrow::Cow;

use bsdfkit::Bsdf;

use crate::interpolant::Interpolant;

/// What is tabulated.
#[derive(Clone, Copy, Debug)]
pub enum Subject<'a> {
    /// Trees or matrices.
    Stored(&'a Bsdf),
    /// A function to be evaluated.
    Continuous(&'a Interpolant),
}

impl<'a> Subject<'a> {
    /// What answers queries.
    pub fn bsdf(self) -> Cow<'a, Bsdf> {
        match self {
            Self::Stored(bsdf) => Cow::Borrowed(bsdf),
            Self::Continuous(interpolant) => Cow::Owned(interpolant.bsdf()),
        }
    }
}
