//! Slices in blocks: what goes through each step of a query together.

use std::ops::Range;

use rayon::prelude::*;

use crate::lanes::Lanes;
use crate::{DVec3, Error, Result, Side};

/// Results from which on several threads share the work: about a millisecond's worth.
pub const PARALLEL: usize = 1 << 14;
use bsdfkit_sphere::widest::{Loop, fetch_ahead, widest};

/// Results that one thread takes at a time. A guess: 0.1 ms outweighs handing it over.
const GRAIN: usize = 1 << 13;

/// Results that go through each step together; 256 fit numbers of 8 bits, and their coordinates the
/// first-level cache.
pub(super) const BLOCK: usize = 256;

/// A slice with one element for each result, or one for all.
#[derive(Clone, Copy)]
pub(super) struct Input<'a, T> {
    pub(super) values: &'a [T],
    /// 1, or 0 when one element counts for all.
    pub(super) step: usize,
}

impl<'a, T: Copy> Input<'a, T> {
    pub(super) fn new(name: &str, values: &'a [T], results: usize) -> Result<Self> {
        match values.len() {
            found if found == results => Ok(Self { values, step: 1 }),
            1 => Ok(Self { values, step: 0 }),
            found => Err(Error::argument(format!(
                "{name}: expected {results} elements (as many as results) or 1, found {found}"
            ))),
        }
    }

    #[inline]
    pub(super) fn at(&self, n: usize) -> T {
        self.values[n * self.step]
    }
}

impl Input<'_, DVec3> {
    /// Reads those with the given numbers.
    pub(super) fn read(&self, numbers: Range<usize>, block: &mut Block) {
        if self.step == 0 {
            block.fill(self.values[0], numbers.len());
        } else {
            let next = numbers.end..self.values.len().min(numbers.end + BLOCK);
            fetch_ahead(&self.values[next]);
            block.read(&self.values[numbers]);
        }
    }
}

/// Fills `out` part by part, one thread a part; `f` gets the number of a part's first result, and
/// the part.
pub(super) fn share_out<T: Send>(out: &mut [T], f: impl Fn(usize, &mut [T]) + Sync) {
    if out.len() < PARALLEL {
        f(0, out);
    } else {
        out.par_chunks_mut(GRAIN).enumerate().for_each(|(n, part)| f(n * GRAIN, part));
    }
}

/// Fills `out` block by block; `f` gets scratch space, the numbers of a block's results, and the
/// block.
pub(super) fn fill<T: Send, S>(
    out: &mut [T],
    scratch: impl Fn() -> S + Sync,
    f: impl Fn(&mut S, Range<usize>, &mut [T]) + Sync,
) {
    share_out(out, |mut first, part| {
        let mut scratch = scratch();
        let mut rest = part;
        while !rest.is_empty() {
            let (block, next) = rest.split_at_mut(rest.len().min(BLOCK));
            fetch_ahead(&next[..next.len().min(BLOCK)]);
            f(&mut scratch, first..first + block.len(), block);
            (first, rest) = (first + block.len(), next);
        }
    });
}

/// Fills `out` result by result; `f` gets the number of a result.
pub(super) fn fill_each<T: Send>(out: &mut [T], f: impl Fn(usize) -> T + Sync) {
    fill(
        out,
        || (),
        |(), numbers, block| {
            for (n, result) in numbers.zip(block) {
                *result = f(n);
            }
        },
    );
}

/// Up to [`BLOCK`] directions side by side.
pub(super) struct Block {
    pub(super) x: [f64; BLOCK],
    pub(super) y: [f64; BLOCK],
    pub(super) z: [f64; BLOCK],
    pub(super) length: usize,
    /// Whether any coordinate is NaN.
    pub(super) nan: bool,
}

/// The loop of [`Block::read`].
struct Apart<'a> {
    from: &'a [DVec3],
    to: &'a mut Block,
}

