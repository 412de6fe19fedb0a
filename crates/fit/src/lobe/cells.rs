//! What the lobes of one incidence are fitted to.

use bsdfkit_sphere::DVec2;

use super::leaves::Leaf;
use super::observed::Observed;
use bsdfkit_measure::frame::FrameAt;

/// Weight of an unobserved cell, taken as empty, beside an observed one.
const UNSEEN: f32 = 3e-5;
/// Cells across the frame's bounding box that stand for directions below the horizon.
const OUTSIDE_CELLS: usize = 40;
/// Cells go through the loops so many at once.
pub(super) const LANES: usize = 8;

/// The leaves of one incidence in frame coordinates, as structure of arrays padded to `LANES`.
pub(super) struct Cells {
    pub(super) x: Vec<f32>,
    pub(super) y: Vec<f32>,
    /// f, 1/sr; 0 where unobserved.
    pub(super) f: Vec<f32>,
    pub(super) observed: Vec<f32>,
    /// Area in the disk of directions (0 outside it).
    pub(super) disk_area: Vec<f32>,
    /// Area in frame coordinates.
    pub(super) frame_area: Vec<f32>,
    /// 1 / |du/dq|.
    pub(super) inverse_density: Vec<f32>,
}

impl Cells {
    pub(super) fn new(leaves: &[Leaf], frame: &FrameAt) -> Self {
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

    pub(super) fn len(&self) -> usize {
        self.x.len()
    }

    /// The cells as the refinement takes them. Unobserved ones ask for nothing to be there, gently: without, mass that no
    /// point contradicts grows below the horizon.
    pub(super) fn observed(&self) -> Observed {
        let counts = (0..self.len()).filter(|&k| self.frame_area[k] > 0.0);
        Observed::new(counts.map(|k| {
            let seen = self.observed[k] > 0.0;
            let area = if seen { self.disk_area[k] } else { self.frame_area[k] * UNSEEN };
            [self.x[k], self.y[k], self.f[k], area, self.inverse_density[k]]
        }))
    }
}
