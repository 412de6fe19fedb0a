//! Directions → patches: a table stands for the azimuths.

use std::ops::RangeInclusive;

use bsdfkit_sphere::octant::at_turns;

use crate::{DVec3, Lanes};

/// What [`Numbering::indices`] says of a direction without patch.
pub(crate) const NO_PATCH: u32 = u32::MAX;

/// Directions that are numbered side by side.
pub(crate) const CHUNK: usize = 64;

/// Places around the circle, a power of 2: of a basis of 145 patches 2 in 100 hold a border, and
/// the table fits the first-level cache.
const PLACES: usize = 1 << 10;

/// Fewest places a patch has, or its ring is left out of the table.
const LEAST: usize = 4;

/// Most rings that a table is made for.
const MOST_RINGS: usize = 64;

/// In the table: a border is there, or it cannot tell.
const UNDECIDED: u16 = u16::MAX;

/// Rings whose bounds a loop keeps in registers.
const GROUP: usize = 8;

/// How far from a border, in places, the answer is left to the angles: more than the rounding of
/// places, 2e-4.
const BESIDE: f32 = 1e-3;

/// Sums |x| + |y| that f32 holds to its full precision, with all that is computed of them.
const USABLE: RangeInclusive<f32> = 1e-30..=1e30;

/// Most rings and patches of a [`SmallTable`].
const SMALL: (usize, usize) = (15, 255);

/// A table in half the bytes, of a size known beforehand; 255 where it is undecided.
pub(crate) type SmallTable = [u8; (SMALL.0 + 1) * PLACES];

/// Which patch lies where around each ring.
///
/// Cost: 2 KB a ring, made in 10 µs for 145 patches.
#[derive(Debug)]
pub(crate) struct Numbering {
    /// [`PLACES`] for each ring, then as many undecided ones.
    table: Vec<u16>,
    /// First index of the undecided places.
    undecided: u32,
    /// By patch, the place at which it ends in the order of azimuths; NaN of those not in the
    /// table.
    ends: Vec<f32>,
    /// Bits of cos θ of the bounds between rings, −1 behind the last.
    bounds: Vec<[i32; GROUP]>,
    /// Bits of cos θ of the outer bound.
    outer: i32,
}

/// [`CHUNK`] directions abreast.
pub(crate) struct Chunk {
    pub(crate) x: [f32; CHUNK],
    pub(crate) y: [f32; CHUNK],
    pub(crate) z: [f32; CHUNK],
}

impl Chunk {
    /// Directions without a patch.
    pub(crate) const NONE: Self =
        Self { x: [f32::NAN; CHUNK], y: [f32::NAN; CHUNK], z: [f32::NAN; CHUNK] };
}

/// Where [`CHUNK`] directions are in the table, and around the circle.
pub(crate) struct Found {
    pub(crate) at: [u32; CHUNK],
    pub(crate) places: [f32; CHUNK],
}

/// The place around the circle of a projected direction, from 0 to [`PLACES`]: grows with the
/// azimuth, from −90°, and takes one division. NaN unless |x| + |y| is [`USABLE`].
#[inline(always)]
fn place(x: f32, y: f32) -> f32 {
    let sum = x.abs() + y.abs();
    let share = y / sum;
    let quarters = if x >= 0.0 { share } else { 2.0 - share };
    if USABLE.contains(&sum) { (quarters + 1.0) * (PLACES / 4) as f32 } else { f32::NAN }
}

/// The nearest whole place.
#[inline(always)]
fn rounded(place: f32) -> u32 {
    // From here to its double a f32 has no fraction: adding it rounds, and leaves an integer in the
    // low bits.
    const INTEGERS: f32 = 12_582_912.0;
    (place + INTEGERS).to_bits() & (PLACES - 1) as u32
}

/// One more bound between rings: how many lie before `z` (bits of a cosine), and how near the
/// nearest.
#[inline(always)]
fn next((rings, near): (u32, u32), z: i32, bound: i32) -> (u32, u32) {
    // The bits of positive numbers are in the order of the numbers: their difference has its sign.
    let off = z.wrapping_sub(bound) as u32;
    (rings + (off >> 31), near.min(off))
}

impl Numbering {
    /// Of rings whose first patches are `starts` (then the number of patches), with cos θ `bounds`
    /// between them and `outer` behind the last.
    pub(crate) fn new(starts: &[usize], bounds: &[f64], outer: f64) -> Self {
        let directions = starts.last().copied().unwrap_or(0);
        let rings = Some(starts.len() - 1).filter(|rings| *rings <= MOST_RINGS).unwrap_or(0);
        let mut table = vec![UNDECIDED; (rings + 1) * PLACES];
        let mut ends = vec![f32::NAN; directions.min(UNDECIDED.into())];
        for (r, places) in table.chunks_exact_mut(PLACES).take(rings).enumerate() {
            if let Some(ends) = ends.get_mut(starts[r]..starts[r + 1]) {
                fill_ring(places, ends, starts[r]);
            }
        }
        let bits = |cosine: f64| (cosine as f32).to_bits() as i32;
        let group =
            |some: &[f64]| std::array::from_fn(|n| some.get(n).map_or(-1, |bound| bits(*bound)));
        Self {
            table,
            undecided: (rings * PLACES) as u32,
            ends,
            bounds: bounds.chunks(GROUP).map(group).collect(),
            // Without a table nothing is inside.
            outer: if rings == 0 { i32::MAX } else { bits(outer) },
        }
    }

