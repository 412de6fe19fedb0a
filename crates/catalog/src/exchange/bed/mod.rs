//! BED-JSON (buildingenvelopedata.org): directional-hemispherical values and what is told of a component, read and written.
//!
//! Source: `schemas/opticalData.json` of github.com/building-envelope-data/api, version 1.1.0, and its `component.json` of
//! before, which holds names and makers too. Results are ratios of irradiances: those into one direction have no solid
//! angle beside them, so that nothing of it is a value of f, and what the format shares with a BSDF are totals.

mod place;
mod read;
mod write;

pub use read::{OpticalData, Total, is_bed, read};
pub use write::write;
