//! How cells of trees and patches of Klems bases overlap, in shares of projected solid angle.
//!
//! On the square of the concentric map rings are concentric squares and azimuths are rays from the
//! middle: a cell and a patch share a polygon, and its area is exact.

use std::f64::consts::TAU;

use bsdfkit::matrix::KlemsBasis;
use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::concentric::disk_to_square;

use super::mosaic::even_bits;
use super::patches::Patches;

/// What a region consists of: patches with their shares of it, which sum to 1.
///
/// Convention: what lies beyond the last ring of a basis has the number after its last patch.
pub(super) type Shares = [(u32, f64)];

/// Shares below this are rounding.
const NOTHING: f64 = 1e-12;

/// The patches of one basis in every cell of the square, level by level.
pub(super) struct Coverage {
    /// By level and cell (Z order): where its shares lie, and how many.
    ranges: Vec<Vec<(u32, u32)>>,
    shares: Vec<(u32, f64)>,
}

impl Coverage {
    /// Cost: at level 10 half a second and 30 MB.
    pub(super) fn new(basis: &KlemsBasis, deepest: u32) -> Self {
        let outlines = outlines(basis);
        let beyond = outlines.len() as u32;
        let mut coverage = Self { ranges: Vec::new(), shares: Vec::new() };
        let mut candidates: Vec<u32> = (0..=beyond).collect();
        for level in 0..=deepest {
            let cells = 1u32 << (2 * level);
            let mut ranges = Vec::with_capacity(cells as usize);
            for z in 0..cells {
                if level > 0 {
                    let (first, count) = coverage.ranges[level as usize - 1][z as usize / 4];
                    if count == 1 {
                        ranges.push((first, count));
                        continue;
                    }
                    let above = &coverage.shares[first as usize..(first + count) as usize];
                    candidates.clear();
                    candidates.extend(above.iter().map(|s| s.0));
                }
                let cell = Rectangle::cell(level, z);
                let first = coverage.shares.len();
                let area = |&patch: &u32| {
                    let outline = outlines.get(patch as usize)?;
                    Some((patch, outline.area_in(cell) / cell.area())).filter(|s| s.1 > NOTHING)
                };
                coverage.shares.extend(candidates.iter().filter_map(area));
                complete(&mut coverage.shares, first, beyond, candidates.contains(&beyond));
                ranges.push((first as u32, (coverage.shares.len() - first) as u32));
            }
            coverage.ranges.push(ranges);
        }
        coverage
    }

    /// The patches in cell `z` (Z order) of `level`.
    pub(super) fn of(&self, level: u32, z: usize) -> &Shares {
        let (first, count) = self.ranges[level as usize][z];
        &self.shares[first as usize..(first + count) as usize]
    }
}

/// For each patch of `basis` the patches of `among` in it.
pub(super) fn patches_in(basis: &KlemsBasis, among: &KlemsBasis) -> Vec<Vec<(u32, f64)>> {
    let (parts, others) = (Patches::new(basis), Patches::new(among));
    let ring = |basis: &KlemsBasis, r: usize| {
        let (lower, upper) = basis.ring_bounds_degrees(r);
        [lower, upper].map(|degrees| degrees.to_radians().sin().powi(2))
    };
    let shared = |a: [f64; 2], b: [f64; 2]| (a[1].min(b[1]) - a[0].max(b[0])).max(0.0);
    // In turns about the azimuth that patch `k` of `count` is centred on.
    let azimuths = |k: usize, count: usize| [-0.5, 0.5].map(|d| (k as f64 + d) / count as f64);
    let mut all = Vec::with_capacity(parts.count());
    for r in 0..basis.rings().len() {
        let own = ring(basis, r);
        for k in 0..parts.ring(r).len() {
            let turns = azimuths(k, parts.ring(r).len());
            let mut shares = Vec::new();
            for q in 0..among.rings().len() {
                let height = shared(own, ring(among, q)) / (own[1] - own[0]);
                let range = others.ring(q);
                for j in range.clone().filter(|_| height > NOTHING) {
                    let other = azimuths(j - range.start, range.len());
                    let width: f64 =
                        [-1.0, 0.0, 1.0].map(|t| shared(turns, other.map(|x| x + t))).iter().sum();
                    let share = height * width / (turns[1] - turns[0]);
                    if share > NOTHING {
                        shares.push((j as u32, share));
                    }
                }
            }
            complete(&mut shares, 0, others.count() as u32, !among.is_complete());
            all.push(shares);
        }
    }
    all
}

