//! Layers put together: what passes, comes back and stays, with all reflections between. [K94]

use bsdfkit::matrix::KlemsBasis;
use bsdfkit::{Error, Result};

use super::layer::Matrices;

/// Matrices n × n in 1/sr, and absorptances by layer and incident patch.
pub(super) struct System {
    pub(super) transmission: Vec<f64>,
    pub(super) reflection_back: Vec<f64>,
    /// Light from outside.
    pub(super) absorbed_front: Vec<Vec<f64>>,
    /// Light from inside.
    pub(super) absorbed_back: Vec<Vec<f64>>,
}

/// n × n shares: entry (o, i) of what comes along i and goes on along o.
#[derive(Clone)]
struct Shares(usize, Vec<f64>);

impl Shares {
    fn of(values: &[f64], omega: &[f64]) -> Self {
        let n = omega.len();
        Self(n, values.iter().enumerate().map(|(k, v)| v * omega[k / n]).collect())
    }

    /// Back to 1/sr.
    fn values(&self, omega: &[f64]) -> Vec<f64> {
        self.1.iter().enumerate().map(|(k, v)| v / omega[k / self.0]).collect()
    }

    fn times(&self, other: &Self) -> Self {
        let n = self.0;
        let mut product = vec![0.0; n * n];
        for (row, out) in self.1.chunks(n).zip(product.chunks_mut(n)) {
            for (a, other) in row.iter().zip(other.1.chunks(n)) {
                for (out, b) in out.iter_mut().zip(other) {
                    *out += a * b;
                }
            }
        }
        Self(n, product)
    }

    fn plus(&self, other: &Self) -> Self {
        Self(self.0, self.1.iter().zip(&other.1).map(|(a, b)| a + b).collect())
    }

    /// Σ over o of each column, weighted.
    fn columns(&self, weights: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.0];
        for (row, weight) in self.1.chunks(self.0).zip(weights) {
            for (sum, v) in sums.iter_mut().zip(row) {
                *sum += v * weight;
            }
        }
        sums
    }

    /// (1 − self)⁻¹ · right, by elimination with the largest pivot of each column.
    ///
    /// Errors: argument, where light between layers never comes to rest.
    fn echo(&self, right: &Self) -> Result<Self> {
        let n = self.0;
        let mut left: Vec<Vec<f64>> = (0..n)
            .map(|r| (0..n).map(|c| f64::from(u8::from(r == c)) - self.1[r * n + c]).collect())
            .collect();
        let mut rows: Vec<Vec<f64>> = right.1.chunks(n).map(<[f64]>::to_vec).collect();
        for c in 0..n {
            let size = |r: &usize| left[*r][c].abs();
            let pivot = (c..n).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(c);
            left.swap(c, pivot);
            rows.swap(c, pivot);
            let scale = left[c][c];
            if scale.is_nan() || scale.abs() < 1e-9 {
                let text = "layers: expected less than all light reflected between them";
                return Err(Error::argument(text));
            }
            left[c].iter_mut().chain(rows[c].iter_mut()).for_each(|v| *v /= scale);
            let (own_left, own_right) = (left[c].clone(), rows[c].clone());
            for r in (0..n).filter(|&r| r != c) {
                let factor = left[r][c];
                if factor != 0.0 {
                    left[r].iter_mut().zip(&own_left).for_each(|(v, w)| *v -= factor * w);
                    rows[r].iter_mut().zip(&own_right).for_each(|(v, w)| *v -= factor * w);
                }
            }
        }
        Ok(Self(n, rows.into_iter().flatten().collect()))
    }
}

fn solid_angles(basis: &KlemsBasis) -> Vec<f64> {
    (0..basis.directions()).map(|k| basis.projected_solid_angle(k)).collect()
}

/// What a layer keeps of light from outside and from inside.
fn kept(m: &Matrices, omega: &[f64]) -> [Vec<f64>; 2] {
    let ones = vec![1.0; omega.len()];
    let side = |t: &[f64], r: &[f64]| {
        let scattered = Shares::of(t, omega).plus(&Shares::of(r, omega)).columns(&ones);
        scattered.into_iter().map(|s| (1.0 - s).max(0.0)).collect()
    };
    [
        side(&m.transmission_front, &m.reflection_front),
        side(&m.transmission_back, &m.reflection_back),
    ]
}

impl System {
    /// One layer alone.
    pub(super) fn of(m: &Matrices, basis: &KlemsBasis) -> Self {
        let [front, back] = kept(m, &solid_angles(basis));
        Self {
            transmission: m.transmission_front.clone(),
            reflection_back: m.reflection_back.clone(),
            absorbed_front: vec![front],
            absorbed_back: vec![back],
        }
    }

