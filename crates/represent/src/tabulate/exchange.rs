//! Reciprocity of isotropic sources: the mean of f and of its exchange, value by value.

use bsdfkit_sphere::{DVec3, Side};

use crate::source::{Peak, Slice, Source};

/// Slices over the polar angle, 0.18° apart; between two, f is interpolated. A guess: a fifth of
/// the narrowest peak that a goniophotometer resolves.
const POLAR_STEPS: usize = 512;

/// ½ (f(ωi, ωo) + f(ωo, ωi)) of an isotropic reflection.
///
/// Cost: a value costs three of the source's, and [`POLAR_STEPS`] slices are held.
pub(super) struct Exchanged<'a> {
    source: &'a dyn Source,
    /// Slices of incidences on +X at the polar angles k · 90° / [`POLAR_STEPS`].
    slices: Vec<Box<dyn Slice + 'a>>,
}

impl<'a> Exchanged<'a> {
    pub(super) fn new(source: &'a dyn Source) -> Self {
        let slices = (0..=POLAR_STEPS)
            .map(|k| {
                let (sin, cos) =
                    (k as f64 / POLAR_STEPS as f64 * std::f64::consts::FRAC_PI_2).sin_cos();
                source.slice(DVec3::new(sin, 0.0, source.incident().sign() * cos))
            })
            .collect();
        Self { source, slices }
    }
}

impl Source for Exchanged<'_> {
    fn incident(&self) -> Side {
        self.source.incident()
    }

    fn scattered(&self) -> Side {
        self.source.scattered()
    }

    fn isotropic(&self) -> bool {
        true
    }

    fn channels(&self) -> usize {
        self.source.channels()
    }

    fn is_measured(&self, wi: DVec3) -> bool {
        self.source.is_measured(wi)
    }

    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(ExchangedSlice { forward: self.source.slice(wi), source: self, wi })
    }
}

struct ExchangedSlice<'a> {
    forward: Box<dyn Slice + 'a>,
    source: &'a Exchanged<'a>,
    wi: DVec3,
}

impl Slice for ExchangedSlice<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        self.forward.eval(wo, out);
        let channels = self.source.channels();
        let mut near = vec![0.0; 2 * channels];
        for (values, w) in out.chunks_exact_mut(channels).zip(wo) {
            let sin = w.truncate().length();
            let at = sin.atan2(w.z.abs()) / std::f64::consts::FRAC_PI_2 * POLAR_STEPS as f64;
            let k = (at as usize).min(POLAR_STEPS - 1);
            let share = (at - k as f64) as f32;
            // Turned so that wo, now the incident direction, lies on +X.
            let (c, s) = if sin > 0.0 { (w.x / sin, w.y / sin) } else { (1.0, 0.0) };
            let wi =
                DVec3::new(c * self.wi.x + s * self.wi.y, c * self.wi.y - s * self.wi.x, self.wi.z);
            let (below, above) = near.split_at_mut(channels);
            self.source.slices[k].eval(&[wi], below);
            self.source.slices[k + 1].eval(&[wi], above);
            for ((value, below), above) in values.iter_mut().zip(below).zip(above) {
                *value = 0.5 * (*value + *below + share * (*above - *below));
            }
        }
    }

    fn peaks(&self, out: &mut Vec<Peak>) {
        self.forward.peaks(out);
    }
}
