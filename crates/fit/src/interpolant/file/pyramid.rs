//! Detail lattices in few bytes: each level says only what the coarser one does not foretell.
//!
//! A lattice of c cells across is coded from the coarsest of its halves (at most 4 cells, or odd)
//! to itself. A level is foretold by B-spline subdivision of the level before, as decoded; the
//! difference is rounded to multiples of the level's step, in tiles of 2 × 2 values of which those
//! that are all zero are left out.

use bsdfkit::{Error, Result};
use safetensors::Dtype;

use crate::interpolant::file::arrays::{Array, Arrays};
use crate::lobe::detail::Detail;

/// Step of a level's differences, in logarithms of the ratio: f is kept to 2 %, a quarter to a half of that
/// in the mean. At half of it files of noisy data grow to twice the size; doubled, errors double and
/// files shrink by a third (six virtual materials, one with 2 % noise).
const STEP: f32 = 0.04;

/// Differences are whole numbers of steps up to this; where one is larger, the step is.
const MOST_STEPS: f32 = 127.0;

/// Largest step read: far above any logarithm, small enough that no sum overflows.
const LARGEST_STEP: f32 = 1e3;

/// Width of a tile.
const TILE: usize = 2;

/// Most control values read, of all lattices: 1 GB.
const MOST_VALUES: usize = 1 << 28;

/// Lattices on their way into a file.
///
/// Accuracy: within the disk a logarithm changes by at most half the finest level's step, which is
/// [`STEP`] or, if that is more, 1/127 of the largest difference between neighbours.
#[derive(Default)]
pub(crate) struct Pyramid {
    /// By lattice and level, coarse to fine.
    steps: Vec<f32>,
    /// Whether a tile is kept: one bit each, lowest first, by lattice, level and place.
    kept: Vec<u8>,
    tiles: usize,
    /// Values of kept tiles in steps, row-major in y.
    values: Vec<i8>,
}

