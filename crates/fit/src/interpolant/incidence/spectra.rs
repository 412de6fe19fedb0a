//! Spectra of few numbers: what bands have beyond the guide.
//!
//! How bands follow from a [`Basis`] stands there. The basis
//! is that of the largest variances of log ratios (principal components), bright points counting more. Coefficients are
//! interpolated as the guide's detail is, so bands move with its peaks, and none is negative.

use bsdfkit::spectrum::Basis;

use bsdfkit_measure::linear::leading;
use bsdfkit_measure::{Colorimetry, Measurement};

/// Details of an incidence: the guide's, and a coefficient each.
pub(crate) const MOST_DETAILS: usize = 1 + Basis::MOST;
/// Relative L1 over bands at which no more coefficients are looked for.
const CLOSE: f64 = 2e-3;
/// A further coefficient must leave less than this share of the error: noise of single bands does not.
const EARNED: f64 = 0.9;
/// Values of bands that show the basis, over all incidences: 5,000 points of 40 bands.
const SHOWN: usize = 200_000;
/// Band and guide differ by this factor at most: more is noise of what is nearly dark.
const LIMIT: f32 = 30.0;

/// The spectra of `m`; `None` where it has no bands.
///
/// Cost: 200,000 values × (bands + 6) multiplications; they are held, 4 bytes each.
pub(crate) fn basis_of(m: &Measurement, epsilon: f64) -> Option<Basis> {
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
    let unit = leading(&square, n, Basis::MOST.min(n));
    let all: Vec<Vec<f64>> =
        unit.into_iter().map(|v| v.into_iter().map(|x| scale * x).collect()).collect();
    let of_rank = |rank: usize| {
        let rows = || all[..rank].to_vec();
        let basis = Basis::new(bands.clone(), offset.clone(), rows(), 0.0)?;
        let error = misfit(&basis, &shown, epsilon);
        Basis::new(bands.clone(), offset.clone(), rows(), error)
    };
    let mut best = of_rank(1)?;
    for rank in 2..=all.len() {
        if best.error() <= CLOSE {
            break;
        }
        let next = of_rank(rank)?;
        if next.error() > EARNED * best.error() {
            break;
        }
        best = next;
    }
    Some(best)
}

/// Relative L1 over bands.
fn misfit(basis: &Basis, shown: &[Shown], epsilon: f64) -> f64 {
    let (mut off, mut all) = (0.0, 0.0);
    let mut logs = vec![0.0; 1 + basis.bands().count()];
    for s in shown {
        let coefficients: Vec<f64> = basis.coefficients(&s.logs).collect();
        let detail = |d: usize| if d == 0 { 0.0 } else { coefficients[d - 1] };
        basis.logarithms(detail, &mut logs);
        for (log, told) in logs[1..].iter().zip(&s.logs) {
            let measured = ((s.guide + epsilon) * f64::from(*told).exp() - epsilon).max(0.0);
            off += (((s.guide + epsilon) * log.exp() - epsilon).max(0.0) - measured).abs();
            all += measured;
        }
    }
    off / all.max(1e-300)
}

/// Adds the coefficients of a point, given its guide and bands.
pub(crate) fn tell(
    basis: &Basis,
    values: &[f32],
    epsilon: f64,
    shown: &mut Shown,
    out: &mut Vec<f32>,
) {
    shown.see(values, epsilon);
    out.extend(basis.coefficients(&shown.logs).map(|a| a as f32));
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
