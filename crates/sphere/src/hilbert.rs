//! The Hilbert curve on the unit square: one number ↔ a point, near numbers ↔ near points. [GL96]
//!
//! Convention: x is the square's first coordinate. A cell is visited quadrant by quadrant in the
//! order (0,0), (1,0), (1,1), (0,1); the curve of the first quadrant is transposed, that of the
//! last one anti-transposed. So the whole curve runs from (0,0) to (0,1), at every order alike, and
//! the index of a coarse cell is that of any of its fine cells, less two bits a level.
//!
//! Identity, transposition, anti-transposition and the half turn are a commutative group of two
//! independent bits (swap x with y; flip both), so a cell's orientation is the exclusive or of
//! what the levels above it contribute.
//!
//! Differs from: the textbook `d2xy`, of which this is the mirror (x ↔ y).

use glam::DVec2;

/// 2⁶⁴: indices of the order-32 curve in the unit interval.
const INDICES: f64 = 18_446_744_073_709_551_616.0;
/// 2³²: cells of the order-32 curve along a side.
const CELLS: f64 = 4_294_967_296.0;

/// Position along the curve through 2^order × 2^order cells → cell (x, y).
///
/// `order` is at most 32 (more counts as 32); bits of `index` above 4^order are ignored.
/// Cost: 40 integer operations at any order, no branch, no table.
///
/// ```
/// use bsdfkit_sphere::hilbert::index_to_cell;
/// assert_eq!(index_to_cell(1, 1), (1, 0));
/// assert_eq!(index_to_cell(2, 1), (0, 1));
/// ```
#[inline]
pub fn index_to_cell(order: u32, index: u64) -> (u32, u32) {
    let used = mask(order);
    let low = even_bits(index) & used;
    let high = even_bits(index >> 1) & used;
    // Digits 0 and 3 swap what lies below them, digit 3 also flips it.
    let swap = from_levels_above(!(high ^ low) & used);
    let flip = from_levels_above(high & low);
    let (x, y) = (high ^ low, high);
    let exchanged = (x ^ y) & swap;
    ((x ^ exchanged ^ flip) & used, (y ^ exchanged ^ flip) & used)
}

/// Cell (x, y) → position along the curve, inverse of [`index_to_cell`].
///
/// Bits of x and y above `order` are ignored.
/// Cost: one look-up in a 2 KiB table per four levels.
#[inline]
pub fn cell_to_index(order: u32, x: u32, y: u32) -> u64 {
    let order = order.min(LEVELS);
    // The order is rounded up to whole steps by levels on top whose bits are 0. They read as digit
    // 0 whether transposed or not, and each transposes: starting so, the top one comes out plain.
    let steps = order.div_ceil(STEP);
    let mut state = ((steps * STEP - order) & 1) as u16;
    let (x, y) = (x & mask(order), y & mask(order));
    let mut index = 0_u64;
    for step in (0..steps).rev() {
        let shift = step * STEP;
        let key = ((x >> shift) & 15) << 4 | ((y >> shift) & 15);
        let entry = STEPS[state as usize][key as usize];
        index = index << (2 * STEP) | u64::from(entry & 0xff);
        state = entry >> 8;
    }
    index
}

/// A number in \[0, 1) → a point of the open unit square; the centre of an order-32 cell.
///
/// Equal intervals of u fill equal areas, near numbers give near points: a stratified u stays
/// stratified. NaN gives NaN; u outside \[0, 1) is clamped.
///
/// Accuracy: all bits of `u` down to 2⁻⁶⁴ are used.
#[inline]
pub fn unfold(u: f64) -> DVec2 {
    if u.is_nan() {
        return DVec2::NAN;
    }
    // The cast saturates: below 0 gives 0, from 1 on the last index.
    let (x, y) = index_to_cell(LEVELS, (u * INDICES) as u64);
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / CELLS
}

/// A point of the unit square → its number in \[0, 1), inverse of [`unfold`].
///
/// NaN gives NaN; points outside the square are clamped to it.
///
/// Accuracy: `fold(unfold(u)) == u` for every u in \[0, 1) that is a multiple of 2⁻⁶⁴.
#[inline]
pub fn fold(p: DVec2) -> f64 {
    if p.is_nan() {
        return f64::NAN;
    }
    let index = cell_to_index(LEVELS, (p.x * CELLS) as u32, (p.y * CELLS) as u32);
    // Cut to the 53 bits of an f64: rounding could reach 1.
    let excess = 11_u32.saturating_sub(index.leading_zeros());
    (index >> excess << excess) as f64 / INDICES
}

/// Most levels: two 32-bit coordinates make a 64-bit index.
const LEVELS: u32 = 32;

/// The bits of a coordinate that `order` levels use.
#[inline]
fn mask(order: u32) -> u32 {
    (u64::MAX >> 1 >> (63 - order.min(LEVELS))) as u32
}

/// Every second bit, packed: bits 0, 2, 4, … → 0, 1, 2, …
#[inline]
fn even_bits(bits: u64) -> u32 {
    let mut b = bits & 0x5555_5555_5555_5555;
    b = (b | b >> 1) & 0x3333_3333_3333_3333;
    b = (b | b >> 2) & 0x0f0f_0f0f_0f0f_0f0f;
    b = (b | b >> 4) & 0x00ff_00ff_00ff_00ff;
    b = (b | b >> 8) & 0x0000_ffff_0000_ffff;
    (b | b >> 16) as u32
}

/// Each bit becomes the exclusive or of all higher ones.
#[inline]
fn from_levels_above(mut bits: u32) -> u32 {
    bits >>= 1;
    bits ^= bits >> 1;
    bits ^= bits >> 2;
    bits ^= bits >> 4;
    bits ^= bits >> 8;
    bits ^ bits >> 16
}

/// Levels per look-up: 4 fill a table of 2 KiB, a quarter of the steps of 1.
const STEP: u32 = 4;

/// `STEPS[state][x << 4 | y]`: four digits of the index, and in bits 8–9 the state below them.
/// State: bit 0 swap, bit 1 flip.
static STEPS: [[u16; 256]; 4] = steps();

const fn steps() -> [[u16; 256]; 4] {
    let mut table = [[0; 256]; 4];
    let mut start = 0;
    while start < 4 {
        let mut key = 0;
        while key < 256 {
            let (mut state, mut digits) = (start as u16, 0);
            let mut level = STEP;
            while level > 0 {
                level -= 1;
                let flip = state >> 1;
                let (mut x, mut y) =
                    ((key >> (4 + level) & 1) as u16 ^ flip, (key >> level & 1) as u16 ^ flip);
                if state & 1 == 1 {
                    (x, y) = (y, x);
                }
                let digit = y << 1 | (x ^ y);
                digits = digits << 2 | digit;
                state ^= match digit {
                    0 => 1,
                    3 => 3,
                    _ => 0,
                };
            }
            table[start][key] = state << 8 | digits;
            key += 1;
        }
        start += 1;
    }
    table
}
