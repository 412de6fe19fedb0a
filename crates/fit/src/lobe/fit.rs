//! Fitting lobes to one incidence: expectation–maximisation on area-weighted leaves.
//!
//! The update is Richardson–Lucy's in the amplitudes (it minimises the generalised
//! Kullback–Leibler divergence, between least squares and log error) and the usual one of
//! mixtures in centres and shapes. Lobes are added where the residual is largest until the data
//! ask for no more.

use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::widest::{Loop, widest};

use super::covariance::Covariance;
use super::exponential::exp;
use super::leaves::Leaf;
use super::lobe_set::{Lobe, LobeSet};
use super::refine::{Datum, refine};
use crate::interpolant::frame::FrameAt;

/// How far the fit goes.
#[derive(Clone, Copy, Debug)]
pub struct FitOptions {
    /// Most lobes of one incidence.
    pub max_lobes: usize,
    /// Stop adding lobes when the relative L1 residual over the leaves is below this.
    pub target: f64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { max_lobes: 24, target: 0.01 }
    }
}

/// Unobserved cells are taken to hold this share of the model: 1 would let unseen mass run away,
/// lower values pull lobes inward.
const IMPUTED: f32 = 0.98;
/// Up to so many lobes, more are taken as soon as they take 3 % off the residual. Of 6, 8, 10 and 24
/// (any number), 8 left least between incidences: lobes that the data hardly ask for find no partners
/// there, and what they would explain the detail explains as well.
const FEW: usize = 8;
/// Further ones must leave less than this share of the residual: peaks by themselves do.
const EARNED: f64 = 0.8;
/// Smallest eigenvalue of a covariance as a share of the mean leaf area under the lobe: the
/// scan cannot tell narrower peaks from noise between its lines.
const NYQUIST: f64 = 0.3;
/// Weight of an unobserved cell, taken as empty, beside an observed one.
const UNSEEN: f32 = 3e-5;
/// Cells across the frame's bounding box that stand for directions below the horizon.
const OUTSIDE_CELLS: usize = 40;

/// The leaves of one incidence in frame coordinates, as structure of arrays padded to `LANES`.
struct Cells {
    x: Vec<f32>,
    y: Vec<f32>,
    /// f, 1/sr; 0 where unobserved.
    f: Vec<f32>,
    observed: Vec<f32>,
    /// Area in the disk of directions (0 outside it).
    disk_area: Vec<f32>,
    /// Area in frame coordinates.
    frame_area: Vec<f32>,
    /// 1 / |du/dq|.
    inverse_density: Vec<f32>,
}

const LANES: usize = 8;

impl Cells {
    fn new(leaves: &[Leaf], frame: &FrameAt) -> Self {
        let mut c = Cells {
            x: Vec::new(),
            y: Vec::new(),
            f: Vec::new(),
            observed: Vec::new(),
            disk_area: Vec::new(),
            frame_area: Vec::new(),
            inverse_density: Vec::new(),
        };
        let (mut lo, mut hi) = (DVec2::splat(f64::MAX), DVec2::splat(f64::MIN));
        for leaf in leaves {
            let u =
                if leaf.u.length_squared() < 0.9999 { leaf.u } else { leaf.u.normalize() * 0.9999 };
            let q = frame.forward(u);
            if leaf.count > 0 {
                lo = lo.min(q);
                hi = hi.max(q);
            }
            let density = frame.density(u);
            c.push(q, leaf.value.max(0.0), leaf.count > 0, leaf.area, leaf.area / density, density);
        }
        // Below the horizon nothing is ever measured; lobes may reach there.
        let margin = (hi - lo) * 0.12;
        let (lo, step) = (lo - margin, (hi - lo + 2.0 * margin) / OUTSIDE_CELLS as f64);
        for i in 0..OUTSIDE_CELLS * OUTSIDE_CELLS {
            let at = DVec2::new((i % OUTSIDE_CELLS) as f64, (i / OUTSIDE_CELLS) as f64);
            let q = lo + (at + DVec2::splat(0.5)) * step;
            if frame.inverse(q).1 < 0.0 {
                c.push(q, 0.0, false, 0.0, step.x * step.y, 1.0);
            }
        }
        while !c.x.len().is_multiple_of(LANES) {
            c.push(DVec2::splat(1e6), 0.0, false, 0.0, 0.0, 1.0);
        }
        c
    }