    /// The patch of a direction; `None` where neither table nor borders can tell.
    #[inline]
    pub(crate) fn index(&self, w: DVec3) -> Option<usize> {
        let z = (w.z as f32).to_bits() as i32;
        let ring = self.bounds.iter().flatten().fold((0, u32::MAX), |s, b| next(s, z, *b));
        let place = place(w.x as f32, w.y as f32);
        self.patch(self.at(ring, z, place) as usize, place)
    }

    /// Where in the table: the ring and how near to a bound ([`next`]), bits of the cosine, place.
    #[inline(always)]
    fn at(&self, (ring, near): (u32, u32), z: i32, place: f32) -> u32 {
        const INFINITY: i32 = f32::INFINITY.to_bits() as i32;
        // Rounding to f32 keeps the order but for what it makes equal. NaN is beyond infinity.
        let clear = (z > self.outer) & (z <= INFINITY) & (near != 0);
        let decided = ring * PLACES as u32 + rounded(place);
        if clear & !place.is_nan() { decided } else { self.undecided }
    }

    /// The patch at `at` of the table: what it says, or on which side of a border `place` is.
    #[inline]
    pub(crate) fn patch(&self, at: usize, place: f32) -> Option<usize> {
        if self.table[at] != UNDECIDED {
            return Some(self.table[at].into());
        }
        let ring = at - at % PLACES;
        let beside = |places: usize| self.table[ring + (at + places) % PLACES];
        let (before, after) = (beside(PLACES - 1), beside(1));
        let past = place - self.ends.get(usize::from(before))?;
        // The circle closes.
        let past = past - PLACES as f32 * (past / PLACES as f32).round();
        let clear = past.abs() > BESIDE && after != UNDECIDED;
        clear.then_some(usize::from(if past > 0.0 { after } else { before }))
    }

    /// Finds directions (sign · x, sign · y, |z|).
    #[inline(always)]
    pub(crate) fn find(&self, w: &Chunk, sign: f64) -> Found {
        let (mut z, mut rings, mut near) = ([0; CHUNK], [0; CHUNK], [u32::MAX; CHUNK]);
        for k in 0..CHUNK {
            z[k] = w.z[k].abs().to_bits() as i32;
        }
        for bounds in &self.bounds {
            // A copy, so that it stays in registers.
            let bounds = *bounds;
            for k in 0..CHUNK {
                for bound in bounds {
                    (rings[k], near[k]) = next((rings[k], near[k]), z[k], bound);
                }
            }
        }
        let (mut at, mut places) = ([0; CHUNK], [0.0; CHUNK]);
        for k in 0..CHUNK {
            places[k] = place(sign as f32 * w.x[k], sign as f32 * w.y[k]);
            at[k] = self.at((rings[k], near[k]), z[k], places[k]);
        }
        Found { at, places }
    }

    /// The table in few bytes; `None` of many rings or patches.
    pub(crate) fn small(&self) -> Option<Box<SmallTable>> {
        if self.ends.len() > SMALL.1 {
            return None;
        }
        let mut small = Box::new([u8::MAX; (SMALL.0 + 1) * PLACES]);
        for (to, patch) in small.get_mut(..self.table.len())?.iter_mut().zip(&self.table) {
            *to = *patch as u8;
        }
        Some(small)
    }

    /// Patches of up to [`CHUNK`] directions (sign · x, sign · y, |z|): where the table cannot
    /// tell, what `resolve` finds, [`NO_PATCH`] for `None`.
    #[inline(always)]
    pub(crate) fn indices(
        &self,
        w: Lanes<'_>,
        sign: f64,
        out: &mut [u32],
        resolve: impl Fn(DVec3) -> Option<usize>,
    ) {
        let (w, out) = (w.part(0..out.len()), &mut out[..w.len().min(CHUNK)]);
        let mut chunk = Chunk::NONE;
        for k in 0..out.len() {
            (chunk.x[k], chunk.y[k], chunk.z[k]) = (w.x[k] as f32, w.y[k] as f32, w.z[k] as f32);
        }
        let found = self.find(&chunk, sign);
        for (k, out) in out.iter_mut().enumerate() {
            let at = found.at[k] as usize;
            *out = u32::from(self.table[at]);
            if self.table[at] == UNDECIDED {
                let by_angles = || {
                    let (x, y) = (sign * w.x[k], sign * w.y[k]);
                    resolve(DVec3::new(x, y, w.z[k].abs()))
                };
                let patch = self.patch(at, found.places[k]).or_else(by_angles);
                *out = patch.map_or(NO_PATCH, |patch| patch as u32);
            }
        }
    }
}

