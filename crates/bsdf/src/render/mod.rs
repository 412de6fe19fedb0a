//! The render form: a function of two directions in tables that move along with its peaks.
//!
//! Nodes of incident directions stand closely enough for blending ([`Chart`]). Each layer of the function follows a peak: at
//! every incidence it has a middle and a width ([`Pose`]), and about them, in polar coordinates, one small table of
//! values a node ([`Layer`]). A value is a blend of the same place in the tables of the nodes about the incidence, times
//! a factor that gives every incidence its energy:
//! f(ωi, ωo) = g(ωi) Σ_l Σ_n w_n(ωi) T_ln(q_l(ωi, ωo)).
//!
//! Samples are drawn from a second table a node, of f |cos θo| over areas of the plane that end where the hemisphere
//! does. These are blended as the values are, so that the density is that mixture exactly, and the weights of
//! samples vary a little.

mod chart;
mod distribution;
mod drawing;
mod draws;
mod flat;
mod frame;
mod grid;
mod half;
mod hues;
mod incidence;
mod known;
mod layer;
mod logarithm;
mod loops;
mod polar;
mod shape;
mod spot;
mod table;

pub use chart::{Chart, Fold};
pub use flat::{FlatLayer, FlatRender};
pub use frame::{Frame, FrameKind, Pose};
pub use grid::{Place, View};
pub use half::Half;
pub use hues::Hues;
pub(crate) use layer::Arrays;
pub use layer::{Content, Layer};
pub use shape::Shape;
pub use table::RenderTable;
