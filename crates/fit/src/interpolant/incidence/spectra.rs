//! Spectra of few numbers: what bands have beyond the guide.
//!
//! Every band of a point follows from the guide's value g and a few coefficients a:
//! log (f + ε) = log (g + ε) + offset + Σₖ aₖ basisₖ, one offset and one basis for all points of a component. The basis
//! is that of the largest variances of log ratios (principal components), bright points counting more. Coefficients are
//! interpolated as the guide's detail is, so bands move with its peaks, and none is negative.

use bsdfkit::spectrum::Bands;

use bsdfkit_measure::linear::leading;
use bsdfkit_measure::{Colorimetry, Measurement};

/// Most coefficients: spectra of real surfaces need three or four for half a per cent.
const MOST_RANK: usize = 6;
/// Details of an incidence: the guide's, and a coefficient each.
pub(crate) const MOST_DETAILS: usize = 1 + MOST_RANK;
/// Relative L1 over bands at which no more coefficients are looked for.
const CLOSE: f64 = 2e-3;
/// A further coefficient must leave less than this share of the error: noise of single bands does not.
const EARNED: f64 = 0.9;
/// Values of bands that show the basis, over all incidences: 5,000 points of 40 bands.
const SHOWN: usize = 200_000;
/// Band and guide differ by this factor at most: more is noise of what is nearly dark.
const LIMIT: f32 = 30.0;

/// How bands are made of details.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectra {
    bands: Bands,
    offset: Vec<f64>,
    /// One row a coefficient, one column a band; rows have a mean square of 1.
    basis: Vec<Vec<f64>>,
    error: f64,
}

impl Spectra {
    /// From what a file says. `None` unless sizes agree and all is finite.
    pub(crate) fn from_parts(
        bands: Bands,
        offset: Vec<f64>,
        basis: Vec<Vec<f64>>,
        error: f64,
    ) -> Option<Self> {
        let rows = || basis.iter().chain([&offset]);
        let sound = rows().all(|row| row.len() == bands.count())
            && rows().flatten().all(|v| v.is_finite())
            && (1..=MOST_RANK).contains(&basis.len());
        sound.then_some(Self { bands, offset, basis, error })
    }

    /// The spectra of `m`; `None` where it has no bands.
    ///
    /// Cost: 200,000 values × (bands + 6) multiplications; they are held, 4 bytes each.
    pub(crate) fn of(m: &Measurement, epsilon: f64) -> Option<Self> {
        let Colorimetry::Spectral(bands) = &m.colorimetry else { return None };
        let step = (m.points() * bands.count()).div_ceil(SHOWN).max(1);
        let shown = m.incidences.iter().flat_map(|i| (0..i.wo.len()).map(|k| i.point(k)));
        let shown: Vec<Shown> = shown.step_by(step).map(|p| Shown::of(p, epsilon)).collect();
        let n = bands.count();
        let total: f64 = shown.iter().map(|s| s.weight).sum::<f64>().max(1e-300);
        let mut offset = vec![0.0; n];
        for s in &shown {
            offset
                .iter_mut()
                .zip(&s.logs)
                .for_each(|(o, log)| *o += s.weight / total * f64::from(*log));
        }
        let mut square = vec![0.0; n * n];
        for s in &shown {
            let off: Vec<f64> =
                s.logs.iter().zip(&offset).map(|(log, o)| f64::from(*log) - o).collect();
            for (row, a) in square.chunks_exact_mut(n).zip(&off) {
                row.iter_mut().zip(&off).for_each(|(sum, b)| *sum += s.weight / total * a * b);
            }
        }
        let scale = (n as f64).sqrt();
        let unit = leading(&square, n, MOST_RANK.min(n));
        let all: Vec<Vec<f64>> =
            unit.into_iter().map(|v| v.into_iter().map(|x| scale * x).collect()).collect();
        let mut best = Self { bands: bands.clone(), offset, basis: all[..1].to_vec(), error: 0.0 };
        best.error = best.misfit(&shown, epsilon);
        for rank in 2..=all.len() {
            if best.error <= CLOSE {
                break;
            }
            let mut next = Self { basis: all[..rank].to_vec(), ..best.clone() };
            next.error = next.misfit(&shown, epsilon);
            if next.error > EARNED * best.error {
                break;
            }
            best = next;
        }
        Some(best)
    }

