//! What tables keep of spectra: how bands follow from a luminance and a few coefficients.

use super::basis::Basis;
use crate::{Error, Result};

/// Spectra beside a table's luminance: f of every band from the luminance and the coefficients stored for a pair of directions.
///
/// Bands add up to the luminance as it is stored: Σ weights · f = luminance.
#[derive(Clone, Debug, PartialEq)]
pub struct Hue {
    basis: Basis,
    weights: Vec<f64>,
    epsilon: f64,
    /// Of each coefficient, the least and how far the others go above it: stored ones are shares of that.
    range: Vec<[f64; 2]>,
}

/// Where less is left, the basis has a factor of all bands itself.
const SPANNED: f64 = 1e-3;

/// A band differs from the luminance by this factor at most: more is noise of what is nearly dark.
const LIMIT: f64 = 30.0;

impl Hue {
    /// Spectra of this basis. `weights`: what the luminance is of bands; `epsilon` (1/sr): where f is less, hue fades.
    ///
    /// Errors: argument, for as many weights as there are bands not, or numbers that are not finite.
    pub fn new(basis: Basis, weights: Vec<f64>, epsilon: f64) -> Result<Self> {
        let bands = basis.bands().count();
        if weights.len() != bands || !weights.iter().all(|w| w.is_finite()) {
            return Err(Error::argument(format!(
                "weights of the luminance: expected {bands} finite numbers, found {weights:?}"
            )));
        }
        if !(epsilon.is_finite() && epsilon > 0.0) {
            return Err(Error::argument(format!(
                "epsilon: expected a number above 0, found {epsilon}"
            )));
        }
        let range = vec![[0.0, 1.0]; basis.rank()];
        Ok(Self { basis, weights, epsilon, range })
    }

    /// The same, of whose coefficients these are the least and the length of their range.
    ///
    /// Errors: argument, for numbers that are not finite, a length below 0, or another count.
    pub fn with_range(self, range: Vec<[f64; 2]>) -> Result<Self> {
        let sound = |[least, length]: &[f64; 2]| (least + length).is_finite() && *length >= 0.0;
        if range.len() != self.basis.rank() || !range.iter().all(sound) {
            return Err(Error::argument(format!(
                "range of coefficients: expected {} finite ones, found {range:?}",
                self.basis.rank()
            )));
        }
        Ok(Self { range, ..self })
    }

    /// The same with the range of these coefficients, as [`Hue::tell`] tells them.
    ///
    /// Errors: argument, where one is not finite.
    pub fn of_all<'a, T: Copy + Into<f64> + 'a>(
        self,
        coefficients: impl Iterator<Item = &'a [T]>,
    ) -> Result<Self> {
        let rank = self.basis.rank();
        let mut bounds = vec![[f64::INFINITY, f64::NEG_INFINITY]; rank];
        for v in coefficients.flat_map(|all| all.chunks_exact(rank)) {
            for ([least, most], v) in bounds.iter_mut().zip(v) {
                let v: f64 = (*v).into();
                (*least, *most) = (least.min(v), most.max(v));
            }
        }
        let range =
            |[least, most]: [f64; 2]| if least <= most { [least, most - least] } else { [0.0; 2] };
        let range = bounds.into_iter().map(range).collect();
        self.with_range(range)
    }

    /// The range of each coefficient: the least, and its length.
    pub fn range(&self) -> &[[f64; 2]] {
        &self.range
    }

