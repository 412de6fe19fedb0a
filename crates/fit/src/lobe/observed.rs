//! What lobes are refined to, and the sums over it that a step of Gauss–Newton takes.

use bsdfkit_sphere::widest::{Loop, widest};

use super::exponential::exp;
use super::parameters::{PER_LOBE, Parameters};

/// Cells go through the sums so many at once. Lobes that do not reach one of them cost nothing more.
const BLOCK: usize = 128;
/// Sums of so many cells run side by side.
const LANES: usize = 16;
/// Gaussians are cut here (exponent): 1e-8 of the peak.
const CUT: f32 = 18.0;

/// One number of each cell of a block.
type Row = [f32; BLOCK];

/// Cells that count, as structure of arrays padded to [`BLOCK`] with cells of no weight.
#[derive(Clone, Debug, Default)]
pub(super) struct Observed {
    x: Vec<f32>,
    y: Vec<f32>,
    f: Vec<f32>,
    area: Vec<f32>,
    /// 1 / |du/dq|.
    inverse_density: Vec<f32>,
    /// What squares of residuals count; see [`weigh`](Self::weigh).
    weight: Vec<f32>,
}

impl Observed {
    /// Cells given as x, y, f (1/sr), projected solid angle and 1 / |du/dq|.
    pub(super) fn new(cells: impl Iterator<Item = [f32; 5]>) -> Self {
        let mut all = Self::default();
        for cell in cells {
            all.push(cell);
        }
        while !all.x.len().is_multiple_of(BLOCK) {
            all.push([1e6, 1e6, 0.0, 0.0, 1.0]);
        }
        all.weight = vec![0.0; all.x.len()];
        all
    }

    fn push(&mut self, [x, y, f, area, inverse_density]: [f32; 5]) {
        self.x.push(x);
        self.y.push(y);
        self.f.push(f);
        self.area.push(area);
        self.inverse_density.push(inverse_density);
    }

    /// ∫ f over the cells, and their area.
    pub(super) fn integral(&self) -> (f64, f64) {
        let cells = self.f.iter().zip(&self.area);
        cells.fold((0.0, 0.0), |(sum, all), (&f, &area)| {
            (sum + f64::from(f.max(0.0) * area), all + f64::from(area))
        })
    }

    /// Weights squares of residuals as area / (the mean of f and the model + `eps`): between least squares and relative
    /// error.
    pub(super) fn weigh(&mut self, floor: f64, lobes: &[Parameters], eps: f64) {
        let mut model = vec![0.0; self.x.len()];
        widest(Model { seen: self, floor: floor as f32, lobes, out: &mut model });
        for (k, m) in model.iter().enumerate() {
            self.weight[k] = self.area[k] / (0.5 * (self.f[k].max(0.0) + m) + eps as f32);
        }
    }

    /// The weighted sum of squares of f − model.
    pub(super) fn cost(&self, floor: f64, lobes: &[Parameters]) -> f64 {
        let mut cost = 0.0;
        widest(Cost { seen: self, floor: floor as f32, lobes, out: &mut cost });
        cost
    }

    /// Normal equations JᵀWJ (its lower triangle, row-major) and JᵀWr; the last parameter is log floor.
    pub(super) fn normal(&self, floor: f64, lobes: &[Parameters]) -> (Vec<f64>, Vec<f64>) {
        let n = lobes.len() * PER_LOBE + 1;
        let (mut a, mut b) = (vec![0.0; n * n], vec![0.0; n]);
        let mut rows = vec![[0.0; BLOCK]; n];
        let sums = Sums { a: &mut a, b: &mut b, rows: &mut rows };
        widest(Normal { seen: self, floor: floor as f32, lobes, sums });
        (a, b)
    }

    #[inline(always)]
    fn block<'a>(&'a self, all: &'a [f32], k: usize) -> &'a Row {
        all[k..k + BLOCK].try_into().expect("arrays are padded to whole blocks")
    }
}

/// A lobe as the loops take it.
#[derive(Clone, Copy)]
struct Gaussian {
    x: f32,
    y: f32,
    /// 1 / l11, 1 / l22, and l21.
    i11: f32,
    i22: f32,
    l21: f32,
    norm: f32,
}

impl Gaussian {
    fn of(p: &Parameters) -> Self {
        Self {
            x: p.mean.x as f32,
            y: p.mean.y as f32,
            i11: (1.0 / p.l11) as f32,
            i22: (1.0 / p.l22) as f32,
            l21: p.l21 as f32,
            norm: (p.log_mass.exp() / (std::f64::consts::TAU * p.l11 * p.l22)) as f32,
        }
    }

