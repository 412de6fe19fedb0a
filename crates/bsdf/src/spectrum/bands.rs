//! The wavelengths of a spectral measurement.

use std::fmt;

use crate::{Error, Result};

/// Wavelengths of bands in nanometres, rising.
#[derive(Clone, Debug, PartialEq)]
pub struct Bands(Vec<f64>);

impl Bands {
    /// Most bands: every nanometre from 300 to 800, and some.
    pub const MOST: usize = 512;
    /// Shortest and longest wavelength in nm: from ultraviolet to what windows are made for.
    pub const RANGE: [f64; 2] = [200.0, 3000.0];

    /// Bands at these wavelengths in nanometres.
    ///
    /// Errors: argument unless there are 2 to [`Bands::MOST`] of them, each within [`Bands::RANGE`] and above the one before.
    pub fn new(nanometres: Vec<f64>) -> Result<Self> {
        if !(2..=Self::MOST).contains(&nanometres.len()) {
            return Err(Error::argument(format!(
                "wavelengths: expected 2 to {}, found {}",
                Self::MOST,
                nanometres.len()
            )));
        }
        let [least, most] = Self::RANGE;
        if let Some(w) = nanometres.iter().find(|w| !(least..=most).contains(*w)) {
            return Err(Error::argument(format!(
                "wavelength: expected {least} to {most} nm, found {w}"
            )));
        }
        if let Some(pair) = nanometres.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(Error::argument(format!(
                "wavelengths: expected each above the one before, found {} after {} nm",
                pair[1], pair[0]
            )));
        }
        Ok(Self(nanometres))
    }

    /// The wavelengths in nanometres.
    pub fn nanometres(&self) -> &[f64] {
        &self.0
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Shares of the bands in the value at `wavelength`: linear between neighbours, beyond the ends the last band's.
    pub(super) fn shares(&self, wavelength: f64) -> [(usize, f64); 2] {
        let k = self.0.partition_point(|w| *w <= wavelength);
        if k == 0 {
            return [(0, 1.0), (0, 0.0)];
        }
        let Some(next) = self.0.get(k) else { return [(k - 1, 1.0), (k - 1, 0.0)] };
        let t = (wavelength - self.0[k - 1]) / (next - self.0[k - 1]);
        [(k - 1, 1.0 - t), (k, t)]
    }

    /// Whether `wavelength` lies between bands, or beyond the last by no more than its distance to the one before.
    pub(super) fn reach(&self, wavelength: f64) -> bool {
        let (first, last) = (self.0[0], self.0[self.0.len() - 1]);
        let below = self.0[1] - first;
        let above = last - self.0[self.0.len() - 2];
        (first - below..=last + above).contains(&wavelength)
    }
}

impl fmt::Display for Bands {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bands, {} to {} nm", self.0.len(), self.0[0], self.0[self.0.len() - 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_row_of_wavelengths_is_refused_with_its_place() {
        let found = |w: &[f64]| Bands::new(w.to_vec()).expect_err("refused").to_string();
        assert!(found(&[500.0]).contains("found 1"));
        assert!(found(&[500.0, 480.0]).contains("found 480 after 500"));
        assert!(found(&[0.5, 0.6]).contains("found 0.5"));
        assert!(found(&[500.0, f64::NAN]).contains("NaN"));
    }

    #[test]
    fn shares_are_linear_and_end_with_the_last_band() {
        let bands = Bands::new(vec![400.0, 500.0, 520.0]).expect("bands");
        assert_eq!(bands.shares(425.0), [(0, 0.75), (1, 0.25)]);
        assert_eq!(bands.shares(515.0), [(1, 0.25), (2, 0.75)]);
        assert_eq!(bands.shares(380.0)[0], (0, 1.0));
        assert_eq!(bands.shares(900.0)[0], (2, 1.0));
        assert!(bands.reach(330.0) && !bands.reach(299.0) && bands.reach(540.0));
        assert!(!bands.reach(541.0));
    }
}
