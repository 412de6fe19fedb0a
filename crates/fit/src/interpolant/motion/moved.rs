//! Lobes on their way, and their sums at several directions side by side.

use bsdfkit::DVec2;

use crate::lobe::exponential::exp;
use crate::lobe::{Covariance, Lobe};

/// A lobe on its way, and the affine optimal-transport maps back to where it came from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moved {
    /// The lobe at the queried incidence.
    pub lobe: Lobe,
    /// Inverse covariance.
    pub precision: Covariance,
    /// Peak value, mass / (2π √det Σ).
    pub peak: f64,
    /// Per corner: centre there, and A with q_v = centre_v + A (q − centre).
    pub maps: [(DVec2, Covariance); 3],
    /// Per corner: how much it has to say about this lobe, 1 in all.
    pub shares: [f64; 3],
    /// The number of the facet that it follows.
    pub facet: Option<u8>,
}

impl Moved {
    /// `maps` and `shares` as in the fields.
    pub(crate) fn new(lobe: Lobe, maps: [(DVec2, Covariance); 3], shares: [f64; 3]) -> Self {
        let peak = lobe.mass / (std::f64::consts::TAU * lobe.covariance.determinant().sqrt());
        Self { lobe, precision: lobe.covariance.inverse(), peak, maps, shares, facet: None }
    }
}

/// Lobes are cut at this exponent: exp(−16) of the peak.
pub(crate) const CUT: f64 = 32.0;

/// The sums of moved lobes at `N` directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sums<const N: usize> {
    /// Σ lobes.
    pub(crate) density: [f64; N],
    /// Σ lobe · where it comes from, by corner: x and y.
    places: [[[f64; N]; 2]; 3],
    /// Σ lobe · share, by corner.
    shares: [[f64; N]; 3],
}

impl<const N: usize> Sums<N> {
    /// At frame coordinates `q`, x and y.
    #[inline(always)]
    pub(crate) fn at([x, y]: [[f64; N]; 2], lobes: &[Moved]) -> Self {
        let (places, shares) = ([[[0.0; N]; 2]; 3], [[0.0; N]; 3]);
        let mut sums = Self { density: [0.0; N], places, shares };
        for moved in lobes {
            let (mean, p) = (moved.lobe.mean, moved.precision);
            let (mut dx, mut dy, mut e) = ([0.0; N], [0.0; N], [0.0; N]);
            let mut least = f64::MAX;
            for k in 0..N {
                (dx[k], dy[k]) = (x[k] - mean.x, y[k] - mean.y);
                e[k] = p.quadratic(DVec2::new(dx[k], dy[k]));
                least = least.min(e[k]);
            }
            if least >= CUT {
                continue;
            }
            let mut g = [0.0; N];
            for k in 0..N {
                let value = moved.peak * f64::from(exp(-0.5 * e[k] as f32));
                g[k] = if e[k] < CUT { value } else { 0.0 };
                sums.density[k] += g[k];
            }
            for ([px, py], (centre, map)) in sums.places.iter_mut().zip(&moved.maps) {
                for k in 0..N {
                    px[k] += g[k] * (centre.x + map.xx * dx[k] + map.xy * dy[k]);
                    py[k] += g[k] * (centre.y + map.xy * dx[k] + map.yy * dy[k]);
                }
            }
            for (sum, share) in sums.shares.iter_mut().zip(moved.shares) {
                for k in 0..N {
                    sum[k] += g[k] * share;
                }
            }
        }
        sums
    }

    /// Σ lobe · where it comes from, of one corner and direction.
    #[inline]
    pub(crate) fn place(&self, corner: usize, direction: usize) -> DVec2 {
        let [x, y] = &self.places[corner];
        DVec2::new(x[direction], y[direction])
    }

    /// Σ lobe · share, of one corner and direction.
    #[inline]
    pub(crate) fn share(&self, corner: usize, direction: usize) -> f64 {
        self.shares[corner][direction]
    }
}