    /// Relative L1 over bands.
    fn misfit(&self, shown: &[Shown], epsilon: f64) -> f64 {
        let (mut off, mut all) = (0.0, 0.0);
        let mut logs = vec![0.0; 1 + self.bands.count()];
        for s in shown {
            let coefficients: Vec<f64> = self.coefficients(&s.logs).collect();
            let detail = |d: usize| if d == 0 { 0.0 } else { coefficients[d - 1] };
            self.logarithms(detail, &mut logs);
            for (log, told) in logs[1..].iter().zip(&s.logs) {
                let measured = ((s.guide + epsilon) * f64::from(*told).exp() - epsilon).max(0.0);
                off += (((s.guide + epsilon) * log.exp() - epsilon).max(0.0) - measured).abs();
                all += measured;
            }
        }
        off / all.max(1e-300)
    }

    /// The wavelengths.
    pub fn bands(&self) -> &Bands {
        &self.bands
    }

    /// How many coefficients an incidence has.
    pub fn rank(&self) -> usize {
        self.basis.len()
    }

    /// Relative L1 between measured bands and what the coefficients of the same points tell.
    pub fn error(&self) -> f64 {
        self.error
    }

    pub(crate) fn offset(&self) -> &[f64] {
        &self.offset
    }

    pub(crate) fn basis(&self) -> &[Vec<f64>] {
        &self.basis
    }

    /// Logarithms over the guide's model, of the guide and all bands. `detail`: the guide's, then the coefficients.
    #[inline(always)]
    pub(crate) fn logarithms(&self, detail: impl Fn(usize) -> f64, out: &mut [f64]) {
        let guide = detail(0);
        let (first, bands) = out.split_at_mut(1);
        first[0] = guide;
        bands.iter_mut().zip(&self.offset).for_each(|(out, offset)| *out = guide + offset);
        for (k, row) in self.basis.iter().enumerate() {
            let coefficient = detail(1 + k);
            bands.iter_mut().zip(row).for_each(|(out, b)| *out += coefficient * b);
        }
    }

    /// Coefficients of a point, from its logarithms over the guide.
    fn coefficients<'a>(&'a self, logs: &'a [f32]) -> impl Iterator<Item = f64> + 'a {
        let n = self.bands.count() as f64;
        let off = || logs.iter().zip(&self.offset).map(|(log, o)| f64::from(*log) - o);
        self.basis.iter().map(move |row| row.iter().zip(off()).map(|(b, o)| b * o).sum::<f64>() / n)
    }

    /// Adds the coefficients of a point, given its guide and bands.
    pub(crate) fn tell(&self, values: &[f32], epsilon: f64, shown: &mut Shown, out: &mut Vec<f32>) {
        shown.see(values, epsilon);
        out.extend(self.coefficients(&shown.logs).map(|a| a as f32));
    }
}

/// A point as the basis sees it.
#[derive(Clone, Default)]
pub(crate) struct Shown {
    guide: f64,
    /// What is bright counts more.
    weight: f64,
    /// Logarithms of bands over the guide.
    logs: Vec<f32>,
}

impl Shown {
    /// Of the guide's value and those of the bands.
    fn of(values: &[f32], epsilon: f64) -> Self {
        let mut shown = Self::default();
        shown.see(values, epsilon);
        shown
    }

    /// Looks at another point.
    fn see(&mut self, values: &[f32], epsilon: f64) {
        let epsilon = epsilon as f32;
        let weight = values[0].max(0.0) + epsilon;
        let log = |v: &f32| ((v.max(0.0) + epsilon) / weight).clamp(1.0 / LIMIT, LIMIT).ln();
        self.guide = f64::from(values[0].max(0.0));
        self.weight = f64::from(weight);
        self.logs.clear();
        self.logs.extend(values[1..].iter().map(log));
    }
}
