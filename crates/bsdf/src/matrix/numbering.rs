//! Directions → patches: a table stands for the azimuths.

use bsdfkit_sphere::octant::at_turns;

use super::klems::KlemsBasis;
use crate::{DVec3, Lanes};

/// What [`Numbering::indices`] says of a direction without patch.
pub(super) const NO_PATCH: u32 = u32::MAX;

/// Directions that are numbered side by side.
pub(super) const CHUNK: usize = 64;

/// Places around the circle, a power of 2: of a basis of 145 patches 2 in 100 hold a border, and
/// the table fits the first-level cache.
const PLACES: usize = 1 << 10;

/// Fewest places a patch has, or its ring is left out of the table.
const LEAST: usize = 4;

/// Most rings that a table is made for.
const MOST_RINGS: usize = 64;

/// In the table: only [`KlemsBasis::index_by_angles`] can tell.
const UNDECIDED: u16 = u16::MAX;

/// Rings whose bounds a loop keeps in registers.
const GROUP: usize = 8;

/// How far from a border, in places, the table leaves the answer to the angles: far
/// more than the rounding of either.
const BESIDE: f64 = 1e-6;

/// From here to its double a f64 has no fraction: adding it rounds, and leaves an integer in the low bits.
const INTEGERS: f64 = 6_755_399_441_055_744.0;

/// Which patch lies where around each ring.
///
/// Cost: 2 KB a ring, made in 10 µs for 145 patches.
#[derive(Debug)]
pub(super) struct Numbering {
    /// [`PLACES`] for each ring, then as many undecided ones.
    table: Vec<u16>,
    /// cos θ of the bounds between rings, −∞ behind the last.
    bounds: Vec<[f64; GROUP]>,
    /// First index of the undecided places.
    undecided: u64,
    /// cos θ of the outer bound.
    outer: f64,
}

/// The place around the circle of a projected direction, from 0 to [`PLACES`]: grows with the azimuth, from
/// −90°, and takes one division. NaN for (0, 0).
#[inline(always)]
fn place(x: f64, y: f64) -> f64 {
    let share = y / (x.abs() + y.abs());
    let quarters = if x >= 0.0 { share } else { 2.0 - share };
    (quarters + 1.0) * (PLACES / 4) as f64
}

/// The nearest whole place.
#[inline(always)]
fn rounded(place: f64) -> u64 {
    (place + INTEGERS).to_bits() & (PLACES - 1) as u64
}

impl Numbering {
    /// Of the rings of `basis`, whose bounds between rings are `bounds` and `outer` behind the last.
    pub(super) fn new(basis: &KlemsBasis, bounds: &[f64], outer: f64) -> Self {
        let rings = Some(basis.rings().len()).filter(|rings| *rings <= MOST_RINGS).unwrap_or(0);
        let mut table = vec![UNDECIDED; (rings + 1) * PLACES];
        for (r, places) in table.chunks_exact_mut(PLACES).take(rings).enumerate() {
            fill_ring(places, basis.ring_starts()[r], basis.rings()[r].patches);
        }
        let bounds = bounds.chunks(GROUP);
        let group = |some: &[f64]| {
            std::array::from_fn(|n| some.get(n).copied().unwrap_or(f64::NEG_INFINITY))
        };
        Self {
            table,
            bounds: bounds.map(group).collect(),
            undecided: (rings * PLACES) as u64,
            // Without a table nothing is inside.
            outer: if rings == 0 { f64::INFINITY } else { outer },
        }
    }

    /// [`KlemsBasis::index_by_angles`] of a direction; `None` where the table cannot tell.
    #[inline]
    pub(super) fn index(&self, w: DVec3) -> Option<usize> {
        let place = place(w.x, w.y);
        if w.z <= self.outer || w.z.is_nan() || place.is_nan() {
            return None;
        }
        let rings =
            self.bounds.iter().flatten().map(|bound| usize::from(w.z <= *bound)).sum::<usize>();
        let patch = self.table[rings * PLACES + rounded(place) as usize];
        (patch != UNDECIDED).then_some(usize::from(patch))
    }

    /// [`KlemsBasis::index`] of up to [`CHUNK`] directions (sign · x, sign · y, |z|); [`NO_PATCH`]
    /// for `None`.
    #[inline(always)]
    pub(super) fn indices(&self, basis: &KlemsBasis, w: Lanes<'_>, sign: f64, out: &mut [u32]) {
        let (w, out) = (w.part(0..out.len()), &mut out[..w.len().min(CHUNK)]);
        let (mut z, mut places) = ([0.0; CHUNK], [f64::NAN; CHUNK]);
        for k in 0..out.len() {
            z[k] = w.z[k].abs();
            places[k] = place(sign * w.x[k], sign * w.y[k]);
        }
        let mut rings = [0_u64; CHUNK];
        for bounds in &self.bounds {
            // A copy, so that it stays in registers.
            let bounds = *bounds;
            for k in 0..CHUNK {
                for bound in bounds {
                    rings[k] += u64::from(z[k] <= bound);
                }
            }
        }
        let mut at = [0_u32; CHUNK];
        for k in 0..CHUNK {
            let decided = rings[k] * PLACES as u64 + rounded(places[k]);
            let inside = (z[k] > self.outer) & !places[k].is_nan();
            at[k] = if inside { decided } else { self.undecided } as u32;
        }
        for (k, out) in out.iter_mut().enumerate() {
            let patch = self.table[at[k] as usize];
            *out = u32::from(patch);
            if patch == UNDECIDED {
                let w = DVec3::new(sign * w.x[k], sign * w.y[k], z[k]);
                *out = basis.index_by_angles(w).map_or(NO_PATCH, |patch| patch as u32);
            }
        }
    }
}

/// Numbers the places of a ring of `patches` patches, the first of them number `first`.
fn fill_ring(places: &mut [u16], first: usize, patches: usize) {
    if first + patches > usize::from(UNDECIDED) || patches * LEAST > PLACES {
        return;
    }
    let at = |k: usize| {
        let border = at_turns((k as f64 - 0.5) / patches as f64);
        place(border.x, border.y)
    };
    let number = |place: f64| place.round() as usize;
    for k in 0..patches {
        let (from, to) = (number(at(k)), number(at(k + 1)));
        let to = if to <= from { to + PLACES } else { to };
        for n in from..=to {
            places[n % PLACES] = (first + k) as u16;
        }
    }
    for border in (0..patches).map(at).filter(|_| patches > 1) {
        for n in [border - BESIDE, border + BESIDE].map(|p| number(p + PLACES as f64)) {
            places[n % PLACES] = UNDECIDED;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::Ring;
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
                    for off in [-1e-3, -1e-9, -1e-15, 0.0, 1e-15, 1e-9, 1e-3] {
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
