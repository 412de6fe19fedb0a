//! Expectation–maximisation over the cells of one incidence.

use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::widest::{Loop, widest};

use super::cells::{Cells, LANES};
use super::covariance::Covariance;
use super::exponential::exp;
use super::lobe_set::{Lobe, LobeSet};
use super::observed::Observed;
use super::refine::refine;

/// Unobserved cells are taken to hold this share of the model: 1 would let unseen mass run away,
/// lower values pull lobes inward.
const IMPUTED: f32 = 0.98;
/// Smallest eigenvalue of a covariance as a share of the mean leaf area under the lobe: the
/// scan cannot tell narrower peaks from noise between its lines.
const NYQUIST: f64 = 0.3;

/// One lobe on all cells: out = mass · N(q).
struct Gaussian<'a> {
    cells: &'a Cells,
    lobe: &'a Lobe,
    out: &'a mut [f32],
}

impl Loop for Gaussian<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { cells, lobe, out } = self;
        let inv = lobe.covariance.inverse();
        let (a, b, c) = (-0.5 * inv.xx as f32, -inv.xy as f32, -0.5 * inv.yy as f32);
        let norm = lobe.mass / (std::f64::consts::TAU * lobe.covariance.determinant().sqrt());
        let (mx, my, norm) = (lobe.mean.x as f32, lobe.mean.y as f32, norm as f32);
        for ((o, &x), &y) in out.iter_mut().zip(&cells.x).zip(&cells.y) {
            let (dx, dy) = (x - mx, y - my);
            *o = norm * exp(a * dx * dx + b * dx * dy + c * dy * dy);
        }
    }
}

/// Working memory of the sweeps.
pub(super) struct Sweeps<'a> {
    pub(super) cells: &'a Cells,
    /// f on every cell.
    pub(super) model: Vec<f32>,
    /// Density of every lobe on every cell.
    pub(super) lobe: Vec<Vec<f32>>,
    ratio: Vec<f32>,
}

impl<'a> Sweeps<'a> {
    pub(super) fn new(cells: &'a Cells) -> Self {
        let n = cells.len();
        Self { cells, model: vec![0.0; n], lobe: Vec::new(), ratio: vec![0.0; n] }
    }

    /// f of the model on every cell.
    pub(super) fn evaluate(&mut self, set: &LobeSet) {
        let c = self.cells;
        self.lobe.resize_with(set.lobes.len().max(self.lobe.len()), || vec![0.0; c.len()]);
        self.model.fill(0.0);
        for (lobe, g) in set.lobes.iter().zip(&mut self.lobe) {
            widest(Gaussian { cells: c, lobe, out: g });
            for (m, g) in self.model.iter_mut().zip(g.iter()) {
                *m += g;
            }
        }
        let floor = set.floor as f32;
        for (m, i) in self.model.iter_mut().zip(&c.inverse_density) {
            *m = *m * i + floor;
        }
    }

    /// One sweep; `set` is updated in place.
    fn sweep(&mut self, set: &mut LobeSet) {
        self.evaluate(set);
        let c = self.cells;
        let (mut floor_mass, mut floor_area) = (0.0f64, 0.0f64);
        for k in 0..c.len() {
            let seen = c.f[k] / self.model[k].max(1e-12);
            let a = if c.observed[k] > 0.0 { seen } else { IMPUTED };
            // Responsibilities are masses: area_q · (f/model) · N(q).
            self.ratio[k] = a * c.frame_area[k];
            floor_mass += f64::from(a * c.disk_area[k]);
            floor_area += f64::from(c.disk_area[k]);
        }
        set.floor *= floor_mass / floor_area.max(1e-12);
        for (lobe, g) in set.lobes.iter_mut().zip(&self.lobe) {
            widest(Update { lobe, cells: c, g, ratio: &self.ratio });
        }
        set.lobes.retain(|l| l.mass > 1e-9);
    }