    /// L⁻¹ (q − mean).
    #[inline(always)]
    fn whitened(&self, x: f32, y: f32) -> (f32, f32) {
        let y0 = (x - self.x) * self.i11;
        (y0, ((y - self.y) - self.l21 * y0) * self.i22)
    }

    #[inline(always)]
    fn density(&self, y0: f32, y1: f32) -> f32 {
        let e = 0.5 * (y0 * y0 + y1 * y1);
        if e > CUT { 0.0 } else { self.norm * exp(-e) }
    }
}

/// Adds every lobe's part of f to a block of the model.
#[inline(always)]
fn add_lobes(seen: &Observed, lobes: &[Parameters], k: usize, model: &mut Row) {
    let (x, y) = (seen.block(&seen.x, k), seen.block(&seen.y, k));
    let inverse = seen.block(&seen.inverse_density, k);
    for lobe in lobes {
        let lobe = Gaussian::of(lobe);
        for c in 0..BLOCK {
            let (y0, y1) = lobe.whitened(x[c], y[c]);
            model[c] += lobe.density(y0, y1) * inverse[c];
        }
    }
}

struct Model<'a> {
    seen: &'a Observed,
    floor: f32,
    lobes: &'a [Parameters],
    out: &'a mut [f32],
}

impl Loop for Model<'_> {
    #[inline(always)]
    fn run(self) {
        for (n, out) in self.out.chunks_exact_mut(BLOCK).enumerate() {
            let mut model = [self.floor; BLOCK];
            add_lobes(self.seen, self.lobes, n * BLOCK, &mut model);
            out.copy_from_slice(&model);
        }
    }
}

struct Cost<'a> {
    seen: &'a Observed,
    floor: f32,
    lobes: &'a [Parameters],
    out: &'a mut f64,
}

impl Loop for Cost<'_> {
    #[inline(always)]
    fn run(self) {
        let seen = self.seen;
        for k in (0..seen.x.len()).step_by(BLOCK) {
            let mut model = [self.floor; BLOCK];
            add_lobes(seen, self.lobes, k, &mut model);
            let (f, weight) = (seen.block(&seen.f, k), seen.block(&seen.weight, k));
            let mut weighted = [0.0; BLOCK];
            for c in 0..BLOCK {
                model[c] = f[c] - model[c];
                weighted[c] = weight[c] * model[c];
            }
            *self.out += dot(&model, &weighted);
        }
    }
}

/// Where the normal equations are summed up.
struct Sums<'a> {
    a: &'a mut [f64],
    b: &'a mut [f64],
    /// Derivatives of a block's model by the parameters of the lobes that reach it.
    rows: &'a mut [Row],
}

struct Normal<'a> {
    seen: &'a Observed,
    floor: f32,
    lobes: &'a [Parameters],
    sums: Sums<'a>,
}

impl Loop for Normal<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { seen, floor, lobes, sums: Sums { a, b, rows } } = self;
        let n = b.len();
        let mut live: Vec<usize> = Vec::with_capacity(lobes.len());
        for k in (0..seen.x.len()).step_by(BLOCK) {
            live.clear();
            let mut residual = *seen.block(&seen.f, k);
            residual.iter_mut().for_each(|r| *r -= floor);
            for (l, lobe) in lobes.iter().enumerate() {
                let at = PER_LOBE * live.len();
                let rows = &mut rows[at..at + PER_LOBE];
                if derivatives(seen, lobe, k, rows) {
                    live.push(l);
                    for (r, g) in residual.iter_mut().zip(&rows[0]) {
                        *r -= g;
                    }
                }
            }
            let weight = seen.block(&seen.weight, k);
            for x in 0..live.len() * PER_LOBE {
                let row = live[x / PER_LOBE] * PER_LOBE + x % PER_LOBE;
                let mut weighted = [0.0; BLOCK];
                for c in 0..BLOCK {
                    weighted[c] = weight[c] * rows[x][c];
                }
                b[row] += dot(&weighted, &residual);
                a[(n - 1) * n + row] += f64::from(floor) * sum(&weighted);
                for (y, other) in rows[..=x].iter().enumerate() {
                    let column = live[y / PER_LOBE] * PER_LOBE + y % PER_LOBE;
                    a[row * n + column] += dot(&weighted, other);
                }
            }
            b[n - 1] += f64::from(floor) * dot(weight, &residual);
            a[n * n - 1] += f64::from(floor * floor) * sum(weight);
        }
    }
}

