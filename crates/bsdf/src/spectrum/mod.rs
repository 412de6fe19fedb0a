//! Spectra: bands of wavelengths, and what an eye or the sun makes of them.
//!
//! Values of many bands become one value or three by weights: [`View::weights`] tells them. Colour is computed as
//! ASTM E308 does it: the measured spectrum, linear between bands, times illuminant and observer, summed at every nanometre.

mod bands;
mod basis;
mod hue;
mod sampled;
mod tables;
mod verbs;
mod view;

pub use bands::Bands;
pub use basis::Basis;
pub use hue::Hue;
pub use view::{Illuminant, View, Weights};
