//! What a file for a program holds: the form, the bands and sides that the program reads, and what of the
//! description stays true.

mod consumer;
mod kind;
mod mended;
mod order;
mod subject;

pub use consumer::{Consumer, alone};
pub use kind::Kind;
pub use mended::{Change, Mended, mend};
pub use order::{Delivered, Order};
pub use subject::Subject;
