//! The disk of scattered directions as a square of pixels: (x, y) of the unit vectors, +Y up.

use bsdfkit::{DVec2, DVec3, Side};
use bsdfkit_measure::{Image, Incidence};

/// Values on the disk; NaN where there is none.
///
/// Pixels have equal projected solid angles, so that sums over them are integrals with the cosine.
#[derive(Clone)]
pub(crate) struct Raster {
    size: usize,
    values: Vec<f64>,
}

impl Raster {
    /// Values that `f` has at the middles of pixels inside the disk, row by row from the top.
    pub(crate) fn of(size: usize, side: Side, f: impl FnOnce(&[DVec3]) -> Vec<f64>) -> Self {
        let inside: Vec<(usize, DVec3)> =
            (0..size * size).filter_map(|k| Some((k, direction(size, k, side)?))).collect();
        let wo: Vec<DVec3> = inside.iter().map(|&(_, w)| w).collect();
        let mut values = vec![f64::NAN; size * size];
        for ((k, _), value) in inside.into_iter().zip(f(&wo)) {
            values[k] = value;
        }
        Self { size, values }
    }

    /// Means of the measured points in each pixel; a pixel without takes the nearest one's within
    /// `reach` pixels.
    pub(crate) fn of_points(
        size: usize,
        incidence: &Incidence,
        channel: usize,
        reach: f64,
    ) -> Self {
        let mut sums = vec![(0.0, 0u32); size * size];
        for (w, value) in incidence.points(channel) {
            let (sum, count) = &mut sums[pixel(size, w.truncate())];
            *sum += value;
            *count += 1;
        }
        let values = sums.iter().map(|&(sum, count)| sum / f64::from(count)).collect();
        let mut raster = Self { size, values };
        raster.fill(reach);
        raster
    }

    /// Sweeps over the square twice, forth and back; every pixel keeps the nearest measured one
    /// that its neighbours know.
    fn fill(&mut self, reach: f64) {
        let n = self.size as isize;
        let mut nearest: Vec<Option<usize>> =
            (0..self.values.len()).map(|k| self.values[k].is_finite().then_some(k)).collect();
        let distance = |k: usize, from: usize| {
            let across = (k % self.size) as f64 - (from % self.size) as f64;
            let down = (k / self.size) as f64 - (from / self.size) as f64;
            across.hypot(down)
        };
        const FORTH: [(isize, isize); 4] = [(-1, 0), (-1, -1), (0, -1), (1, -1)];
        const BACK: [(isize, isize); 4] = [(1, 0), (1, 1), (0, 1), (-1, 1)];
        for pass in 0..4 {
            for step in 0..self.values.len() {
                let k = if pass % 2 == 0 { step } else { self.values.len() - 1 - step };
                let (x, y) = ((k % self.size) as isize, (k / self.size) as isize);
                for (dx, dy) in if pass % 2 == 0 { FORTH } else { BACK } {
                    let (a, b) = (x + dx, y + dy);
                    if !(0..n).contains(&a) || !(0..n).contains(&b) {
                        continue;
                    }
                    let Some(theirs) = nearest[(b * n + a) as usize] else { continue };
                    if nearest[k].is_none_or(|own| distance(k, theirs) < distance(k, own)) {
                        nearest[k] = Some(theirs);
                    }
                }
            }
        }
        for k in 0..self.values.len() {
            if let Some(from) = nearest[k].filter(|&from| distance(k, from) <= reach) {
                self.values[k] = self.values[from];
            }
        }
    }

    /// Pixels along a side.
    pub(crate) fn size(&self) -> usize {
        self.size
    }

    /// The value at pixel (x, y), the first at the upper left.
    pub(crate) fn at(&self, x: usize, y: usize) -> f64 {
        self.values[y * self.size + x]
    }

    /// The value at direction `w`.
    fn at_direction(&self, w: DVec3) -> f64 {
        self.values[pixel(self.size, w.truncate())]
    }

    /// All values that are not NaN.
    pub(crate) fn known(&self) -> impl Iterator<Item = f64> {
        self.values.iter().copied().filter(|v| !v.is_nan())
    }

    /// Σ|f − truth| / Σ truth over pixels that both have.
    pub(crate) fn l1(&self, truth: &Raster) -> f64 {
        let pairs = self.values.iter().zip(&truth.values).filter(|(a, b)| !(*a - *b).is_nan());
        let (difference, sum) = pairs.fold((0.0, 0.0), |(d, s), (a, b)| (d + (a - b).abs(), s + b));
        difference / sum
    }

    /// Σ weights · rasters, each looked at through `fold`.
    pub(crate) fn blend(parts: &[(f64, Raster)], fold: Image, size: usize, side: Side) -> Self {
        Self::of(size, side, |wo| {
            let value = |w: &DVec3| {
                let w = fold.apply(*w);
                parts.iter().map(|(weight, raster)| weight * raster.at_direction(w)).sum()
            };
            wo.iter().map(value).collect()
        })
    }
}

/// The direction at the middle of pixel `k`, if it is inside the disk.
fn direction(size: usize, k: usize, side: Side) -> Option<DVec3> {
    let at = |i: usize| (i as f64 + 0.5) / size as f64 * 2.0 - 1.0;
    let u = DVec2::new(at(k % size), -at(k / size));
    let z2 = 1.0 - u.length_squared();
    (z2 > 0.0).then(|| u.extend(side.sign() * z2.sqrt()))
}

/// The pixel that holds `u` of the disk.
fn pixel(size: usize, u: DVec2) -> usize {
    let at = |x: f64| (((x + 1.0) * 0.5 * size as f64) as usize).min(size - 1);
    at(-u.y) * size + at(u.x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_and_directions_agree() {
        for k in 0..64 * 64 {
            if let Some(w) = direction(64, k, Side::Front) {
                assert!((w.length() - 1.0).abs() < 1e-12);
                assert_eq!(pixel(64, w.truncate()), k);
            }
        }
    }

    #[test]
    fn pixels_take_the_nearest_point_within_reach() {
        let wo = vec![DVec3::Z, DVec3::new(0.8, 0.0, 0.6)];
        let incidence = Incidence::new(DVec3::Z, wo, [1.0, 2.0]);
        let all = Raster::of_points(40, &incidence, 0, 100.0);
        assert_eq!((all.at(22, 20), all.at(34, 25), all.at(0, 39)), (1.0, 2.0, 1.0));
        let near = Raster::of_points(40, &incidence, 0, 3.0);
        assert!(near.at(20, 22) == 1.0 && near.at(20, 26).is_nan());
    }

    #[test]
    fn integrals_are_those_of_projected_solid_angle() {
        let cosine = Raster::of(200, Side::Front, |wo| wo.iter().map(|w| w.z).collect());
        // ∫ cos² dω / π = 2/3.
        let mean = cosine.known().sum::<f64>() / cosine.known().count() as f64;
        assert!((mean - 2.0 / 3.0).abs() < 1e-3, "{mean}");
        let twice = Raster::of(200, Side::Front, |wo| wo.iter().map(|w| 2.0 * w.z).collect());
        assert!((twice.l1(&cosine) - 1.0).abs() < 1e-12);
    }
}
