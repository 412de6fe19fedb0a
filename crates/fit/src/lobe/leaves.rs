//! Adaptive binning of one incidence: area, not count, is the weight of a point.

use bsdfkit_sphere::{DVec2, DVec3};

/// Cells across the disk before any split; a cell is then 1/16 = 3.6 degrees at the normal.
const BASE: usize = 32;
/// Splits of a base cell: down to 1/512 of the disk's radius (0.11 degrees at the normal).
const MAX_SPLITS: u32 = 5;
/// A quadrant with fewer points cannot tell a gradient from noise.
const MIN_POINTS: usize = 4;
/// Quadrant means within this relative distance need no split: 1 % keeps the binning below the
/// lobe fit's own error. Doubling it coarsens flanks visibly.
const FLATNESS: f64 = 0.01;

/// Quadrant means within this share of the mean over the disk need no split, either: nothing is seen of it.
const DARK: f64 = 6e-5;

/// A square cell of the disk of direction cosines with the points that fell into it.
#[derive(Clone, Copy, Debug)]
pub struct Leaf {
    /// Mean position of the points (cell centre when there are none), u = (x, y) of the direction.
    pub u: DVec2,
    /// Mean of f, 1/sr.
    pub value: f64,
    /// Variance of the mean, from the scatter of the points.
    pub variance: f64,
    /// Number of points; 0: inside the disk but unobserved.
    pub count: u32,
    /// Area inside the unit disk: projected solid angle, sr.
    pub area: f64,
    /// Side of the cell.
    pub side: f64,
}

/// Bins scattered points, directions with values, into leaves that cover the unit disk.
///
/// Dense spirals and sparse sweeps weigh alike: every leaf counts by its area.
/// Cost: O(n log n); 12 bytes a point.
pub fn bin(points: impl IntoIterator<Item = (DVec3, f64)>) -> Vec<Leaf> {
    let of = |(w, value): (DVec3, f64)| Point { u: [w.x as f32, w.y as f32], value: value as f32 };
    let mut points: Vec<Point> = points.into_iter().map(of).collect();
    let ends = sort(&mut points);
    let side = 2.0 / BASE as f64;
    let limit = points.iter().map(|p| p.u().length()).fold(0.0, f64::max);
    let dark = DARK * mean(&points, &ends);
    let mut leaves = Vec::new();
    let mut first = 0;
    for (c, end) in ends.into_iter().enumerate() {
        let corner = DVec2::new((c % BASE) as f64 * side - 1.0, (c / BASE) as f64 * side - 1.0);
        split(&mut points[first..end], (limit, dark), corner, side, 0, &mut leaves);
        first = end;
    }
    leaves
}

/// The mean of |f| over base cells that have points.
fn mean(points: &[Point], ends: &[usize]) -> f64 {
    let (mut sum, mut cells, mut first) = (0.0, 0, 0);
    for &end in ends {
        let own = &points[first..end];
        if !own.is_empty() {
            sum += own.iter().map(|p| p.value().abs()).sum::<f64>() / own.len() as f64;
            cells += 1;
        }
        first = end;
    }
    sum / f64::from(cells.max(1))
}

/// Sorts by base cell, in place; the end of each.
fn sort(points: &mut [Point]) -> Vec<usize> {
    let mut ends = vec![0; BASE * BASE];
    points.iter().for_each(|p| ends[p.cell()] += 1);
    let mut sum = 0;
    let mut next = Vec::with_capacity(ends.len());
    for end in &mut ends {
        next.push(sum);
        sum += *end;
        *end = sum;
    }
    for c in 0..ends.len() {
        while next[c] < ends[c] {
            let own = points[next[c]].cell();
            points.swap(next[c], next[own]);
            next[own] += 1;
        }
    }
    ends
}

/// What is binned.
#[derive(Clone, Copy)]
struct Point {
    u: [f32; 2],
    value: f32,
}

