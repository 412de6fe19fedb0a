//! Spectra of few numbers: what bands have beyond a guide.
//!
//! Every band of a point follows from the guide's value g and a few coefficients a:
//! log (f + ε) = log (g + ε) + offset + Σₖ aₖ basisₖ, one offset and one basis for all points of a component. So no band is negative.

use super::bands::Bands;

/// How bands are made of coefficients.
#[derive(Clone, Debug, PartialEq)]
pub struct Basis {
    bands: Bands,
    offset: Vec<f64>,
    /// One row a coefficient, one column a band; rows have a mean square of 1.
    rows: Vec<Vec<f64>>,
    error: f64,
}

impl Basis {
    /// Most coefficients: spectra of real surfaces need three or four for half a per cent.
    pub const MOST: usize = 6;

    /// A basis of these rows, each with a mean square of 1 and perpendicular to the others, about `offset`. `error`: [`Basis::error`].
    /// `None` unless sizes agree and all is finite.
    pub fn new(bands: Bands, offset: Vec<f64>, rows: Vec<Vec<f64>>, error: f64) -> Option<Self> {
        let sound = rows.iter().chain([&offset]).all(|row| row.len() == bands.count())
            && rows.iter().chain([&offset]).flatten().all(|v| v.is_finite())
            && error.is_finite()
            && (1..=Self::MOST).contains(&rows.len());
        sound.then_some(Self { bands, offset, rows, error })
    }

    /// The wavelengths.
    pub fn bands(&self) -> &Bands {
        &self.bands
    }

    /// How many coefficients.
    pub fn rank(&self) -> usize {
        self.rows.len()
    }

    /// Relative L1 between measured bands and what the coefficients of the same points tell.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Logarithms of bands over the guide where all coefficients are 0.
    pub fn offset(&self) -> &[f64] {
        &self.offset
    }

    /// One row a coefficient, one column a band.
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// Logarithms over the guide's model, of the guide and all bands. `detail`: the guide's, then the coefficients.
    #[inline(always)]
    pub fn logarithms(&self, detail: impl Fn(usize) -> f64, out: &mut [f64]) {
        let guide = detail(0);
        let (first, bands) = out.split_at_mut(1);
        first[0] = guide;
        bands.iter_mut().zip(&self.offset).for_each(|(out, offset)| *out = guide + offset);
        for (k, row) in self.rows.iter().enumerate() {
            let coefficient = detail(1 + k);
            bands.iter_mut().zip(row).for_each(|(out, b)| *out += coefficient * b);
        }
    }

    /// Coefficients of a point, from the logarithms of its bands over the guide.
    pub fn coefficients<'a, T: Copy + Into<f64>>(
        &'a self,
        logs: &'a [T],
    ) -> impl Iterator<Item = f64> + 'a {
        let n = self.bands.count() as f64;
        let off = || logs.iter().zip(&self.offset).map(|(log, o)| (*log).into() - o);
        self.rows.iter().map(move |row| row.iter().zip(off()).map(|(b, o)| b * o).sum::<f64>() / n)
    }
}
