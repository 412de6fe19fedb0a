//! Directions on the sphere, ways to number them, and loops over many of them. Imports nothing of ours.
//!
//! Conventions are those of CONVENTIONS.md: right-handed frame, +Z the front normal, unit
//! vectors pointing away from the surface.

pub mod concentric;
pub mod delaunay;
pub mod direction;
pub mod frame;
pub mod hilbert;
pub mod locate;
pub mod octant;
pub mod sequence;
pub mod side;
pub mod widest;

pub use frame::Frame;
pub use glam::{DVec2, DVec3};
pub use side::Side;
