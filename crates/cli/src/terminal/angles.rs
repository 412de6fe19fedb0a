//! Directions as people write them: θ and φ in degrees.

use std::str::FromStr;

use bsdfkit::{DVec3, Error, Result};
use bsdfkit_sphere::direction;

/// A direction away from the surface: θ 0–180 from the front normal, φ from +X toward +Y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Angles {
    /// θ in degrees.
    pub(crate) theta: f64,
    /// φ in degrees.
    pub(crate) phi: f64,
}

impl Angles {
    /// Errors: argument, for angles that are not finite or θ outside 0–180.
    pub(crate) fn new(theta: f64, phi: f64) -> Result<Self> {
        if !(0.0..=180.0).contains(&theta) {
            return Err(Error::argument(format!(
                "theta: expected 0 to 180 degrees, found {theta}"
            )));
        }
        if !phi.is_finite() {
            return Err(Error::argument(format!("phi: expected a finite angle, found {phi}")));
        }
        Ok(Self { theta, phi })
    }

    /// The unit vector.
    pub(crate) fn direction(self) -> DVec3 {
        direction::from_degrees(self.theta, self.phi)
    }
}

impl FromStr for Angles {
    type Err = Error;

    /// `30,45` or `30 45`; `30` alone has φ = 0.
    fn from_str(text: &str) -> Result<Self> {
        let words: Vec<&str> = text.split([',', ' ']).filter(|w| !w.is_empty()).collect();
        let number = |word: &str| {
            word.parse::<f64>().map_err(|_| {
                Error::argument(format!("expected an angle in degrees, found {word:?}"))
            })
        };
        match words[..] {
            [theta] => Self::new(number(theta)?, 0.0),
            [theta, phi] => Self::new(number(theta)?, number(phi)?),
            _ => Err(Error::argument(format!("expected THETA,PHI in degrees, found {text:?}"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_read_and_bounded() {
        assert_eq!("30,45".parse::<Angles>().unwrap(), Angles { theta: 30.0, phi: 45.0 });
        assert_eq!("170".parse::<Angles>().unwrap(), Angles { theta: 170.0, phi: 0.0 });
        for bad in ["", "1,2,3", "a,b", "-1,0", "181,0", "nan,0", "10,inf"] {
            assert!(bad.parse::<Angles>().is_err(), "{bad:?}");
        }
    }
}
