//! The patches of a Klems basis as squares of equal measure.

use std::f64::consts::TAU;
use std::ops::Range;

use bsdfkit::matrix::KlemsBasis;
use bsdfkit_sphere::concentric::{disk_to_hemisphere, disk_to_square, square_to_disk};
use bsdfkit_sphere::{DVec2, DVec3, Side};

/// Patches with maps from and to the unit square, uniform in projected solid angle.
pub(super) struct Patches<'a> {
    basis: &'a KlemsBasis,
    /// First patch of each ring, then the number of patches.
    first: Vec<usize>,
    /// sin θ of the outer bound where the first ring is one patch: a disk, mapped concentrically.
    disk: Option<f64>,
}

impl<'a> Patches<'a> {
    pub(super) fn new(basis: &'a KlemsBasis) -> Self {
        let mut first = vec![0];
        for ring in basis.rings() {
            first.push(first[first.len() - 1] + ring.patches);
        }
        let disk = (first[1] == 1).then(|| basis.ring_bounds_degrees(0).1.to_radians().sin());
        Self { basis, first, disk }
    }

    /// Number of patches.
    pub(super) fn count(&self) -> usize {
        self.basis.directions()
    }

    pub(super) fn projected_solid_angle(&self, patch: usize) -> f64 {
        self.basis.projected_solid_angle(patch)
    }

    /// Largest extent of a patch in the projected disk.
    pub(super) fn width(&self, patch: usize) -> f64 {
        let ring = self.ring_of(patch);
        let (lower, upper) = self.basis.ring_bounds_degrees(ring);
        let (inner, outer) = (lower.to_radians().sin(), upper.to_radians().sin());
        match self.ring(ring).len() {
            1 => 2.0 * outer,
            patches => (outer - inner).max(outer * TAU / patches as f64),
        }
    }

    /// The patches of a ring.
    pub(super) fn ring(&self, ring: usize) -> Range<usize> {
        self.first[ring]..self.first[ring + 1]
    }

    pub(super) fn ring_of(&self, patch: usize) -> usize {
        self.first.partition_point(|&first| first <= patch) - 1
    }

    /// Patch and point of the unit square → direction in basis form.
    pub(super) fn place(&self, patch: usize, point: DVec2) -> DVec3 {
        match self.disk {
            Some(sin) if patch == 0 => disk_to_hemisphere(sin * square_to_disk(point), Side::Front),
            _ => self.basis.direction_in(patch, point),
        }
    }

    /// Direction of ring `ring` at azimuth 0, uniform in projected solid angle for uniform `u`.
    pub(super) fn polar(&self, ring: usize, u: f64) -> DVec3 {
        self.basis.direction_in(self.first[ring], DVec2::new(u, 0.5))
    }

    /// Inverse of [`Patches::place`]; `None` beyond the last ring.
    pub(super) fn find(&self, w: DVec3) -> Option<(usize, DVec2)> {
        let patch = self.basis.index(w)?;
        if let (Some(sin), 0) = (self.disk, patch) {
            return Some((0, disk_to_square(w.truncate() / sin)));
        }
        let ring = self.ring_of(patch);
        let (lower, upper) = self.basis.ring_bounds_degrees(ring);
        let cos2 = |degrees: f64| degrees.to_radians().cos().powi(2);
        let u = (cos2(lower) - w.z * w.z) / (cos2(lower) - cos2(upper));
        let patches = self.ring(ring);
        let azimuth = w.y.atan2(w.x) / TAU * patches.len() as f64 + 0.5;
        Some((patch, DVec2::new(u, azimuth - azimuth.floor())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn find_undoes_place() {
        for basis in [KlemsBasis::full(), KlemsBasis::half(), KlemsBasis::quarter()] {
            let patches = Patches::new(&basis);
            for k in 0..patches.count() {
                for point in [DVec2::new(0.2, 0.7), DVec2::new(0.9, 0.05), DVec2::splat(0.45)] {
                    let (found, at) = patches.find(patches.place(k, point)).unwrap();
                    assert!(found == k && at.distance(point) < 1e-9, "{k} {point}: {found} {at}");
                }
            }
        }
    }

    #[test]
    fn the_concentric_patch_is_uniform() {
        let basis = KlemsBasis::full();
        let patches = Patches::new(&basis);
        let n = 200;
        let middle = (0..n * n)
            .filter(|k| {
                let point = DVec2::new(f64::from(k % n) + 0.5, f64::from(k / n) + 0.5);
                let w = patches.place(0, point / f64::from(n));
                w.truncate().length() < 0.5 * 5f64.to_radians().sin()
            })
            .count();
        assert!((middle as f64 / f64::from(n * n) - 0.25).abs() < 2e-3);
    }
}
