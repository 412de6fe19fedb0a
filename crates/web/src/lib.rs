//! What the viewer's page asks of a file, in WebAssembly: everything that is more than drawing.
//!
//! The page hands over the bytes of a file and gets a [`Surface`], or [`Points`] that were measured; of that it asks numbers
//! for one incident direction at a time. Angles are in degrees, values f in 1/sr, directions three numbers
//! each, as CONVENTIONS.md says. Arrays are flat, so that JavaScript sees them without copying twice.

mod about;
mod cells;
mod lobe;
mod map;
mod points;
mod scene;
mod section;
mod selection;
mod surface;

pub use lobe::Lobe;
pub use map::{map_direction, map_place};
pub use points::{Points, SeenPoints};
pub use selection::Selection;
pub use surface::Surface;

use bsdfkit_sphere::direction;
use wasm_bindgen::prelude::wasm_bindgen;

/// (θ, φ) in degrees → unit vector.
#[wasm_bindgen]
pub fn from_degrees(theta: f64, phi: f64) -> Vec<f64> {
    direction::from_degrees(theta, phi).to_array().into()
}

/// Unit vector → (θ, φ) in degrees.
#[wasm_bindgen]
pub fn to_degrees(x: f64, y: f64, z: f64) -> Vec<f64> {
    let (theta, phi) = direction::to_degrees(bsdfkit::DVec3::new(x, y, z));
    vec![theta, phi]
}
