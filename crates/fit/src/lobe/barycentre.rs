//! Wasserstein barycentres of three Gaussians and the maps from them, of several triples side by side. [AE16]

use super::covariance::Covariance;

/// Sweeps reach 1e-6 relative for axis ratios up to 30.
const SWEEPS: usize = 6;

/// `N` symmetric matrices: xx, xy, yy.
pub(crate) type Each<const N: usize> = [[f64; N]; 3];

/// The barycentres of `N` triples, and the optimal-transport maps from each to its three Gaussians.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Barycentres<const N: usize> {
    pub(crate) covariance: Each<N>,
    pub(crate) maps: [Each<N>; 3],
}

impl<const N: usize> Barycentres<N> {
    /// `weights` by Gaussian, summing to 1 for each triple.
    ///
    /// Fixed point S ← T S T, where T = Σ λᵢ Tᵢ and Tᵢ maps N(0, S) to N(0, Sᵢ): what S^-½ (Σ λ (S½ Sᵢ S½)½)² S^-½ is,
    /// without square roots of matrices.
    #[inline(always)]
    pub(crate) fn of(weights: &[[f64; N]; 3], parts: &[Each<N>; 3]) -> Self {
        let mut s = [[0.0; N]; 3];
        for i in 0..3 {
            for entry in 0..3 {
                for k in 0..N {
                    s[entry][k] += weights[i][k] * parts[i][entry][k];
                }
            }
        }
        let roots = [root(&parts[0]), root(&parts[1]), root(&parts[2])];
        for _ in 0..SWEEPS {
            let (own, mut t) = (root(&s), [[0.0; N]; 3]);
            for i in 0..3 {
                let (map, norm) = unscaled(&s, &own, &parts[i], &roots[i]);
                let mut share = [0.0; N];
                for k in 0..N {
                    share[k] = weights[i][k] / norm[k];
                }
                for entry in 0..3 {
                    for k in 0..N {
                        t[entry][k] += share[k] * map[entry][k];
                    }
                }
            }
            s = congruence(&s, &t);
        }
        let own = root(&s);
        let mut maps = [[[0.0; N]; 3]; 3];
        for i in 0..3 {
            let (map, norm) = unscaled(&s, &own, &parts[i], &roots[i]);
            for entry in 0..3 {
                for k in 0..N {
                    maps[i][entry][k] = map[entry][k] / norm[k];
                }
            }
        }
        Self { covariance: s, maps }
    }
}

/// √det.
#[inline(always)]
fn root<const N: usize>([xx, xy, yy]: &Each<N>) -> [f64; N] {
    let mut root = [0.0; N];
    for k in 0..N {
        root[k] = (xx[k] * yy[k] - xy[k] * xy[k]).max(1e-300).sqrt();
    }
    root
}

/// The maps from N(0, S) to N(0, N), times a number, and the number: of 2 × 2 matrices
/// S⁻¹ (S N)½ = (N + √(det N / det S) adj S) / √(tr S N + 2 √(det S det N)).
#[inline(always)]
fn unscaled<const N: usize>(
    s: &Each<N>,
    root_s: &[f64; N],
    n: &Each<N>,
    root_n: &[f64; N],
) -> (Each<N>, [f64; N]) {
    let (mut map, mut norm) = ([[0.0; N]; 3], [0.0; N]);
    for k in 0..N {
        let ratio = root_n[k] / root_s[k];
        map[0][k] = n[0][k] + ratio * s[2][k];
        map[1][k] = n[1][k] - ratio * s[1][k];
        map[2][k] = n[2][k] + ratio * s[0][k];
        let trace = s[0][k] * n[0][k] + 2.0 * s[1][k] * n[1][k] + s[2][k] * n[2][k];
        norm[k] = (trace + 2.0 * root_s[k] * root_n[k]).max(1e-300).sqrt();
    }
    (map, norm)
}

/// T S T of symmetric matrices.
#[inline(always)]
fn congruence<const N: usize>([xx, xy, yy]: &Each<N>, t: &Each<N>) -> Each<N> {
    let mut product = [[0.0; N]; 3];
    for k in 0..N {
        let (t0, t1, t2) = (t[0][k], t[1][k], t[2][k]);
        let (b00, b01) = (xx[k] * t0 + xy[k] * t1, xx[k] * t1 + xy[k] * t2);
        let (b10, b11) = (xy[k] * t0 + yy[k] * t1, xy[k] * t1 + yy[k] * t2);
        product[0][k] = t0 * b00 + t1 * b10;
        product[1][k] = t0 * b01 + t1 * b11;
        product[2][k] = t1 * b01 + t2 * b11;
    }
    product
}