/// The rings of `basis` in cell `z` (Z order) of `level`, with their shares of it.
pub(super) fn rings_in(basis: &KlemsBasis, level: u32, z: u32) -> impl Iterator<Item = (u32, f64)> {
    let cell = Rectangle::cell(level, z);
    (0..basis.rings().len()).filter_map(move |r| {
        let (lower, upper) = basis.ring_bounds_degrees(r);
        let [inner, outer] = [lower, upper].map(|degrees| degrees.to_radians().sin());
        let share = Outline { inner, outer, rays: None }.area_in(cell) / cell.area();
        (share > NOTHING).then_some((r as u32, share))
    })
}

/// Makes the shares from `first` on sum to 1: what is missing lies beyond the basis, or is rounding.
fn complete(shares: &mut Vec<(u32, f64)>, first: usize, beyond: u32, incomplete: bool) {
    let sum: f64 = shares[first..].iter().map(|s| s.1).sum();
    if incomplete && sum < 1.0 - NOTHING {
        shares.push((beyond, 1.0 - sum));
    } else {
        shares[first..].iter_mut().for_each(|s| s.1 /= sum);
    }
}

/// A patch on the square, whose coordinates here run from −1 to 1.
struct Outline {
    /// Half the widths of the squares that bound it: sin θ of its bounds.
    inner: f64,
    outer: f64,
    /// Directions of the rays that bound it, counter-clockwise; none for a whole ring.
    rays: Option<[DVec2; 2]>,
}

fn outlines(basis: &KlemsBasis) -> Vec<Outline> {
    let patches = Patches::new(basis);
    let mut outlines = Vec::with_capacity(patches.count());
    for r in 0..basis.rings().len() {
        let (lower, upper) = basis.ring_bounds_degrees(r);
        let [inner, outer] = [lower, upper].map(|degrees| degrees.to_radians().sin());
        let count = patches.ring(r).len();
        for k in 0..count {
            let ray = |turns: f64| {
                2.0 * disk_to_square(DVec2::from_angle(TAU * turns / count as f64)) - 1.0
            };
            let rays = (count > 1).then(|| [-0.5, 0.5].map(|d| ray(k as f64 + d)));
            outlines.push(Outline { inner, outer, rays });
        }
    }
    outlines
}

impl Outline {
    fn area_in(&self, cell: Rectangle) -> f64 {
        let within = |half: f64| {
            let part = cell.within(half);
            match self.rays {
                _ if part.is_empty() => 0.0,
                None => part.area(),
                Some(rays) => part.area_between(rays),
            }
        };
        within(self.outer) - within(self.inner)
    }
}

#[derive(Clone, Copy)]
struct Rectangle {
    low: DVec2,
    high: DVec2,
}

impl Rectangle {
    fn cell(level: u32, z: u32) -> Self {
        let width = 2.0 / f64::from(1u32 << level);
        let corner = DVec2::new(even_bits(z).into(), even_bits(z >> 1).into());
        let low = corner * width - 1.0;
        Self { low, high: low + width }
    }

    fn within(self, half: f64) -> Self {
        let bound = DVec2::splat(half);
        Self { low: self.low.max(-bound), high: self.high.min(bound) }
    }

    fn is_empty(self) -> bool {
        self.low.x >= self.high.x || self.low.y >= self.high.y
    }

    fn area(self) -> f64 {
        let extent = self.high - self.low;
        extent.x * extent.y
    }

    /// Area counter-clockwise from one ray to the other, half a turn at most.
    fn area_between(self, [from, to]: [DVec2; 2]) -> f64 {
        let (low, high) = (self.low, self.high);
        let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        let left = clipped(&corners, |p| from.perp_dot(p));
        let both = clipped(&left, |p| -to.perp_dot(p));
        let next = |k: usize| both[(k + 1) % both.len()];
        0.5 * (0..both.len()).map(|k| both[k].perp_dot(next(k))).sum::<f64>()
    }
}

