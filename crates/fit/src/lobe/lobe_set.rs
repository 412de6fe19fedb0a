//! Gaussian lobes of one incidence.

use bsdfkit_sphere::DVec2;

use super::covariance::Covariance;

/// One positive Gaussian in frame coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// Integral over the plane: the share of the directional-hemispherical value it carries.
    pub mass: f64,
    /// Centre.
    pub mean: DVec2,
    /// Shape.
    pub covariance: Covariance,
}

impl Lobe {
    /// mass · N(q; mean, covariance).
    pub fn density(&self, q: DVec2) -> f64 {
        let e = self.covariance.inverse().quadratic(q - self.mean);
        self.mass / (std::f64::consts::TAU * self.covariance.determinant().sqrt())
            * (-0.5 * e).exp()
    }

    /// How far apart centres and shapes are, squared.
    fn apart(&self, other: &Self) -> f64 {
        self.mean.distance_squared(other.mean) + self.covariance.bures_squared(other.covariance)
    }

    /// Whether centres and shapes differ by less than a fifth of the extent.
    fn nearly_is(&self, other: &Self) -> bool {
        self.apart(other) < 0.04 * self.covariance.trace().min(other.covariance.trace())
    }

    /// Mass, centre and shape half-way between both.
    fn mean_with(&self, other: &Self) -> Self {
        let (a, b) = (self.covariance, other.covariance);
        let covariance = Covariance {
            xx: 0.5 * (a.xx + b.xx),
            xy: 0.5 * (a.xy + b.xy),
            yy: 0.5 * (a.yy + b.yy),
        };
        let mass = 0.5 * (self.mass + other.mass);
        Self { mass, mean: 0.5 * (self.mean + other.mean), covariance }
    }

    /// The lobe under the orthogonal map that takes +X to `x` and +Y to `y`.
    #[must_use]
    pub fn transformed(&self, x: DVec2, y: DVec2) -> Self {
        let c = self.covariance;
        let (cx, cy) = (c.xx * x + c.xy * y, c.xy * x + c.yy * y);
        Self {
            mass: self.mass,
            mean: self.mean.x * x + self.mean.y * y,
            covariance: Covariance {
                xx: x.x * cx.x + y.x * cy.x,
                xy: x.y * cx.x + y.y * cy.x,
                yy: x.y * cx.y + y.y * cy.y,
            },
        }
    }
}

/// The fitted model of one incidence: f(u) = floor + Σ lobes(q(u)) / |du/dq|.
#[derive(Clone, Debug, PartialEq)]
pub struct LobeSet {
    /// Lambertian floor, 1/sr; never transported.
    pub floor: f64,
    /// Lobes in frame coordinates.
    pub lobes: Vec<Lobe>,
}

impl LobeSet {
    /// Mass of all lobes.
    pub fn total(&self) -> f64 {
        self.lobes.iter().map(|l| l.mass).sum()
    }