impl Covariance {
    /// The linear optimal-transport map from N(0, self) to N(0, n), symmetric positive.
    pub fn transport_to(self, n: Self) -> Self {
        let [s, n] = [self, n].map(|c| [[c.xx], [c.xy], [c.yy]]);
        let ([[xx], [xy], [yy]], [norm]) = unscaled(&s, &root(&s), &n, &root(&n));
        Self { xx: xx / norm, xy: xy / norm, yy: yy / norm }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Covariance = Covariance { xx: 0.04, xy: 0.01, yy: 0.09 };
    const B: Covariance = Covariance { xx: 0.2, xy: -0.05, yy: 0.03 };
    const C: Covariance = Covariance { xx: 0.011, xy: 0.009, yy: 0.01 };

    fn close(a: Covariance, b: Covariance) -> bool {
        (a.xx - b.xx).abs() + (a.xy - b.xy).abs() + (a.yy - b.yy).abs() < 1e-9
    }

    fn one<const N: usize>(each: &Each<N>, k: usize) -> Covariance {
        Covariance { xx: each[0][k], xy: each[1][k], yy: each[2][k] }
    }

    fn spread<const N: usize>(c: Covariance) -> Each<N> {
        [[c.xx; N], [c.xy; N], [c.yy; N]]
    }

    #[test]
    fn transport_map_pushes_one_gaussian_to_the_other() {
        assert!(close(A.congruence(A.transport_to(B)), B));
    }

    #[test]
    fn barycentre_halfway_is_on_the_geodesic() {
        let t = Covariance::combine(0.5, Covariance::isotropic(1.0), 0.5, A.transport_to(B));
        let both = Barycentres::of(
            &[[0.5], [0.5], [0.0]],
            &[A, B, Covariance::isotropic(1.0)].map(spread),
        );
        let c = one(&both.covariance, 0);
        let d = Covariance::combine(1.0, c, -1.0, A.congruence(t));
        assert!(d.xx.abs() + d.xy.abs() + d.yy.abs() < 1e-6 * c.trace());
    }

    /// Maps go to the three, and their mean with the weights leaves the barycentre where it is.
    #[test]
    fn barycentre_is_the_fixed_point_at_every_place() {
        let weights =
            [[0.2, 1.0, 0.0, 1.0 / 3.0], [0.3, 0.0, 0.4, 1.0 / 3.0], [0.5, 0.0, 0.6, 1.0 / 3.0]];
        let all = Barycentres::of(&weights, &[A, B, C].map(spread));
        for k in 0..4 {
            let s = one(&all.covariance, k);
            let mut mean = Covariance { xx: 0.0, xy: 0.0, yy: 0.0 };
            for (i, n) in [A, B, C].into_iter().enumerate() {
                let map = one(&all.maps[i], k);
                assert!(close(s.congruence(map), n), "{k} {i}: {map:?}");
                mean = Covariance::combine(1.0, mean, weights[i][k], map);
            }
            let off = Covariance::combine(1.0, mean, -1.0, Covariance::isotropic(1.0));
            assert!(off.xx.abs() + off.xy.abs() + off.yy.abs() < 1e-4, "{k}: {mean:?}");
        }
        assert!(close(one(&all.covariance, 1), A));
    }

    /// What [`Reach`](crate::interpolant::motion) rests on: no barycentre is wider in any direction than the mean of the matrices.
    #[test]
    fn a_barycentre_lies_within_the_mean_of_the_matrices() {
        for (a, b, c) in [(0.2, 0.3, 0.5), (0.9, 0.05, 0.05), (0.0, 0.5, 0.5)] {
            let all = Barycentres::of(&[[a], [b], [c]], &[A, B, C].map(spread));
            let s = one(&all.covariance, 0);
            let mean = Covariance::combine(1.0, Covariance::combine(a, A, b, B), c, C);
            let left = Covariance::combine(1.0, mean, -1.0, s);
            assert!(left.trace() > 0.0 && left.determinant() > -1e-15, "{left:?}");
        }
    }
}
