//! Values that are constant over the patches of a basis, of directions as they lie in memory.

use crate::DVec3;
use crate::klems::{CHUNK, Chunk, KlemsBasis, SmallTable};
use bsdfkit_sphere::widest::{Loop, fetch_ahead, widest};

/// A function of the directions on one side of the surface.
pub(crate) enum OneSide<'a> {
    Constant(f64),
    Patches {
        basis: &'a KlemsBasis,
        /// What multiplies x and y of a direction to number it.
        sign: f64,
        table: Box<SmallTable>,
        /// By patch; NaN behind the last.
        values: Box<[f64; 256]>,
    },
}

impl<'a> OneSide<'a> {
    /// `None` for many patches.
    pub(crate) fn by_patch(basis: &'a KlemsBasis, sign: f64, values: &[f64]) -> Option<Self> {
        let table = basis.numbering().small()?;
        let mut all = Box::new([f64::NAN; 256]);
        all.get_mut(..values.len())?.copy_from_slice(values);
        Some(Self::Patches { basis, sign, table, values: all })
    }

    /// Values of directions on this side; of those without a patch, `otherwise`.
    #[inline(always)]
    fn fill(
        &self,
        directions: &[DVec3; CHUNK],
        chunk: &Chunk,
        otherwise: &impl Fn(DVec3) -> f64,
        out: &mut [f64; CHUNK],
    ) {
        let Self::Patches { basis, sign, table, values } = self else {
            let Self::Constant(value) = self else { return };
            for (out, w) in out.iter_mut().zip(directions) {
                // Too low to tell the side in f32, or NaN.
                let unsure = w.z.abs() < f64::from(f32::MIN_POSITIVE) || w.is_nan();
                *out = if unsure { otherwise(*w) } else { *value };
            }
            return;
        };
        let found = basis.numbering().find(chunk, *sign);
        for (out, at) in out.iter_mut().zip(found.at) {
            *out = values[usize::from(table[at as usize % table.len()])];
        }
        let nan = |(k, value): (usize, &f64)| u64::from(value.is_nan()) << k;
        let mut missing = out.iter().enumerate().map(nan).fold(0, |all, bit| all | bit);
        while missing != 0 {
            let k = missing.trailing_zeros() as usize;
            let patch = basis.numbering().patch(found.at[k] as usize, found.places[k]);
            out[k] = patch.map_or_else(|| otherwise(directions[k]), |patch| values[patch]);
            missing &= missing - 1;
        }
    }
}

/// A function of directions on the front and on the back.
pub(crate) struct BothSides<'a> {
    pub(crate) front: OneSide<'a>,
    pub(crate) back: OneSide<'a>,
}

impl BothSides<'_> {
    /// The values of `directions`; of those without a patch, `otherwise`.
    ///
    /// Cost: 2 ns each from the first-level cache.
    pub(crate) fn fill(
        &self,
        directions: &[DVec3],
        otherwise: impl Fn(DVec3) -> f64,
        out: &mut [f64],
    ) {
        widest(Fill { sides: self, directions, otherwise, out });
    }

    #[inline(always)]
    fn fill_chunk(
        &self,
        directions: &[DVec3; CHUNK],
        otherwise: &impl Fn(DVec3) -> f64,
        out: &mut [f64; CHUNK],
    ) {
        let mut chunk = Chunk::NONE;
        for (k, w) in directions.iter().enumerate() {
            (chunk.x[k], chunk.y[k], chunk.z[k]) = (w.x as f32, w.y as f32, w.z as f32);
        }
        let fronts = chunk.z.iter().map(|z| usize::from(*z > 0.0)).sum::<usize>();
        if fronts == 0 {
            return self.back.fill(directions, &chunk, otherwise, out);
        }
        self.front.fill(directions, &chunk, otherwise, out);
        if fronts < CHUNK {
            let mut values = [0.0; CHUNK];
            self.back.fill(directions, &chunk, otherwise, &mut values);
            for ((out, value), w) in out.iter_mut().zip(values).zip(directions) {
                *out = if w.z > 0.0 { *out } else { value };
            }
        }
    }
}

struct Fill<'a, F> {
    sides: &'a BothSides<'a>,
    directions: &'a [DVec3],
    otherwise: F,
    out: &'a mut [f64],
}

/// Directions and results are fetched so many chunks ahead.
const AHEAD: usize = 2;

impl<F: Fn(DVec3) -> f64> Loop for Fill<'_, F> {
    #[inline(always)]
    fn run(self) {
        let Self { sides, directions, otherwise, out } = self;
        let (chunks, rest) = directions.as_chunks();
        let (values, rest_of_values) = out.as_chunks_mut();
        for n in 0..values.len() {
            if let (Some(next), Some(next_values)) = (chunks.get(n + AHEAD), values.get(n + AHEAD))
            {
                fetch_ahead(next);
                fetch_ahead(next_values);
            }
            sides.fill_chunk(&chunks[n], &otherwise, &mut values[n]);
        }
        if let Some(first) = rest.first() {
            // A chunk with the first of the rest at the end.
            let (mut w, mut values) = ([*first; CHUNK], [0.0; CHUNK]);
            w[..rest.len()].copy_from_slice(rest);
            sides.fill_chunk(&w, &otherwise, &mut values);
            rest_of_values.copy_from_slice(&values[..rest.len()]);
        }
    }
}