    fn push(&mut self, q: DVec2, f: f64, seen: bool, disk: f64, area: f64, density: f64) {
        self.x.push(q.x as f32);
        self.y.push(q.y as f32);
        self.f.push(f as f32);
        self.observed.push(f32::from(u8::from(seen)));
        self.disk_area.push(disk as f32);
        self.frame_area.push(area as f32);
        self.inverse_density.push((1.0 / density) as f32);
    }

    fn len(&self) -> usize {
        self.x.len()
    }

    /// The cells as data of the refinement. Unobserved ones ask for nothing to be there, gently:
    /// without, mass that no point contradicts grows below the horizon.
    fn data(&self) -> Vec<Datum> {
        (0..self.len())
            .filter(|&k| self.frame_area[k] > 0.0)
            .map(|k| {
                let seen = self.observed[k] > 0.0;
                Datum {
                    q: DVec2::new(f64::from(self.x[k]), f64::from(self.y[k])),
                    f: f64::from(self.f[k]),
                    area: f64::from(if seen {
                        self.disk_area[k]
                    } else {
                        self.frame_area[k] * UNSEEN
                    }),
                    inverse_density: f64::from(self.inverse_density[k]),
                }
            })
            .collect()
    }
}

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
struct Sweeps<'a> {
    cells: &'a Cells,
    model: Vec<f32>,
    lobe: Vec<Vec<f32>>,
    ratio: Vec<f32>,
}

impl<'a> Sweeps<'a> {
    fn new(cells: &'a Cells) -> Self {
        let n = cells.len();
        Self { cells, model: vec![0.0; n], lobe: Vec::new(), ratio: vec![0.0; n] }
    }