/// A lobe's part of f over a block and its derivatives by log mass, centre and l's; whether there is any.
#[inline(always)]
fn derivatives(seen: &Observed, lobe: &Parameters, k: usize, rows: &mut [Row]) -> bool {
    let (x, y) = (seen.block(&seen.x, k), seen.block(&seen.y, k));
    let inverse = seen.block(&seen.inverse_density, k);
    let g = Gaussian::of(lobe);
    let [r0, r1, r2, r3, r4, r5] = rows else { return false };
    let mut all = [0.0f32; LANES];
    for c in 0..BLOCK {
        let (y0, y1) = g.whitened(x[c], y[c]);
        let f = g.density(y0, y1) * inverse[c];
        // Σ⁻¹ d = L⁻ᵀ y.
        let s1 = y1 * g.i22;
        let s0 = (y0 - g.l21 * s1) * g.i11;
        r0[c] = f;
        r1[c] = f * s0;
        r2[c] = f * s1;
        r3[c] = f * (s0 * y0 * lobe.l11 as f32 - 1.0);
        r4[c] = f * s1 * y0;
        r5[c] = f * (y1 * y1 - 1.0);
        all[c % LANES] += f;
    }
    all.iter().any(|&f| f > 0.0)
}

#[inline(always)]
fn dot(a: &Row, b: &Row) -> f64 {
    let mut lanes = [0.0f32; LANES];
    for c in (0..BLOCK).step_by(LANES) {
        for l in 0..LANES {
            lanes[l] += a[c + l] * b[c + l];
        }
    }
    folded(lanes)
}

#[inline(always)]
fn sum(a: &Row) -> f64 {
    let mut lanes = [0.0f32; LANES];
    for c in (0..BLOCK).step_by(LANES) {
        for l in 0..LANES {
            lanes[l] += a[c + l];
        }
    }
    folded(lanes)
}

#[inline(always)]
fn folded(mut lanes: [f32; LANES]) -> f64 {
    for half in [8, 4, 2, 1] {
        for l in 0..half {
            lanes[l] += lanes[l + half];
        }
    }
    f64::from(lanes[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lobe::{Covariance, Lobe};
    use bsdfkit_sphere::DVec2;

    #[test]
    fn sums_are_those_of_slow_loops() {
        let lobe = |mass, x, y, xx, xy, yy| Lobe {
            mass,
            mean: DVec2::new(x, y),
            covariance: Covariance { xx, xy, yy },
        };
        let lobes = [
            lobe(0.5, 0.2, 0.1, 0.02, 0.005, 0.01),
            lobe(0.3, 0.9, -0.1, 0.02, -0.004, 0.03),
            lobe(0.1, -0.8, -0.7, 0.0004, 0.0, 0.0002),
        ];
        let lobes: Vec<Parameters> = lobes.iter().map(Parameters::of).collect();
        let floor = 0.03;
        // A number of cells that is no multiple of a block.
        let cells: Vec<[f32; 5]> = (0..1000)
            .map(|k| [(k % 32) as f32 * 0.0625 - 1.0, (k / 32) as f32 * 0.0625 - 1.0])
            .map(|[x, y]| [x, y, 0.2 + 0.1 * x, 0.004 + 0.001 * y, 1.0 + 0.3 * x])
            .collect();
        let mut seen = Observed::new(cells.iter().copied());
        seen.weigh(floor, &lobes, 0.01);
        let n = lobes.len() * PER_LOBE + 1;
        let (mut a, mut b, mut cost) = (vec![0.0; n * n], vec![0.0; n], 0.0);
        for &[x, y, f, area, inverse] in &cells {
            let q = DVec2::new(f64::from(x), f64::from(y));
            let (mut j, mut model) = (vec![0.0; n], floor);
            for (l, lobe) in lobes.iter().enumerate() {
                let (g, d) = lobe.density(q);
                model += g * f64::from(inverse);
                for (i, d) in d.iter().enumerate() {
                    j[l * PER_LOBE + i] = d * f64::from(inverse);
                }
            }
            j[n - 1] = floor;
            let weight = f64::from(area) / (0.5 * (f64::from(f) + model) + 0.01);
            let residual = f64::from(f) - model;
            cost += weight * residual * residual;
            for r in 0..n {
                b[r] += weight * j[r] * residual;
                for c in 0..n {
                    a[r * n + c] += weight * j[r] * j[c];
                }
            }
        }
        let own = seen.normal(floor, &lobes);
        assert!((seen.cost(floor, &lobes) / cost - 1.0).abs() < 1e-4);
        for r in 0..n {
            let scale = (a[r * n + r] * cost).sqrt();
            assert!((own.1[r] - b[r]).abs() < 1e-4 * scale, "{r}: {} {}", own.1[r], b[r]);
            for c in 0..=r {
                let scale = (a[r * n + r] * a[c * n + c]).sqrt();
                let (own, slow) = (own.0[r * n + c], a[r * n + c]);
                assert!((own - slow).abs() < 1e-4 * scale, "{r} {c}: {own} {slow}");
            }
        }
    }
}
