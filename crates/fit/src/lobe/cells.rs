//! What the lobes of one incidence are fitted to.

use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::hilbert::cell_to_index;

use super::blocks::{BLOCK, Blocks, FAR};
use super::leaves::Leaf;
use super::observed::Observed;
use bsdfkit_measure::frame::FrameAt;

/// Weight of an unobserved cell, taken as empty, beside an observed one.
const UNSEEN: f32 = 3e-5;
/// Cells across the frame's bounding box that stand for directions below the horizon.
const OUTSIDE_CELLS: usize = 40;
/// Order of the Hilbert curve along which cells are sorted.
const ORDER: u32 = 10;

/// The leaves of one incidence in frame coordinates, as structure of arrays padded to whole blocks.
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
    pub(super) blocks: Blocks,
}

/// A cell of them.
struct Cell {
    q: DVec2,
    f: f64,
    seen: bool,
    disk: f64,
    area: f64,
    density: f64,
}

impl Cells {
    pub(super) fn new(leaves: &[Leaf], frame: &FrameAt) -> Self {
        let mut cells = Vec::with_capacity(leaves.len() + OUTSIDE_CELLS * OUTSIDE_CELLS / 2);
        let (mut lo, mut hi) = (DVec2::splat(f64::MAX), DVec2::splat(f64::MIN));
        for leaf in leaves {
            let u =
                if leaf.u.length_squared() < 0.9999 { leaf.u } else { leaf.u.normalize() * 0.9999 };
            let q = frame.forward(u);
            let seen = leaf.count > 0;
            if seen {
                lo = lo.min(q);
                hi = hi.max(q);
            }
            let density = frame.density(u);
            let (f, area) = (leaf.value.max(0.0), leaf.area / density);
            cells.push(Cell { q, f, seen, disk: leaf.area, area, density });
        }
        // Below the horizon nothing is ever measured; lobes may reach there.
        let margin = (hi - lo) * 0.12;
        let (lo, step) = (lo - margin, (hi - lo + 2.0 * margin) / OUTSIDE_CELLS as f64);
        for i in 0..OUTSIDE_CELLS * OUTSIDE_CELLS {
            let at = DVec2::new((i % OUTSIDE_CELLS) as f64, (i / OUTSIDE_CELLS) as f64);
            let q = lo + (at + DVec2::splat(0.5)) * step;
            if frame.inverse(q).1 < 0.0 {
                let area = step.x * step.y;
                cells.push(Cell { q, f: 0.0, seen: false, disk: 0.0, area, density: 1.0 });
            }
        }
        let across = OUTSIDE_CELLS as f64 * step / f64::from(1u32 << ORDER);
        cells.sort_by_cached_key(|cell| {
            let at = ((cell.q - lo) / across).clamp(DVec2::ZERO, DVec2::splat(1023.0));
            cell_to_index(ORDER, at.x as u32, at.y as u32)
        });
        Self::of(&cells)
    }

    fn of(cells: &[Cell]) -> Self {
        let padded = cells.len().next_multiple_of(BLOCK);
        let all = |of: fn(&Cell) -> f64, padding: f32| {
            let mut all: Vec<f32> = cells.iter().map(|c| of(c) as f32).collect();
            all.resize(padded, padding);
            all
        };
        let (x, y) = (all(|c| c.q.x, FAR), all(|c| c.q.y, FAR));
        Self {
            blocks: Blocks::of(&x, &y),
            x,
            y,
            f: all(|c| c.f, 0.0),
            observed: all(|c| f64::from(u8::from(c.seen)), 0.0),
            disk_area: all(|c| c.disk, 0.0),
            frame_area: all(|c| c.area, 0.0),
            inverse_density: all(|c| 1.0 / c.density, 1.0),
        }
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
