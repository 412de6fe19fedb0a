//! Walks from a slice's root to a point in a leaf: along the Hilbert curve by one number, or
//! through rows and columns by two.

use super::node::MAX_DEPTH;
use crate::unit::{choose_of_four, choose_of_two};
use bsdfkit_sphere::{DVec2, hilbert};

/// Positions on the order-32 curve, and cells along a side of its square.
const INDICES: f64 = FINEST * FINEST;
const FINEST: f64 = 4_294_967_296.0;

/// A sample on its way down. Quadrants are numbered x + 2y; a link of 0 leads nowhere.
pub(super) trait Walk: Copy {
    /// The random numbers that decide it, each in \[0, 1).
    type Numbers: Copy + Default;

    fn new(link: u32, u: Self::Numbers) -> Self;

    fn link(&self) -> u32;

    /// Goes on to one of four quadrants with these means and links, as likely as (mean − floor).
    fn step(&mut self, means: [f32; 4], links: [u32; 4], floor: f64);

    /// The point of the unit square reached.
    fn end(&self) -> DVec2;
}

/// Each level takes from the number the choice of one of four quadrants in the curve's order;
/// what remains of it walks along the curve inside the leaf.
#[derive(Clone, Copy)]
pub(super) struct Along {
    link: u32,
    level: u32,
    /// Position along the curve, two bits a level.
    index: u64,
    turn: Turn,
    /// Place within the region reached, in \[0, 1).
    u: f64,
}

impl Walk for Along {
    type Numbers = f64;

    #[inline(always)]
    fn new(link: u32, u: f64) -> Self {
        Self { link, level: 0, index: 0, turn: Turn::default(), u }
    }

    #[inline(always)]
    fn link(&self) -> u32 {
        self.link
    }

    #[inline(always)]
    fn step(&mut self, means: [f32; 4], links: [u32; 4], floor: f64) {
        let quadrants = self.turn.quadrants();
        let masses = quadrants.map(|q| (f64::from(means[(q & 3) as usize]) - floor).max(0.0));
        let chosen = if self.level < MAX_DEPTH { choose_of_four(masses, self.u) } else { None };
        let Some((digit, rest)) = chosen else {
            self.link = 0;
            return;
        };
        self.u = rest;
        self.index = self.index << 2 | digit as u64;
        self.link = links[(quadrants[digit] & 3) as usize];
        self.turn = self.turn.inside(digit);
        self.level += 1;
    }

    #[inline(always)]
    fn end(&self) -> DVec2 {
        // 4^(32 − level) finest positions remain along the curve.
        let rest = (self.u * INDICES) as u64 >> (2 * self.level);
        // In two steps: at level 0 the index is 0, and a shift by 64 is none.
        let prefix = self.index << 1 << (63 - 2 * self.level);
        let (x, y) = hilbert::index_to_cell(32, prefix | rest);
        DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / FINEST
    }
}

/// Each level chooses a row of quadrants by the second number and one of the row's two by the
/// first; what remains of both is the place inside the leaf. So what is stratified in the square
/// stays it. [CJAJ05]
#[derive(Clone, Copy)]
pub(super) struct Warp {
    link: u32,
    level: u32,
    cell: [u32; 2],
    /// Place within the region reached.
    u: DVec2,
}

impl Walk for Warp {
    type Numbers = DVec2;

    #[inline(always)]
    fn new(link: u32, u: DVec2) -> Self {
        Self { link, level: 0, cell: [0; 2], u }
    }

    #[inline(always)]
    fn link(&self) -> u32 {
        self.link
    }

    #[inline(always)]
    fn step(&mut self, means: [f32; 4], links: [u32; 4], floor: f64) {
        let [a, b, c, d] = means.map(|mean| (f64::from(mean) - floor).max(0.0));
        if self.level == MAX_DEPTH || a + b + c + d <= 0.0 {
            self.link = 0;
            return;
        }
        let (upper, y) = choose_of_two(a + b, c + d, self.u.y);
        let (right, x) =
            if upper { choose_of_two(c, d, self.u.x) } else { choose_of_two(a, b, self.u.x) };
        self.u = DVec2::new(x, y);
        self.cell = [self.cell[0] << 1 | u32::from(right), self.cell[1] << 1 | u32::from(upper)];
        self.link = links[usize::from(right) + 2 * usize::from(upper)];
        self.level += 1;
    }

    #[inline(always)]
    fn end(&self) -> DVec2 {
        let [x, y] = self.cell.map(f64::from);
        (DVec2::new(x, y) + self.u) / f64::from(1_u32 << self.level)
    }
}

/// How the Hilbert curve lies in a cell: bit 0 x and y exchanged, bit 1 half turn.
#[derive(Clone, Copy, Default)]
pub(super) struct Turn(u8);

impl Turn {
    /// Quadrants (x + 2y) in the order of the curve.
    #[inline]
    pub(super) fn quadrants(self) -> [u8; 4] {
        const ORDERS: [[u8; 4]; 4] = [[0, 1, 3, 2], [0, 2, 3, 1], [3, 2, 0, 1], [3, 1, 0, 2]];
        ORDERS[(self.0 & 3) as usize]
    }

    /// How it lies in the quadrant that comes `digit`-th.
    #[inline]
    pub(super) fn inside(self, digit: usize) -> Self {
        Self(self.0 ^ [1, 0, 0, 3][digit])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::BELOW_ONE;

    #[test]
    fn turns_are_those_of_the_hilbert_curve() {
        let order = 5;
        for index in 0..1_u64 << (2 * order) {
            let (mut turn, mut cell) = (Turn::default(), (0, 0));
            for level in (0..order).rev() {
                let digit = (index >> (2 * level) & 3) as usize;
                let q = u32::from(turn.quadrants()[digit]);
                cell = (cell.0 << 1 | (q & 1), cell.1 << 1 | q >> 1);
                turn = turn.inside(digit);
            }
            assert_eq!(cell, hilbert::index_to_cell(order, index));
        }
    }

    /// A quadrant of 0 is never drawn, and a constant square is left as it is.
    #[test]
    fn warps_skip_nothing_and_zero() {
        let numbers = || {
            (0..=64)
                .flat_map(|i| (0..=64).map(move |k| DVec2::new(f64::from(i), f64::from(k)) / 64.0))
        };
        for u in numbers().map(|u| u.min(DVec2::splat(BELOW_ONE))) {
            let mut warp = Warp::new(1, u);
            warp.step([0.0, 1.0, 3.0, 0.0], [1; 4], 0.0);
            assert!(warp.cell[0] + warp.cell[1] == 1, "{u}: {:?}", warp.cell);
            // Rows have 1 and 3 of 4.
            assert_eq!(warp.cell[1] == 1, u.y >= 0.25);
            let mut warp = Warp::new(1, u);
            (0..MAX_DEPTH).for_each(|_| warp.step([0.5; 4], [1; 4], 0.25));
            assert!((warp.end() - u).length() < 1e-15);
            assert!(warp.end().max_element() < 1.0);
        }
    }
}