    /// f of the model on every cell.
    fn evaluate(&mut self, set: &LobeSet) {
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
    fn settle(&mut self, set: &mut LobeSet, data: &[Datum], sweeps: usize) -> f64 {
        for _ in 0..sweeps {
            self.sweep(set);
        }
        refine(set, data, &self.narrowest(set), 12);
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

/// Fits lobes to the leaves of one incidence, in the coordinates of `frame`.
///
/// `start`: lobes to begin with (those of a neighbour, say); without, two are made from the data.
/// Cost: about 1 ns × leaves × lobes × sweeps.
pub fn fit(
    leaves: &[Leaf],
    frame: &FrameAt,
    start: Option<&LobeSet>,
    options: &FitOptions,
) -> LobeSet {
    let cells = Cells::new(leaves, frame);
    let data = cells.data();
    let mut sweeps = Sweeps::new(&cells);
    let mut set = start.cloned().unwrap_or_else(|| initial(leaves, &cells));
    let mut residual = sweeps.settle(&mut set, &data, 15);
    while set.lobes.len() < options.max_lobes && residual > options.target {
        let (most, less) = if set.lobes.len() < FEW { (FEW, 0.97) } else { (usize::MAX, EARNED) };
        let most = most.min(options.max_lobes) - set.lobes.len();
        let room = most.min(1 + set.lobes.len() / 2);
        let mut trial = set.clone();
        if !grow(&mut trial, &sweeps, room) {
            break;
        }
        let now = sweeps.settle(&mut trial, &data, 15);
        if now > less * residual {
            break; // the data ask for no more lobes
        }
        residual = now;
        set = trial;
    }
    set
}

/// Two lobes: a narrow one at the peak and a wide one around the centroid; a low quantile as floor.
fn initial(leaves: &[Leaf], cells: &Cells) -> LobeSet {
    let mut seen: Vec<f64> =
        leaves.iter().filter(|l| l.count > 0).map(|l| l.value.max(0.0)).collect();
    seen.sort_by(f64::total_cmp);
    let floor = seen.get(seen.len() / 50).map_or(0.0, |v| 0.9 * v).max(1e-7);
    let (mut mass, mut mean, mut square) = (0.0, DVec2::ZERO, DVec2::ZERO);
    let (mut peak, mut peak_value) = (DVec2::ZERO, -1.0);
    for k in 0..cells.len() {
        let q = DVec2::new(f64::from(cells.x[k]), f64::from(cells.y[k]));
        let w = (f64::from(cells.f[k]) - floor).max(0.0) * f64::from(cells.disk_area[k]);
        mass += w;
        mean += w * q;
        square += w * q * q;
        if f64::from(cells.f[k]) > peak_value {
            peak_value = f64::from(cells.f[k]);
            peak = q;
        }
    }
    if mass <= 0.0 {
        return LobeSet { floor, lobes: Vec::new() };
    }
    mean /= mass;
    let v = square / mass - mean * mean + DVec2::splat(1e-4);
    let shape = |s: f64| Covariance { xx: v.x * s, xy: 0.0, yy: v.y * s };
    LobeSet {
        floor,
        lobes: vec![
            Lobe { mass: 0.7 * mass, mean: peak, covariance: shape(0.2) },
            Lobe { mass: 0.3 * mass, mean, covariance: shape(2.0) },
        ],
    }
}

/// Adds up to `room` lobes where the model falls short most (Pearson χ²); false if nowhere.
fn grow(set: &mut LobeSet, sweeps: &Sweeps, room: usize) -> bool {
    let c = sweeps.cells;
    let mut chi: Vec<f64> = (0..c.len())
        .map(|k| {
            let d = f64::from(c.f[k] - sweeps.model[k]);
            if c.observed[k] > 0.0 && d > 0.0 {
                f64::from(c.disk_area[k]) * d * d / f64::from(sweeps.model[k]).max(1e-4)
            } else {
                0.0
            }
        })
        .collect();
    let mut added = false;
    for _ in 0..room {
        let Some((k, &worst)) = chi.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)) else {
            break;
        };
        if worst <= 0.0 {
            break;
        }
        let at = DVec2::new(f64::from(c.x[k]), f64::from(c.y[k]));
        let variance = (4.0 * f64::from(c.frame_area[k])).max(2e-5);
        let mut mass = 0.0;
        for j in 0..c.len() {
            let d = DVec2::new(f64::from(c.x[j]), f64::from(c.y[j])) - at;
            if d.length_squared() < 9.0 * variance {
                let excess = f64::from((c.f[j] - sweeps.model[j]) * c.observed[j]);
                mass += excess * f64::from(c.disk_area[j]);
                chi[j] = 0.0;
            }
        }
        let covariance = Covariance::isotropic(variance);
        set.lobes.push(Lobe { mass: (0.5 * mass).max(1e-6), mean: at, covariance });
        added = true;
    }
    added
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpolant::frame::Frame;
    use crate::lobe::leaves::bin;
    use bsdfkit_sphere::DVec3;

    fn points(f: impl Fn(DVec2) -> f64) -> (Vec<DVec3>, Vec<f64>) {
        let mut wo = Vec::new();
        for i in 0..40_000 {
            // R2 low-discrepancy sequence over the square.
            let t = f64::from(i);
            let d = DVec2::new((t * 0.754_877_666_2).fract(), (t * 0.569_840_290_998).fract());
            let d = d * 2.0 - DVec2::ONE;
            if d.length() < 0.99 {
                wo.push(d.extend((1.0 - d.length_squared()).sqrt()));
            }
        }
        let values = wo.iter().map(|w| f(w.truncate())).collect();
        (wo, values)
    }

    #[test]
    fn two_gaussians_and_a_floor_are_found_again() {
        let truth = LobeSet {
            floor: 0.05,
            lobes: vec![
                Lobe {
                    mass: 0.4,
                    mean: DVec2::new(-0.3, 0.1),
                    covariance: Covariance { xx: 0.01, xy: 0.004, yy: 0.02 },
                },
                Lobe {
                    mass: 0.2,
                    mean: DVec2::new(0.4, -0.2),
                    covariance: Covariance::isotropic(0.005),
                },
            ],
        };
        let (wo, values) = points(|u| truth.floor + truth.density(u));
        let frame = Frame::Fixed.at(DVec3::Z);
        let found = fit(&bin(&wo, &values), &frame, None, &FitOptions::default());
        let mass: f64 = found.lobes.iter().map(|l| l.mass).sum();
        assert!((mass - 0.6).abs() < 0.01, "mass {mass}");
        assert!((found.floor - 0.05).abs() < 0.005, "floor {}", found.floor);
        for (w, v) in wo.iter().zip(&values).step_by(97) {
            let m = found.floor + found.density(w.truncate());
            assert!((m - v).abs() < 0.03 * v + 0.02, "{w}: {m} {v}");
        }
    }
}