    /// Sweeps, then refines all parameters together; returns the residual.
    pub(super) fn settle(&mut self, set: &mut LobeSet, seen: &mut Observed, sweeps: usize) -> f64 {
        for _ in 0..sweeps {
            self.sweep(set);
        }
        refine(set, seen, &self.narrowest(set), 12);
        self.evaluate(set);
        self.residual()
    }

    /// The least variance that the leaves under each lobe can resolve.
    fn narrowest(&self, set: &LobeSet) -> Vec<f64> {
        let area = &self.cells.frame_area;
        let under = |g: &Vec<f32>| {
            let (mut sum, mut weighted) = (0.0f64, 0.0f64);
            for (g, a) in g.iter().zip(area) {
                sum += f64::from(g * a);
                weighted += f64::from(g * a * a);
            }
            (NYQUIST * weighted / sum.max(1e-30)).max(1e-8)
        };
        self.lobe[..set.lobes.len()].iter().map(under).collect()
    }

    /// |f − model| over the observed leaves, as far as the model there is lobe `i`.
    pub(super) fn misfit(&self, i: usize) -> f64 {
        let (c, lobe) = (self.cells, &self.lobe[i]);
        let at = |k: usize| {
            let share = lobe[k] * c.inverse_density[k] / self.model[k].max(1e-12);
            f64::from(share * (c.f[k] - self.model[k]).abs() * c.disk_area[k])
        };
        (0..c.len()).filter(|&k| c.observed[k] > 0.0).map(at).sum()
    }

    /// Relative L1 residual over the observed leaves.
    fn residual(&self) -> f64 {
        let c = self.cells;
        let (mut error, mut total) = (0.0f64, 0.0f64);
        for k in 0..c.len() {
            if c.observed[k] > 0.0 {
                error += f64::from((c.f[k] - self.model[k]).abs() * c.disk_area[k]);
                total += f64::from(c.f[k] * c.disk_area[k]);
            }
        }
        error / total.max(1e-30)
    }
}

/// New mass, centre and covariance of a lobe from its responsibilities r = N · ratio.
struct Update<'a> {
    lobe: &'a mut Lobe,
    cells: &'a Cells,
    g: &'a [f32],
    ratio: &'a [f32],
}

impl Loop for Update<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { lobe, cells: c, g, ratio } = self;
        // Moments about the old centre: f32 sums then lose nothing on narrow lobes.
        let (ox, oy) = (lobe.mean.x as f32, lobe.mean.y as f32);
        let mut s = [[0.0f32; LANES]; 7];
        let n = c.len();
        for k in (0..n).step_by(LANES) {
            let (g, w) = (&g[k..k + LANES], &ratio[k..k + LANES]);
            let (x, y, a) = (&c.x[k..k + LANES], &c.y[k..k + LANES], &c.frame_area[k..k + LANES]);
            for l in 0..LANES {
                let (r, dx, dy) = (g[l] * w[l], x[l] - ox, y[l] - oy);
                s[0][l] += r;
                s[1][l] += r * dx;
                s[2][l] += r * dy;
                s[3][l] += r * dx * dx;
                s[4][l] += r * dx * dy;
                s[5][l] += r * dy * dy;
                s[6][l] += r * a[l];
            }
        }
        let t = s.map(|lanes| lanes.iter().map(|&v| f64::from(v)).sum::<f64>());
        if t[0].is_nan() || t[0] <= 1e-12 {
            lobe.mass = 0.0;
            return;
        }
        let d = DVec2::new(t[1], t[2]) / t[0];
        lobe.mass = t[0];
        lobe.mean += d;
        let covariance = Covariance {
            xx: t[3] / t[0] - d.x * d.x,
            xy: t[4] / t[0] - d.x * d.y,
            yy: t[5] / t[0] - d.y * d.y,
        };
        lobe.covariance = covariance.floored((NYQUIST * t[6] / t[0]).max(1e-8));
    }
}