/// Numbers the places of a ring whose patches are numbered from `first` on, and writes where they
/// end.
fn fill_ring(places: &mut [u16], ends: &mut [f32], first: usize) {
    let patches = ends.len();
    if patches * LEAST > PLACES {
        return;
    }
    for (k, end) in ends.iter_mut().enumerate() {
        let border = at_turns((k as f64 + 0.5) / patches as f64);
        *end = place(border.x as f32, border.y as f32);
    }
    let number = |place: f32| rounded(place) as usize;
    for k in 0..patches {
        let (from, to) = (number(ends[(k + patches - 1) % patches]), number(ends[k]));
        let to = if to <= from { to + PLACES } else { to };
        for n in from..=to {
            places[n % PLACES] = (first + k) as u16;
        }
    }
    for end in ends.iter().filter(|_| patches > 1) {
        for n in [end - BESIDE, end + BESIDE].map(|p| number(p + PLACES as f32)) {
            places[n] = UNDECIDED;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::klems::{KlemsBasis, Ring};
    use bsdfkit_sphere::direction::from_degrees;

    fn bases() -> Vec<KlemsBasis> {
        let mine = |rings: &[(f64, usize)]| {
            let ring = |&(upper_degrees, patches): &(f64, usize)| Ring { upper_degrees, patches };
            KlemsBasis::new("mine", rings.iter().map(ring).collect()).unwrap()
        };
        let rings = |count: u32| -> Vec<_> {
            (1..=count).map(|r| (90.0 * f64::from(r) / f64::from(count), 2 + r as usize)).collect()
        };
        vec![
            KlemsBasis::full(),
            KlemsBasis::half(),
            KlemsBasis::half_73(),
            KlemsBasis::quarter(),
            mine(&[(30.0, 7), (80.0, 3)]),
            mine(&[(90.0, 1)]),
            mine(&[(45.0, 1000), (90.0, 300)]),
            mine(&[(45.0, 100_000), (90.0, 5)]),
            mine(&rings(40)),
            mine(&rings(70)),
        ]
    }

    /// Directions everywhere, on borders and a hair beside them, and those without a patch.
    fn directions(basis: &KlemsBasis) -> Vec<DVec3> {
        let mut all = vec![
            DVec3::Z,
            DVec3::new(-0.0, -0.0, 1.0),
            DVec3::new(-0.0, 0.0, -1.0),
            DVec3::ZERO,
            DVec3::NAN,
            DVec3::new(f64::NAN, 0.5, 0.5),
            DVec3::new(0.5, 0.5, f64::NAN),
            DVec3::new(f64::INFINITY, f64::INFINITY, 0.5),
            DVec3::new(5e-324, -5e-324, 1.0),
            DVec3::new(0.6, 0.3, 0.0),
        ];
        for r in 0..basis.rings().len() {
            let (lower, upper) = basis.ring_bounds_degrees(r);
            let patches = basis.rings()[r].patches.min(300);
            for k in 0..2 * patches {
                let phi = 180.0 * k as f64 / basis.rings()[r].patches as f64;
                for theta in [lower, upper, 0.3 * lower + 0.7 * upper] {
                    for off in [-1e-2, -1e-3, -1e-9, -1e-15, 0.0, 1e-15, 1e-9, 1e-3, 1e-2] {
                        all.push(from_degrees(theta, phi + off));
                        all.push(from_degrees(theta + off, phi));
                    }
                }
            }
        }
        all
    }

    #[test]
    fn the_table_agrees_with_the_angles() {
        for basis in bases() {
            let all = directions(&basis);
            for sign in [1.0, -1.0] {
                let mut undecided = 0;
                for part in all.chunks(CHUNK - 1) {
                    let lane = |f: fn(&DVec3) -> f64| part.iter().map(f).collect::<Vec<_>>();
                    let (x, y, z) = (lane(|w| w.x), lane(|w| w.y), lane(|w| w.z));
                    let mut found = vec![0; part.len()];
                    basis.indices(Lanes { x: &x, y: &y, z: &z }, sign, &mut found);
                    for (w, found) in part.iter().zip(found) {
                        let w = DVec3::new(sign * w.x, sign * w.y, w.z.abs());
                        let expected = basis.index_by_angles(w);
                        assert_eq!(basis.index(w), expected, "{} {w}", basis.name());
                        let expected = expected.map_or(NO_PATCH, |k| k as u32);
                        assert_eq!(found, expected, "{} {w}", basis.name());
                        undecided += usize::from(found == NO_PATCH);
                    }
                }
                assert!(undecided < all.len());
            }
        }
    }

    #[test]
    fn most_places_are_decided() {
        let basis = KlemsBasis::full();
        let table = &basis.numbering().table;
        let undecided = table.iter().filter(|n| **n == UNDECIDED).count() - PLACES;
        // A place or two for each border; the innermost ring has none.
        assert!((144..2 * 144).contains(&undecided), "{undecided}");
    }
}
