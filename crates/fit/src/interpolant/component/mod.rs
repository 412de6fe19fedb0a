//! The parts of one pair of sides put together, in three steps: `fitted`, `planned`, and balanced (`component`).

#[expect(clippy::module_inception, reason = "the type gives the room its name")]
pub(crate) mod component;
pub(crate) mod coverage;
pub(crate) mod fitted;
mod located;
mod on_facets;
pub(crate) mod planned;
mod probes;
