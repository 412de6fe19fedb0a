//! What a file is made of.

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