impl Loop for Apart<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { from, to } = self;
        for (n, w) in from.iter().enumerate().take(BLOCK) {
            (to.x[n], to.y[n], to.z[n]) = (w.x, w.y, w.z);
        }
        let lanes = to.lanes();
        let any = |a: &[f64]| a.iter().fold(false, |any, c| any | c.is_nan());
        to.nan = any(lanes.x) | any(lanes.y) | any(lanes.z);
    }
}

impl Block {
    pub(super) const EMPTY: Self =
        Self { x: [0.0; BLOCK], y: [0.0; BLOCK], z: [0.0; BLOCK], length: 0, nan: false };

    pub(super) fn empty() -> Self {
        Self::EMPTY
    }

    pub(super) fn pair() -> (Self, Self) {
        (Self::EMPTY, Self::EMPTY)
    }

    pub(super) fn read(&mut self, directions: &[DVec3]) {
        self.length = directions.len().min(BLOCK);
        widest(Apart { from: directions, to: self });
    }

    /// One direction, `length` times.
    pub(super) fn fill(&mut self, w: DVec3, length: usize) {
        (self.length, self.nan) = (length.min(BLOCK), w.is_nan());
        for (lane, c) in [(&mut self.x, w.x), (&mut self.y, w.y), (&mut self.z, w.z)] {
            lane.fill(c);
        }
    }

    pub(super) fn lanes(&self) -> Lanes<'_> {
        let n = self.length;
        Lanes { x: &self.x[..n], y: &self.y[..n], z: &self.z[..n] }
    }

    /// Those with the given numbers.
    pub(super) fn some(&self, numbers: &[u8]) -> Self {
        let mut block = Self { length: numbers.len(), nan: self.nan, ..Self::EMPTY };
        for (n, &from) in numbers.iter().enumerate().take(BLOCK) {
            let from = usize::from(from);
            (block.x[n], block.y[n], block.z[n]) = (self.x[from], self.y[from], self.z[from]);
        }
        block
    }
}

/// Those of up to [`BLOCK`] values with the given numbers.
pub(super) fn pick<T: Copy + Default>(values: &[T], numbers: &[u8]) -> [T; BLOCK] {
    let mut picked = [T::default(); BLOCK];
    for (to, &n) in picked.iter_mut().zip(numbers) {
        *to = values[usize::from(n)];
    }
    picked
}

/// Which of a block's results.
#[derive(Clone, Copy)]
pub(super) enum Members<'a> {
    All,
    Some(&'a [u8]),
}

/// Calls `f(incident, scattered, members)` for each pair of sides that occurs.
pub(super) fn by_sides(wi: Lanes<'_>, wo: Lanes<'_>, mut f: impl FnMut(Side, Side, Members<'_>)) {
    let front = |z: &[f64]| z.iter().map(|z| usize::from(*z > 0.0)).sum::<usize>();
    let (length, fronts) = (wo.len(), [front(wi.z), front(wo.z)]);
    let side = |front| if front { Side::Front } else { Side::Back };
    if fronts.iter().all(|count| *count == 0 || *count == length) {
        return f(side(fronts[0] > 0), side(fronts[1] > 0), Members::All);
    }
    // Four lists, and their lengths in 16 bits each: no branch.
    let (mut lists, mut lengths) = ([[0_u8; BLOCK]; 4], 0_u64);
    for n in 0..length {
        let pair = usize::from(wi.z[n] > 0.0) << 1 | usize::from(wo.z[n] > 0.0);
        lists[pair][(lengths >> (16 * pair)) as usize % BLOCK] = n as u8;
        lengths += 1 << (16 * pair);
    }
    for (pair, list) in lists.iter().enumerate() {
        let length = (lengths >> (16 * pair) & 0xffff) as usize;
        if length > 0 {
            f(side(pair & 2 != 0), side(pair & 1 != 0), Members::Some(&list[..length]));
        }
    }
}
