//! Peaks of no width, told apart from what is scattered about them.
//!
//! An instrument shows a peak that has no width as its own [`Signature`]: as wide as its aperture and beam, whatever the
//! material. `candidate` finds such peaks of each incidence, `agreement` those of several incidences that stand where one
//! law says, `footprint` how much light each holds over the smooth surround and what the surround is below it, `course`
//! how the coefficient goes on between incidences. [`separate`] does all of it.
//!
//! Without a signature nothing is separated: what the instrument cannot resolve is then not known.

mod agreement;
mod candidate;
mod course;
mod footprint;
mod separate;
mod signature;

pub use separate::{FoundPeak, Separated, separate};
pub use signature::Signature;
