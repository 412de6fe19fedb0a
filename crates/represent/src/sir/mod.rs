//! Radiance's interpolant (SIR): lobes per incidence, transport plans per mesh edge; read and evaluated by its rules.
//!
//! Differs from: our own interpolant, which needs none of these rules. Radiance rounds lobe centres to a grid after every
//! interpolation, softens the cosine at the horizon, cuts lobes in grid distance and depends on the order of vertices;
//! all of this is imitated here, so that a laboratory's old files answer the same values as in Radiance.

mod boxes;
mod bytes;
mod file;
mod grid;
mod mesh;
mod node;
mod plan;
mod slice;
mod whole;

pub use file::{Plans, SirLimits};
pub use node::{SirLobe, SirNode};
pub use plan::{Migration, Plan, PlanEntry};
pub use slice::SirSlice;
pub use whole::Sir;
