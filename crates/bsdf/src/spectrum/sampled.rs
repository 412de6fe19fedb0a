//! A function of wavelength by its values at even steps.

/// Values at `first`, `first + step`, … nanometres; linear between them, 0 elsewhere.
pub(super) struct Sampled {
    pub(super) first: f64,
    pub(super) step: f64,
    pub(super) values: &'static [f64],
}

impl Sampled {
    pub(super) fn last(&self) -> f64 {
        self.first + self.step * (self.values.len() - 1) as f64
    }

    pub(super) fn at(&self, wavelength: f64) -> f64 {
        if !(self.first..=self.last()).contains(&wavelength) {
            return 0.0;
        }
        let place = (wavelength - self.first) / self.step;
        let k = (place as usize).min(self.values.len() - 2);
        let t = place - k as f64;
        (1.0 - t) * self.values[k] + t * self.values[k + 1]
    }
}