impl Point {
    #[inline]
    fn u(&self) -> DVec2 {
        DVec2::new(f64::from(self.u[0]), f64::from(self.u[1]))
    }

    fn value(&self) -> f64 {
        f64::from(self.value)
    }

    /// The base cell that it is in.
    #[inline]
    fn cell(&self) -> usize {
        let index = |t: f64| (((t + 1.0) * 0.5 * BASE as f64) as usize).min(BASE - 1);
        let u = self.u();
        index(u.y) * BASE + index(u.x)
    }
}

/// `limit`: the largest sine of a polar angle among all points; `dark`: what counts as nothing beside f, 1/sr.
fn split(
    members: &mut [Point],
    (limit, dark): (f64, f64),
    corner: DVec2,
    side: f64,
    level: u32,
    out: &mut Vec<Leaf>,
) {
    if level < MAX_SPLITS && members.len() >= 4 * MIN_POINTS {
        let centre = corner + DVec2::splat(side * 0.5);
        let right = |p: &Point| p.u().x >= centre.x;
        let upper = |p: &Point| p.u().y >= centre.y;
        let (lower, top) = partition(members, upper);
        let (q0, q1) = partition(lower, right);
        let (q2, q3) = partition(top, right);
        let quads = [q0, q1, q2, q3];
        let h = side * 0.5;
        let shift = |i: usize| DVec2::new((i & 1) as f64 * h, (i >> 1) as f64 * h);
        // Quadrants outside the measured polar range need no points to be split.
        let beyond = |i: usize| (corner + shift(i) + DVec2::splat(0.5 * h)).length() > limit;
        let enough = quads.iter().enumerate().all(|(i, q)| q.len() >= MIN_POINTS || beyond(i));
        if enough && !flat(&quads, dark) {
            for (i, q) in quads.into_iter().enumerate() {
                split(q, (limit, dark), corner + shift(i), h, level + 1, out);
            }
            return;
        }
    }
    let area = area_in_disk(corner, side);
    if area > 0.0 || !members.is_empty() {
        out.push(summarise(members, corner, side, area));
    }
}

fn partition(members: &mut [Point], pred: impl Fn(&Point) -> bool) -> (&mut [Point], &mut [Point]) {
    let mut cut = 0;
    for i in 0..members.len() {
        if !pred(&members[i]) {
            members.swap(i, cut);
            cut += 1;
        }
    }
    members.split_at_mut(cut)
}

/// Whether the means of quadrants that have points enough agree within [`FLATNESS`], within what counts as nothing, or
/// within their own scatter.
fn flat(quads: &[&mut [Point]; 4], dark: f64) -> bool {
    let full = quads.iter().filter(|q| q.len() >= MIN_POINTS);
    let moments: Vec<(f64, f64)> = full.map(|q| moments(q)).collect();
    let mean = moments.iter().map(|m| m.0).sum::<f64>() / moments.len().max(1) as f64;
    moments.iter().all(|&(m, variance)| {
        let d = (m - mean).abs();
        d <= FLATNESS * mean.abs() + dark || d * d <= 2.0 * variance && d <= 0.1 * mean.abs()
    })
}

/// Mean, and variance of the mean.
fn moments(members: &[Point]) -> (f64, f64) {
    let n = members.len() as f64;
    let mean = members.iter().map(Point::value).sum::<f64>() / n;
    let ss: f64 = members.iter().map(|p| (p.value() - mean).powi(2)).sum();
    (mean, ss / (n * (n - 1.0).max(1.0)))
}

fn summarise(members: &[Point], corner: DVec2, side: f64, area: f64) -> Leaf {
    let n = members.len();
    if n == 0 {
        let u = corner + DVec2::splat(side * 0.5);
        return Leaf { u, value: 0.0, variance: 0.0, count: 0, area, side };
    }
    let (value, variance) = moments(members);
    let u = members.iter().map(Point::u).sum::<DVec2>() / n as f64;
    Leaf { u, value, variance, count: n as u32, area, side }
}