    /// Coefficient `k` as it is stored: from 0 to 1.
    pub fn stored(&self, k: usize, coefficient: f64) -> f64 {
        let [least, length] = self.range[k];
        if length > 0.0 { ((coefficient - least) / length).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// How bands are made of coefficients.
    pub fn basis(&self) -> &Basis {
        &self.basis
    }

    /// What the luminance is of bands.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Where f is less (1/sr), hue fades.
    pub fn epsilon(&self) -> f64 {
        self.epsilon
    }

    /// The luminance of bands, 1/sr.
    pub fn luminance(&self, bands: &[f64]) -> f64 {
        self.weights.iter().zip(bands).map(|(w, f)| w * f).sum::<f64>().max(0.0)
    }

    /// Appends the coefficients of f of all bands, 1/sr.
    pub fn tell(&self, bands: &[f64], out: &mut Vec<f64>) {
        let epsilon = self.epsilon;
        let guide = self.luminance(bands) + epsilon;
        let log = |f: &f64| ((f.max(0.0) + epsilon) / guide).clamp(1.0 / LIMIT, LIMIT).ln();
        let mut logs: Vec<f64> = bands.iter().map(log).collect();
        // A factor of all bands is not told: the luminance sets it. It is what is left of it beside the basis that tells it.
        let off = |(log, offset): (&f64, &f64)| log - offset;
        let apart = self.beside();
        let (mut along, mut all) = (0.0, 0.0);
        for (r, d) in apart.iter().zip(logs.iter().zip(self.basis.offset()).map(off)) {
            (along, all) = (along + r * d, all + r);
        }
        let factor = if all > SPANNED * apart.len() as f64 { along / all } else { 0.0 };
        logs.iter_mut().for_each(|log| *log -= factor);
        out.extend(self.basis.coefficients(&logs));
    }

    /// What the basis leaves of the same number in all bands.
    fn beside(&self) -> Vec<f64> {
        let mut left = vec![1.0; self.weights.len()];
        for row in self.basis.rows() {
            let mean = row.iter().sum::<f64>() / row.len() as f64;
            left.iter_mut().zip(row).for_each(|(left, b)| *left -= mean * b);
        }
        left
    }

    /// f in 1/sr of all bands where the luminance is `y` and these are the coefficients as they are stored.
    pub fn bands(&self, y: f64, stored: &[f64], out: &mut [f64]) {
        out.copy_from_slice(self.basis.offset());
        for ((s, [least, length]), row) in stored.iter().zip(&self.range).zip(self.basis.rows()) {
            let a = least + length * s;
            out.iter_mut().zip(row).for_each(|(out, b)| *out += a * b);
        }
        let (epsilon, guide) = (self.epsilon, y + self.epsilon);
        let most = LIMIT.ln();
        for out in &mut *out {
            *out = (guide * out.clamp(-most, most).exp() - epsilon).max(0.0);
        }
        let told = self.luminance(out);
        // What is too dark to tell, or no number, is grey.
        let scale = y / told;
        if scale <= LIMIT {
            out.iter_mut().for_each(|out| *out *= scale);
        } else {
            out.fill(y);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Bands;

    fn hue() -> Hue {
        let bands = Bands::new(vec![450.0, 550.0, 650.0]).expect("bands");
        let root = 1.5_f64.sqrt();
        let rows = vec![vec![root, 0.0, -root]];
        let basis = Basis::new(bands, vec![0.1, 0.0, -0.1], rows, 0.0).expect("a basis");
        Hue::new(basis, vec![0.2, 0.6, 0.2], 1e-3).expect("a hue")
    }

    #[test]
    fn bands_come_back_and_add_up_to_the_luminance() {
        let hue = hue();
        let (mut bands, mut again, mut coefficients) = ([0.0; 3], [0.0; 3], Vec::new());
        for (y, a) in [(0.3, 0.4), (20.0, -0.8), (0.02, 0.0)] {
            hue.bands(y, &[a], &mut bands);
            assert!((hue.luminance(&bands) / y - 1.0).abs() < 1e-12);
            coefficients.clear();
            hue.tell(&bands, &mut coefficients);
            hue.bands(y, &coefficients, &mut again);
            for (a, b) in bands.iter().zip(&again) {
                assert!((a - b).abs() < 2e-3 * y, "{bands:?} {again:?}");
            }
        }
        hue.bands(0.0, &[0.7], &mut bands);
        assert_eq!(bands, [0.0; 3]);
        hue.bands(f64::NAN, &[0.7], &mut bands);
        assert!(bands.iter().all(|v| v.is_nan()));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let hue = hue();
        let found = |weights: &[f64], epsilon: f64| {
            Hue::new(hue.basis().clone(), weights.to_vec(), epsilon)
                .expect_err("refused")
                .to_string()
        };
        assert!(found(&[0.5, 0.5], 1e-3).contains("expected 3 finite numbers"));
        assert!(found(&[0.5, 0.5, f64::NAN], 1e-3).contains("NaN"));
        assert!(found(&[0.2, 0.6, 0.2], 0.0).contains("epsilon"));
    }
}
