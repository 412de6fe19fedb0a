//! Directions on the sphere, ways to number them, and loops over many of them. Imports nothing of
//! ours.
//!
//! Conventions are those of CONVENTIONS.md: right-handed frame, +Z the front normal, unit
//! vectors pointing away from the surface.
//!
//! ```
//! use bsdfkit_sphere::concentric::{hemisphere_to_square, square_to_hemisphere};
//! use bsdfkit_sphere::{DVec2, Side, direction::from_degrees};
//!
//! let w = from_degrees(30.0, 210.0);
//! assert_eq!(Side::of(w), Side::Front);
//! // Equal areas of the square are equal projected solid angles of the hemisphere.
//! let back = square_to_hemisphere(hemisphere_to_square(w), Side::Front);
//! assert!(w.distance(back) < 1e-12);
//! let middle = square_to_hemisphere(DVec2::splat(0.5), Side::Front);
//! assert!(middle.distance(from_degrees(0.0, 0.0)) < 1e-12);
//! ```

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
