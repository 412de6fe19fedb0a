//! f, its peaks, its integral and its samples for one incident direction.

mod alone;
pub(crate) mod continuous;
pub(crate) mod distribution;
pub(crate) mod draws;
mod families;
pub(crate) mod lobe_on_disk;
pub(crate) mod quadrature;
pub(crate) mod seen;