    /// Two, the outer one first.
    ///
    /// Errors: argument, where light between them never comes to rest.
    pub(super) fn of_two(outer: &Matrices, inner: &Matrices, basis: &KlemsBasis) -> Result<Self> {
        let omega = solid_angles(basis);
        let shares = |values: &[f64]| Shares::of(values, &omega);
        let (out_back, in_front) =
            (shares(&outer.reflection_back), shares(&inner.reflection_front));
        let [outer_front, outer_back] = kept(outer, &omega);
        let [inner_front, inner_back] = kept(inner, &omega);
        let sum =
            |a: Vec<f64>, b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a + b).collect() };
        // Between the layers, light from outside travels inward as `down` and outward as `up`.
        let down = out_back.times(&in_front).echo(&shares(&outer.transmission_front))?;
        let up = in_front.times(&down);
        let transmission = shares(&inner.transmission_front).times(&down);
        let absorbed_front =
            vec![sum(up.columns(&outer_back), &outer_front), down.columns(&inner_front)];
        // Light from inside.
        let up = in_front.times(&out_back).echo(&shares(&inner.transmission_back))?;
        let down = out_back.times(&up);
        let reflection =
            shares(&inner.reflection_back).plus(&shares(&inner.transmission_front).times(&down));
        let absorbed_back =
            vec![up.columns(&outer_back), sum(down.columns(&inner_front), &inner_back)];
        Ok(Self {
            transmission: transmission.values(&omega),
            reflection_back: reflection.values(&omega),
            absorbed_front,
            absorbed_back,
        })
    }

    /// The share that passes, of each incident patch.
    pub(super) fn transmittance(&self, basis: &KlemsBasis) -> Vec<f64> {
        let omega = solid_angles(basis);
        Shares::of(&self.transmission, &omega).columns(&vec![1.0; omega.len()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lambertian both ways: f = share / π.
    fn diffuse(n: usize, t: f64, r: f64) -> Matrices {
        let flat = |share: f64| vec![share / std::f64::consts::PI; n * n];
        Matrices {
            transmission_front: flat(t),
            transmission_back: flat(t),
            reflection_front: flat(r),
            reflection_back: flat(r),
        }
    }

    /// Two diffusers have the closed form t₁ t₂ / (1 − r₁ r₂) of every textbook.
    #[test]
    fn two_diffusers_are_the_geometric_series() {
        let basis = KlemsBasis::quarter();
        let n = basis.directions();
        let (t1, r1, t2, r2) = (0.5, 0.4, 0.3, 0.6);
        let system = System::of_two(&diffuse(n, t1, r1), &diffuse(n, t2, r2), &basis).unwrap();
        let series = 1.0 / (1.0 - r1 * r2);
        let transmitted = t1 * t2 * series;
        let kept = [0.1 + t1 * series * r2 * 0.1, t1 * series * 0.1];
        for (i, t) in system.transmittance(&basis).into_iter().enumerate() {
            assert!((t - transmitted).abs() < 1e-12);
            for (layer, kept) in kept.iter().enumerate() {
                assert!((system.absorbed_front[layer][i] - kept).abs() < 1e-12);
            }
            // Light from inside: what passes, what comes back and what stays is all.
            let omega = solid_angles(&basis);
            let back = Shares::of(&system.reflection_back, &omega).columns(&vec![1.0; n])[i];
            let stays = system.absorbed_back[0][i] + system.absorbed_back[1][i];
            assert!((back + stays + transmitted - 1.0).abs() < 1e-12);
        }
    }

    /// A mirror image of what is behind: directions are kept through clear layers.
    #[test]
    fn clear_layers_keep_directions() {
        let basis = KlemsBasis::quarter();
        let (n, omega) = (basis.directions(), solid_angles(&basis));
        let diagonal = |share: f64| {
            (0..n * n).map(|k| if k / n == k % n { share / omega[k / n] } else { 0.0 }).collect()
        };
        let glass = |t: f64, r: f64| Matrices {
            transmission_front: diagonal(t),
            transmission_back: diagonal(t),
            reflection_front: diagonal(r),
            reflection_back: diagonal(r),
        };
        let system = System::of_two(&glass(0.8, 0.1), &glass(0.7, 0.2), &basis).unwrap();
        let expected = 0.8 * 0.7 / (1.0 - 0.1 * 0.2);
        for k in 0..n * n {
            let want = if k / n == k % n { expected / omega[k / n] } else { 0.0 };
            assert!((system.transmission[k] - want).abs() < 1e-12);
        }
    }
}
