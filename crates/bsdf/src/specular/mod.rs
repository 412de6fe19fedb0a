//! Specular components: peaks of no width, each by a law, beside the distributions of a [`Bsdf`](crate::Bsdf).
//!
//! The scattered part is τ(ωi) δ(uo − A ui − g), with u the direction cosines along X and Y: a [`Law`] says where the
//! light goes, a [`Curve`] how much. [`Bsdf::eval`](crate::Bsdf::eval) cannot tell of it and leaves it out;
//! directional-hemispherical values, samples and the density beside them have it. Whoever asks for single directions
//! (shadow rays, the sun) adds [`Bsdf::specular_peaks`](crate::Bsdf::specular_peaks).

mod answer;
pub(crate) mod cells;
mod curve;
mod described;
mod extract;
mod law;

pub use answer::SpecularPeak;
pub use curve::Curve;
pub use described::Described;
pub use law::Law;

use crate::{Error, Result, Side};

/// A family of peaks without width between one pair of sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Specular {
    /// Side of the incident directions.
    pub incident: Side,
    /// Side of the scattered directions.
    pub scattered: Side,
    /// Where the light goes.
    pub law: Law,
    /// How much of it: the reflected or transmitted share of the incident light.
    pub coefficient: Curve,
    /// Diameter of the cone within which an instrument could not tell the peak from one of no width, degrees; 0 of an
    /// ideal one. A note on where it comes from: queries take every peak to have no width.
    pub width_degrees: f64,
    /// How well measured coefficients are foretold by the others, root mean square over the largest; `None`: not known.
    pub residual: Option<f64>,
}

impl Specular {
    /// Largest [`width_degrees`](Self::width_degrees) that is believed.
    pub const MOST_DEGREES: f64 = 20.0;

    /// An ideal one.
    pub fn new((incident, scattered): (Side, Side), law: Law, coefficient: Curve) -> Self {
        Self { incident, scattered, law, coefficient, width_degrees: 0.0, residual: None }
    }

    /// Whether light crosses the surface.
    pub fn is_transmission(&self) -> bool {
        self.incident != self.scattered
    }

    /// The same peak for light that travels the other way along the same path: as much of it goes on.
    ///
    /// Accuracy: the curve is tabulated anew, exactly where the law turns directions by half a turn or not at all and the
    /// azimuths are even in number or one.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let law = self.law.reversed();
        let coefficient = self.coefficient.moved(|w| law.scattered(w, Side::Front));
        Self { incident: self.scattered, scattered: self.incident, law, coefficient, ..*self }
    }

    /// Whether turning a specimen about its normal leaves the peak as it is.
    pub fn is_isotropic(&self) -> bool {
        self.law.is_isotropic() && self.coefficient.shape()[1] == 1
    }

    /// As a person calls it: "mirror", "straight through", "refracted, index 1.52".
    pub fn name(&self) -> String {
        self.law.name(self.is_transmission())
    }

    /// Refuses a width that no instrument has.
    ///
    /// Errors: argument.
    pub fn expect_sound(&self) -> Result<()> {
        let most = Self::MOST_DEGREES;
        match (0.0..=most).contains(&self.width_degrees) {
            true => Ok(()),
            false => Err(Error::argument(format!(
                "width of a specular peak: expected 0 to {most} degrees, found {}",
                self.width_degrees
            ))),
        }
    }
}
