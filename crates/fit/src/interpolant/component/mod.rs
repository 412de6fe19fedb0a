//! The parts of one pair of sides put together.

#[expect(clippy::module_inception, reason = "the type gives the room its name")]
pub(crate) mod component;
pub(crate) mod coverage;
pub(crate) mod probes;