/// Area of the square inside the unit disk, by 8×8 sub-cells where the rim crosses it.
fn area_in_disk(corner: DVec2, side: f64) -> f64 {
    let far = corner.abs().max((corner + DVec2::splat(side)).abs());
    if far.length_squared() <= 1.0 {
        return side * side;
    }
    const N: usize = 8;
    let step = side / N as f64;
    let inside = (0..N * N)
        .filter(|i| {
            let p = DVec2::new((i % N) as f64 + 0.5, (i / N) as f64 + 0.5) * step;
            (corner + p).length_squared() < 1.0
        })
        .count();
    inside as f64 * step * step
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn scan() -> Vec<DVec3> {
        // A coarse grid plus a dense patch, as sweeps and a spiral would give.
        let mut points = Vec::new();
        for i in 0..100 {
            for j in 0..100 {
                points.push(DVec2::new(f64::from(i) / 50.0 - 0.99, f64::from(j) / 50.0 - 0.99));
                let patch = DVec2::new(f64::from(i), f64::from(j)) * 1e-3;
                points.push(DVec2::new(0.3, 0.2) + patch);
            }
        }
        points.retain(|p| p.length() < 0.995);
        points.into_iter().map(|p| p.extend((1.0 - p.length_squared()).sqrt())).collect()
    }

    #[test]
    fn areas_sum_to_the_disk_and_counts_to_the_points() {
        let wo = scan();
        let leaves = bin(wo.iter().map(|w| (*w, 1.0 + w.x)));
        let area: f64 = leaves.iter().map(|l| l.area).sum();
        assert!((area - PI).abs() < 0.01, "{area}");
        assert_eq!(leaves.iter().map(|l| l.count as usize).sum::<usize>(), wo.len());
    }

    #[test]
    fn a_dense_patch_does_not_pull_the_integral() {
        let wo = scan();
        let f = |w: &DVec3| 1.0 + w.x + (-(w.truncate() - DVec2::splat(0.3)).length() * 9.0).exp();
        let total: f64 = bin(wo.iter().map(|w| (*w, f(w)))).iter().map(|l| l.area * l.value).sum();
        let n = 2000;
        let mut truth = 0.0;
        for i in 0..n * n {
            let p =
                DVec2::new(f64::from(i % n) + 0.5, f64::from(i / n) + 0.5) * (2.0 / f64::from(n));
            let p = p - DVec2::ONE;
            if p.length_squared() < 1.0 {
                truth += f(&p.extend(0.0)) * 4.0 / f64::from(n * n);
            }
        }
        assert!((total / truth - 1.0).abs() < 0.01, "{total} {truth}");
    }

    #[test]
    fn a_peak_at_the_last_polar_angle_seen_is_resolved() {
        // 82 degrees are seen; the peak is 1.5 degrees within.
        let (limit, top) = (82f64.to_radians().sin(), DVec2::new(0.986, 0.0));
        let f = |u: DVec2| (-(u - top).length_squared() / (2.0 * 0.008_f64.powi(2))).exp();
        let golden = |k: i32| {
            let t = f64::from(k) + 0.5;
            top + DVec2::from_angle(2.399_963 * t) * (t / 20_000.0).sqrt() * 0.1
        };
        let wo: Vec<DVec3> = (0..20_000)
            .map(golden)
            .filter(|u| u.length() < limit)
            .map(|u| u.extend((1.0 - u.length_squared()).sqrt()))
            .collect();
        let points = wo.iter().map(|w| (*w, f(w.truncate())));
        let seen = bin(points).into_iter().filter(|l| l.count > 0);
        let off = seen.map(|l| (l.value - f(l.u)).abs() * l.area).sum::<f64>();
        let all = 2.0 * PI * 0.008_f64.powi(2);
        assert!(off < 0.03 * all, "{}", off / all);
    }
}