/// The part of a convex polygon where `side` is at least 0. [SH74]
fn clipped(polygon: &[DVec2], side: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let mut kept = Vec::with_capacity(polygon.len() + 2);
    for (k, &a) in polygon.iter().enumerate() {
        let b = polygon[(k + 1) % polygon.len()];
        let (at, bt) = (side(a), side(b));
        if at >= 0.0 {
            kept.push(a);
        }
        if (at > 0.0 && bt < 0.0) || (at < 0.0 && bt > 0.0) {
            kept.push(a + (b - a) * (at / (at - bt)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use bsdfkit::matrix::Ring;
    use bsdfkit_sphere::Side;
    use bsdfkit_sphere::concentric::square_to_hemisphere;

    use super::*;

    fn bases() -> [KlemsBasis; 4] {
        let ring = |upper_degrees, patches| Ring { upper_degrees, patches };
        let odd = KlemsBasis::new("odd", vec![ring(20.0, 2), ring(50.0, 7), ring(71.0, 3)]);
        [KlemsBasis::full(), KlemsBasis::half_73(), KlemsBasis::quarter(), odd.unwrap()]
    }

    /// Counted by points as queries number them.
    #[test]
    fn cells_are_covered_as_points_are_numbered() {
        let n = 64;
        for basis in bases() {
            let coverage = Coverage::new(&basis, 5);
            for (level, z) in [(0, 0), (2, 5), (3, 20), (4, 255), (5, 512), (5, 77), (5, 640)] {
                let cell = Rectangle::cell(level, z);
                let mut counted = vec![0.0; basis.directions() + 1];
                for k in 0..n * n {
                    let at = DVec2::new(f64::from(k % n) + 0.5, f64::from(k / n) + 0.5);
                    let place = cell.low + (cell.high - cell.low) * at / f64::from(n);
                    let w = square_to_hemisphere(0.5 * place + 0.5, Side::Front);
                    let patch = basis.index(w).unwrap_or(basis.directions());
                    counted[patch] += 1.0 / f64::from(n * n);
                }
                for &(patch, share) in coverage.of(level, z as usize) {
                    counted[patch as usize] -= share;
                }
                let worst = counted.iter().fold(0.0f64, |w, c| w.max(c.abs()));
                assert!(worst < 1.0 / f64::from(n), "{} {level} {z}: {worst}", basis.name());
            }
        }
    }

    #[test]
    fn cells_of_every_level_make_up_the_patches() {
        for basis in bases() {
            let coverage = Coverage::new(&basis, 4);
            for level in 0..=4 {
                let cells = 1usize << (2 * level);
                let mut sums = vec![0.0; basis.directions() + 1];
                for z in 0..cells {
                    for &(patch, share) in coverage.of(level, z) {
                        sums[patch as usize] += share * std::f64::consts::PI / cells as f64;
                    }
                }
                for (k, sum) in sums[..basis.directions()].iter().enumerate() {
                    assert!((sum - basis.projected_solid_angle(k)).abs() < 1e-12, "{level} {k}");
                }
            }
        }
    }

    #[test]
    fn patches_make_up_patches() {
        for basis in bases() {
            for among in bases() {
                let mut sums = vec![0.0; among.directions() + 1];
                for (k, shares) in patches_in(&basis, &among).iter().enumerate() {
                    assert!((shares.iter().map(|s| s.1).sum::<f64>() - 1.0).abs() < 1e-12);
                    for &(patch, share) in shares {
                        sums[patch as usize] += share * basis.projected_solid_angle(k);
                    }
                }
                for (k, sum) in sums[..among.directions()].iter().enumerate() {
                    let whole = among.projected_solid_angle(k);
                    let within = if basis.is_complete() { whole } else { whole.min(*sum) };
                    assert!((sum - within).abs() < 1e-12 && *sum < whole + 1e-12);
                }
            }
            let own = patches_in(&basis, &basis);
            assert!(own.iter().enumerate().all(|(k, s)| s[..] == [(k as u32, 1.0)]));
        }
    }
}