impl Pyramid {
    /// The lattices of all `details`, which have one size.
    pub(crate) fn of<'a>(details: impl Iterator<Item = &'a Detail>) -> Self {
        let mut pyramid = Self::default();
        details.for_each(|d| pyramid.push(d));
        pyramid
    }

    fn push(&mut self, detail: &Detail) {
        let side = detail.control().len().isqrt();
        let clean = |v: &f32| if v.is_finite() { *v } else { 0.0 };
        let mut levels = vec![detail.control().iter().map(clean).collect::<Vec<f32>>()];
        for &finer in sides(side).iter().skip(1).rev() {
            let coarse = halved(&levels[levels.len() - 1], finer);
            levels.push(coarse);
        }
        let mut decoded: Option<Detail> = None;
        for (level, side) in levels.into_iter().rev().zip(sides(side)) {
            let mut values = foretold(decoded.as_ref(), side);
            let difference = |k: usize, values: &[f32]| {
                if counts(k, side) { level[k] - values[k] } else { 0.0 }
            };
            let largest =
                (0..values.len()).fold(0.0f32, |m, k| m.max(difference(k, &values).abs()));
            let step = (largest / MOST_STEPS).max(STEP);
            self.steps.push(step);
            for tile in tiles(side) {
                let steps = cells(tile, side)
                    .map(|k| k.map_or(0, |k| (difference(k, &values) / step).round() as i8));
                let keep = steps.iter().any(|&n| n != 0);
                if self.tiles.is_multiple_of(8) {
                    self.kept.push(0);
                }
                self.kept[self.tiles / 8] |= u8::from(keep) << (self.tiles % 8);
                self.tiles += 1;
                if keep {
                    add(&mut values, tile, side, step, &steps);
                    self.values.extend(steps);
                }
            }
            decoded = Detail::from_control(values);
        }
    }

    /// As arrays `detail_step`, `detail_kept` and `detail_tile`.
    pub(crate) fn store(self, push: &mut dyn FnMut(&str, Array)) {
        let bytes = self.steps.iter().flat_map(|s| s.to_le_bytes()).collect();
        push("detail_step", Array { dtype: Dtype::F32, shape: vec![self.steps.len()], bytes });
        push(
            "detail_kept",
            Array { dtype: Dtype::U8, shape: vec![self.kept.len()], bytes: self.kept },
        );
        let shape = vec![self.values.len() / (TILE * TILE), TILE, TILE];
        let bytes = self.values.iter().flat_map(|v| v.to_le_bytes()).collect();
        push("detail_tile", Array { dtype: Dtype::I8, shape, bytes });
    }

    /// `count` lattices of `side` × `side` control values from what [`Pyramid::store`] gave.
    ///
    /// Errors: format, naming the array; limit above 2²⁸ control values.
    /// Cost: 0.1 ms a lattice of 131².
    pub(crate) fn restore(arrays: &Arrays<'_>, count: usize, side: usize) -> Result<Vec<Detail>> {
        if side < 4 {
            return Err(arrays.wrong("lattice", "at least 4 values across", &side.to_string()));
        }
        let all = side.checked_mul(side).and_then(|n| n.checked_mul(count));
        if all.is_none_or(|all| all > MOST_VALUES) {
            let text = format!(
                "{count} lattices of {side} values across: expected at most {MOST_VALUES} in all"
            );
            return Err(Error::limit(text).context(&arrays.prefix));
        }
        let sides = sides(side);
        let (_, steps) = arrays.bytes("detail_step", Dtype::F32, 1)?;
        let steps: Vec<f32> = steps
            .chunks_exact(4)
            .map(|c| f32::from_le_bytes(c.try_into().unwrap_or_default()))
            .collect();
        let wanted = count * sides.len();
        if steps.len() != wanted || steps.iter().any(|s| !(0.0..=LARGEST_STEP).contains(s)) {
            let expected = format!("{wanted} steps of at most {LARGEST_STEP}");
            let largest = steps.iter().copied().fold(0.0, f32::max);
            let found = format!("{} of at most {largest}", steps.len());
            return Err(arrays.wrong("detail_step", &expected, &found));
        }
        let (_, kept) = arrays.bytes("detail_kept", Dtype::U8, 1)?;
        let tiles_of_one: usize = sides.iter().map(|&s| s.div_ceil(TILE).pow(2)).sum();
        let bytes = (count * tiles_of_one).div_ceil(8);
        if kept.len() != bytes {
            return Err(arrays.wrong(
                "detail_kept",
                &format!("{bytes} bytes"),
                &kept.len().to_string(),
            ));
        }
        let mut bits = (0..count * tiles_of_one).map(|k| kept[k / 8] >> (k % 8) & 1 == 1);
        let expected = bits.clone().filter(|b| *b).count();
        let (shape, values) = arrays.bytes("detail_tile", Dtype::I8, 3)?;
        if shape != [expected, TILE, TILE] {
            let expected = format!("[{expected}, {TILE}, {TILE}]");
            return Err(arrays.wrong("detail_tile", &expected, &format!("{shape:?}")));
        }
        let values: Vec<i8> = values.iter().map(|&b| i8::from_le_bytes([b])).collect();
        let mut values = values.chunks_exact(TILE * TILE);
        let mut steps = steps.into_iter();
        let mut lattice = || {
            let mut decoded = None;
            for &side in &sides {
                let mut control = foretold(decoded.as_ref(), side);
                let step = steps.next()?;
                for tile in tiles(side) {
                    if bits.next()? {
                        add(&mut control, tile, side, step, values.next()?);
                    }
                }
                decoded = Detail::from_control(control);
            }
            decoded
        };
        (0..count)
            .map(|_| {
                lattice().ok_or_else(|| arrays.wrong("detail_tile", "more tiles", "their end"))
            })
            .collect()
    }
}

/// Values across the levels of a lattice, coarse to fine.
fn sides(side: usize) -> Vec<usize> {
    let mut cells = vec![side - 3];
    while cells[cells.len() - 1] > 4 && cells[cells.len() - 1].is_multiple_of(2) {
        cells.push(cells[cells.len() - 1] / 2);
    }
    cells.iter().rev().map(|c| c + 3).collect()
}

/// Every second control value of a lattice of `side` across: those above the coarser one's.
fn halved(fine: &[f32], side: usize) -> Vec<f32> {
    let coarse = (side - 3) / 2 + 3;
    // Coarse control i lies at fine control 2 i − 1.
    let at = |i: usize| (2 * i).saturating_sub(1).min(side - 1);
    (0..coarse * coarse).map(|k| fine[at(k / coarse) * side + at(k % coarse)]).collect()
}

/// A level's control values as the level before foretells them.
fn foretold(coarser: Option<&Detail>, side: usize) -> Vec<f32> {
    coarser.map_or_else(|| vec![0.0; side * side], |d| d.refined().control().to_vec())
}

