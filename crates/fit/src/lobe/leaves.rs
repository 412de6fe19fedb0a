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

/// Bins scattered points into leaves that cover the unit disk.
///
/// Dense spirals and sparse sweeps weigh alike: every leaf counts by its area.
/// Cost: O(n log n).
pub fn bin(wo: &[DVec3], values: &[f64]) -> Vec<Leaf> {
    let mut cells: Vec<Vec<u32>> = vec![Vec::new(); BASE * BASE];
    let index = |t: f64| (((t + 1.0) * 0.5 * BASE as f64) as usize).min(BASE - 1);
    for (k, w) in wo.iter().enumerate() {
        cells[index(w.y) * BASE + index(w.x)].push(k as u32);
    }
    let side = 2.0 / BASE as f64;
    let limit = wo.iter().map(|w| w.truncate().length()).fold(0.0, f64::max);
    let points = Points { wo, values, limit };
    let mut leaves = Vec::new();
    for (c, members) in cells.iter_mut().enumerate() {
        let corner = DVec2::new((c % BASE) as f64 * side - 1.0, (c / BASE) as f64 * side - 1.0);
        split(&points, members, corner, side, 0, &mut leaves);
    }
    leaves
}

/// What is binned.
struct Points<'a> {
    wo: &'a [DVec3],
    values: &'a [f64],
    /// The largest sine of a polar angle among them.
    limit: f64,
}

fn split(
    points: &Points<'_>,
    members: &mut [u32],
    corner: DVec2,
    side: f64,
    level: u32,
    out: &mut Vec<Leaf>,
) {
    let Points { wo, values, limit } = *points;
    if level < MAX_SPLITS && members.len() >= 4 * MIN_POINTS {
        let centre = corner + DVec2::splat(side * 0.5);
        let right = |k: &u32| wo[*k as usize].x >= centre.x;
        let upper = |k: &u32| wo[*k as usize].y >= centre.y;
        let (lower, top) = partition(members, upper);
        let (q0, q1) = partition(lower, right);
        let (q2, q3) = partition(top, right);
        let quads = [q0, q1, q2, q3];
        let h = side * 0.5;
        let shift = |i: usize| DVec2::new((i & 1) as f64 * h, (i >> 1) as f64 * h);
        // Quadrants outside the measured polar range need no points to be split.
        let beyond = |i: usize| (corner + shift(i) + DVec2::splat(0.5 * h)).length() > limit;
        let enough = quads.iter().enumerate().all(|(i, q)| q.len() >= MIN_POINTS || beyond(i));
        if enough && !flat(values, &quads) {
            for (i, q) in quads.into_iter().enumerate() {
                split(points, q, corner + shift(i), h, level + 1, out);
            }
            return;
        }
    }
    let area = area_in_disk(corner, side);
    if area > 0.0 || !members.is_empty() {
        out.push(summarise(wo, values, members, corner, side, area));
    }
}

fn partition(members: &mut [u32], pred: impl Fn(&u32) -> bool) -> (&mut [u32], &mut [u32]) {
    let mut cut = 0;
    for i in 0..members.len() {
        if !pred(&members[i]) {
            members.swap(i, cut);
            cut += 1;
        }
    }
    members.split_at_mut(cut)
}

/// Whether the means of quadrants that have points enough agree within [`FLATNESS`] or within their
/// own scatter.
fn flat(values: &[f64], quads: &[&mut [u32]; 4]) -> bool {
    let full = quads.iter().filter(|q| q.len() >= MIN_POINTS);
    let moments: Vec<(f64, f64)> = full.map(|q| moments(values, q)).collect();
    let mean = moments.iter().map(|m| m.0).sum::<f64>() / moments.len().max(1) as f64;
    moments.iter().all(|&(m, variance)| {
        let d = (m - mean).abs();
        d <= FLATNESS * mean.abs() + 1e-5 || d * d <= 2.0 * variance && d <= 0.1 * mean.abs()
    })
}

/// Mean, and variance of the mean.
fn moments(values: &[f64], members: &[u32]) -> (f64, f64) {
    let n = members.len() as f64;
    let mean = members.iter().map(|&k| values[k as usize]).sum::<f64>() / n;
    let ss: f64 = members.iter().map(|&k| (values[k as usize] - mean).powi(2)).sum();
    (mean, ss / (n * (n - 1.0).max(1.0)))
}

fn summarise(
    wo: &[DVec3],
    values: &[f64],
    members: &[u32],
    corner: DVec2,
    side: f64,
    area: f64,
) -> Leaf {
    let n = members.len();
    if n == 0 {
        let u = corner + DVec2::splat(side * 0.5);
        return Leaf { u, value: 0.0, variance: 0.0, count: 0, area, side };
    }
    let (value, variance) = moments(values, members);
    let u = members.iter().map(|&k| wo[k as usize].truncate()).sum::<DVec2>() / n as f64;
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
        let values: Vec<f64> = wo.iter().map(|w| 1.0 + w.x).collect();
        let leaves = bin(&wo, &values);
        let area: f64 = leaves.iter().map(|l| l.area).sum();
        assert!((area - PI).abs() < 0.01, "{area}");
        assert_eq!(leaves.iter().map(|l| l.count as usize).sum::<usize>(), wo.len());
    }

    #[test]
    fn a_dense_patch_does_not_pull_the_integral() {
        let wo = scan();
        let f = |w: &DVec3| 1.0 + w.x + (-(w.truncate() - DVec2::splat(0.3)).length() * 9.0).exp();
        let values: Vec<f64> = wo.iter().map(f).collect();
        let total: f64 = bin(&wo, &values).iter().map(|l| l.area * l.value).sum();
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
        let values: Vec<f64> = wo.iter().map(|w| f(w.truncate())).collect();
        let seen = bin(&wo, &values).into_iter().filter(|l| l.count > 0);
        let off = seen.map(|l| (l.value - f(l.u)).abs() * l.area).sum::<f64>();
        let all = 2.0 * PI * 0.008_f64.powi(2);
        assert!(off < 0.03 * all, "{}", off / all);
    }
}
