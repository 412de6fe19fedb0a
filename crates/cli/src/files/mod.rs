//! What a file holds, how it is opened and written, and what is said of it.

pub(crate) mod component;
pub(crate) mod instrument;
pub(crate) mod labels;
pub(crate) mod load;
pub(crate) mod output;
pub(crate) mod seen;
pub(crate) mod surface;
pub(crate) mod tabulation;
pub(crate) mod target;
pub(crate) mod told;