/// Whether control value `k` has a say within the disk: a cubic spline's reaches two cells far.
fn counts(k: usize, side: usize) -> bool {
    let cells = (side - 3) as f64;
    let from_disk = |i: usize| {
        let u = (i as f64 - 1.0) / cells * 2.0 - 1.0;
        (u.abs() - 4.0 / cells).max(0.0)
    };
    from_disk(k % side).hypot(from_disk(k / side)) < 1.0
}

/// The tiles of a level, row-major in y.
fn tiles(side: usize) -> impl Iterator<Item = (usize, usize)> {
    let across = side.div_ceil(TILE);
    (0..across * across).map(move |k| (k % across, k / across))
}

/// The control values of a tile; none where it juts out of the lattice.
fn cells((x, y): (usize, usize), side: usize) -> [Option<usize>; TILE * TILE] {
    std::array::from_fn(|k| {
        let (i, j) = (TILE * x + k % TILE, TILE * y + k / TILE);
        (i < side && j < side).then_some(j * side + i)
    })
}

/// Adds a tile's steps to control values.
fn add(control: &mut [f32], tile: (usize, usize), side: usize, step: f32, steps: &[i8]) {
    for (k, &n) in cells(tile, side).into_iter().zip(steps) {
        if let Some(k) = k {
            control[k] += step * f32::from(n);
        }
    }
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::DVec2;
    use proptest::prelude::*;
    use safetensors::SafeTensors;

    use super::*;

    /// Through a file's bytes.
    fn back(details: &[Detail]) -> (Vec<Detail>, usize) {
        let side = details[0].control().len().isqrt();
        let mut arrays: Vec<(String, Array)> = Vec::new();
        Pyramid::of(details.iter()).store(&mut |name, a| arrays.push((format!("c.{name}"), a)));
        let bytes = safetensors::serialize(arrays.iter().map(|(n, a)| (n, a)), None).unwrap();
        let tensors = SafeTensors::deserialize(&bytes).unwrap();
        let arrays = Arrays { tensors: &tensors, prefix: "c".to_owned() };
        (Pyramid::restore(&arrays, details.len(), side).unwrap(), bytes.len())
    }

    fn largest_error(a: &Detail, b: &Detail) -> f64 {
        (0..400)
            .map(|k| {
                let turn = f64::from(k) * 2.399_963_229_728_653;
                DVec2::from_angle(turn) * (f64::from(k) / 399.0).sqrt()
            })
            .map(|u| (a.log_at(u) - b.log_at(u)).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn levels_halve_to_the_coarsest() {
        assert_eq!(sides(131), [7, 11, 19, 35, 67, 131]);
        assert_eq!(sides(4), [4]);
        assert_eq!(sides(27), [6, 9, 15, 27]);
    }

    #[test]
    fn smooth_lattices_take_few_bytes() {
        let smooth = |k: i32| (f64::from(k % 131) * 0.05).sin() as f32;
        let detail = Detail::from_control((0..131 * 131).map(smooth).collect()).unwrap();
        let (after, bytes) = back(std::slice::from_ref(&detail));
        assert!(largest_error(&detail, &after[0]) <= 0.020_01);
        assert!(bytes < 4000, "{bytes}");
    }

    #[test]
    fn what_is_not_finite_counts_as_nothing() {
        let mut control = vec![0.0; 49];
        (control[10], control[11]) = (f32::NAN, f32::INFINITY);
        let (after, _) = back(&[Detail::from_control(control).unwrap()]);
        assert!(after[0].control().iter().all(|v| *v == 0.0));
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn errors_are_half_a_step(
            side in 4usize..40,
            scale in 0.0f32..6.0,
            seeds in prop::collection::vec(-1.0f32..1.0, 3 * 40 * 40),
        ) {
            let lattice = |k: usize| {
                let values = seeds[k * side * side..][..side * side].iter();
                Detail::from_control(values.map(|v| scale * v).collect()).unwrap()
            };
            let before = [lattice(0), lattice(1), lattice(2)];
            let (after, _) = back(&before);
            // Differences of values within ±scale from a mean of others are within twice that,
            // and once more half a step.
            let bound = 0.5 * (2.02 * scale / MOST_STEPS).max(STEP) + 1e-5;
            for (a, b) in before.iter().zip(&after) {
                prop_assert!(largest_error(a, b) <= f64::from(bound));
            }
        }
    }
}