    /// So many times as bright.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        let lobes = self.lobes.iter().map(|l| Lobe { mass: factor * l.mass, ..*l }).collect();
        Self { floor: factor * self.floor, lobes }
    }

    /// Σ lobes at frame coordinates `q`, without the floor.
    pub fn density(&self, q: DVec2) -> f64 {
        self.lobes.iter().map(|l| l.density(q)).sum()
    }

    /// The mean of the set and its image under a mirror or half turn that takes +X to `x` and +Y to
    /// `y`: exactly symmetric. Lobes that (nearly) coincide with an image become one with it.
    #[must_use]
    pub fn symmetrised(&self, x: DVec2, y: DVec2) -> Self {
        let mut left: Vec<Lobe> = self.lobes.clone();
        let mut lobes: Vec<Lobe> = Vec::new();
        while let Some(lobe) = left.pop() {
            let image = lobe.transformed(x, y);
            if lobe.nearly_is(&image) {
                lobes.push(lobe.mean_with(&image));
                continue;
            }
            let near = (0..left.len()).filter(|&k| left[k].nearly_is(&image));
            let apart = |k: usize| left[k].apart(&image);
            let partner = near.min_by(|&j, &k| apart(j).total_cmp(&apart(k)));
            let one = match partner {
                Some(k) => lobe.mean_with(&left.remove(k).transformed(x, y)),
                None => Lobe { mass: 0.5 * lobe.mass, ..lobe },
            };
            lobes.extend([one, one.transformed(x, y)]);
        }
        lobes.reverse();
        Self { floor: self.floor, lobes }
    }

    /// Lobes that overlap (the centre of one within three deviations of the other's), together.
    pub(crate) fn peaks(&self) -> Vec<Vec<u16>> {
        let overlap = |a: &Lobe, b: &Lobe| {
            let narrow = if a.covariance.trace() < b.covariance.trace() { a } else { b };
            narrow.covariance.inverse().quadratic(a.mean - b.mean) < 9.0
        };
        let mut peaks: Vec<Vec<u16>> = Vec::new();
        for (i, lobe) in self.lobes.iter().enumerate() {
            let near =
                |peak: &Vec<u16>| peak.iter().any(|&j| overlap(lobe, &self.lobes[j as usize]));
            let (joined, apart): (Vec<_>, Vec<_>) = peaks.into_iter().partition(near);
            peaks = apart;
            peaks.push(joined.into_iter().flatten().chain([i as u16]).collect());
        }
        peaks
    }

    /// The set under the orthogonal map that takes +X to `x` and +Y to `y`.
    #[must_use]
    pub fn transformed(&self, x: DVec2, y: DVec2) -> Self {
        let lobes = self.lobes.iter().map(|l| l.transformed(x, y)).collect();
        Self { floor: self.floor, lobes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_lobe_has_the_same_value_at_the_turned_place() {
        let lobe = Lobe {
            mass: 0.3,
            mean: DVec2::new(0.2, -0.1),
            covariance: Covariance { xx: 0.02, xy: 0.006, yy: 0.01 },
        };
        let q = DVec2::new(0.25, -0.02);
        for (x, y) in [(DVec2::NEG_X, DVec2::Y), (DVec2::Y, DVec2::NEG_X)] {
            let turned = lobe.transformed(x, y).density(q.x * x + q.y * y);
            assert!((turned / lobe.density(q) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_symmetrised_set_is_its_own_image_and_keeps_its_mass() {
        let lobe = |mass, x, y, xy| Lobe {
            mass,
            mean: DVec2::new(x, y),
            covariance: Covariance { xx: 0.02, xy, yy: 0.01 },
        };
        // Beside the mirror; almost on it; two that are almost each other's images.
        let lobes = vec![
            lobe(0.3, 0.1, 0.4, 0.003),
            lobe(0.2, 0.5, 0.002, 0.0003),
            lobe(0.1, -0.5, 0.3, 0.001),
            lobe(0.12, -0.501, -0.299, -0.001),
        ];
        let set = LobeSet { floor: 0.05, lobes }.symmetrised(DVec2::X, DVec2::NEG_Y);
        assert_eq!(set.lobes.len(), 5);
        assert!((set.total() - 0.72).abs() < 1e-12);
        for k in 0..60 {
            let q = DVec2::new(f64::from(k % 10) * 0.17 - 0.8, f64::from(k / 10) * 0.11);
            let other = set.density(DVec2::new(q.x, -q.y));
            assert!((set.density(q) - other).abs() < 1e-12 * other.max(1.0), "{q}");
        }
        // The other mirror and the half turn that they make leave it so.
        let both = set.symmetrised(DVec2::NEG_X, DVec2::Y);
        let turned = both.symmetrised(DVec2::NEG_X, DVec2::NEG_Y);
        assert_eq!((both.lobes.len(), turned.lobes.len()), (10, 10));
        let q = DVec2::new(0.13, 0.37);
        for p in [-q, DVec2::new(q.x, -q.y), DVec2::new(-q.x, q.y)] {
            assert!((turned.density(p) / turned.density(q) - 1.0).abs() < 1e-12, "{p}");
        }
    }
}
