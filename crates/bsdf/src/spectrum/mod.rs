//! Spectra: bands of wavelengths, and what an eye or the sun makes of them.
//!
//! Values of many bands become one value or three by weights: [`View::weights`] tells them. Colour is computed as
//! ASTM E308 does it: the measured spectrum, linear between bands, times illuminant and observer, summed at every nanometre.

mod bands;
mod sampled;
mod tables;
mod view;

pub use bands::Bands;
pub use view::{Illuminant, View, Weights};
