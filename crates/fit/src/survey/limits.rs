//! What the instrument can do.

use bsdfkit::{Error, Result};

/// What the instrument can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest incident angle from the normal.
    pub max_theta_degrees: f64,
    /// Least distance of a new incidence from any other, and from its own images.
    pub spacing_degrees: f64,
}

impl Limits {
    /// Errors: argument, naming the limit, expected and found.
    pub(super) fn validate(&self) -> Result<()> {
        let ranges = [
            ("largest theta", self.max_theta_degrees, 1.0, 89.9),
            ("spacing", self.spacing_degrees, 0.1, 45.0),
        ];
        for (name, value, low, high) in ranges {
            if !(low..=high).contains(&value) {
                let text = format!("{name}: expected {low} to {high} degrees, found {value}");
                return Err(Error::argument(text));
            }
        }
        Ok(())
    }

    /// The least distance as a chord.
    pub(super) fn spacing(&self) -> f64 {
        2.0 * (0.5 * self.spacing_degrees.to_radians()).sin()
    }
}
