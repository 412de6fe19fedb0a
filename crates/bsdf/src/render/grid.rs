//! The directions at which a layer's tables are filled.

use super::chart::{Chart, Fold};
use super::frame::{Frame, Placed, Pose};
use super::polar::{distance, scale, unit};
use super::shape::Shape;
use crate::{DVec2, DVec3};

/// The coordinates of a layer for one incident direction, unfolded: as its node has them.
#[derive(Clone, Copy, Debug)]
pub struct View {
    placed: Placed,
    span: f64,
}

/// A scattered direction on the front, and what it stands for.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Where.
    pub wo: DVec3,
    /// Projected solid angle per unit of (a, v), or of the cell, sr.
    pub size: f64,
}

fn lifted(xy: DVec2) -> DVec3 {
    xy.extend((1.0 - xy.length_squared()).max(0.0).sqrt())
}

/// Part of the way to the horizon beyond which values are those there.
const RIM: f64 = 0.9999;

impl View {
    /// The coordinates about a peak of this pose for the incident direction `wi`.
    pub fn new(chart: &Chart, frame: Frame, wi: DVec3, pose: &Pose) -> Self {
        let at = chart.incidence(wi);
        let span = if chart.fold() == Fold::IsotropicMirrored { 2.0 } else { 4.0 };
        Self { placed: Placed::new(frame, &at, pose.numbers().map(f64::from)), span }
    }

    /// The square of the distance of a direction from the peak's middle, in direction cosines.
    pub fn apart(&self, wo: DVec3) -> f64 {
        self.placed.direction(DVec2::ZERO).distance_squared(wo.truncate())
    }

    /// The place of a direction, peak at the origin.
    pub fn place(&self, wo: DVec3) -> DVec2 {
        self.placed.place(wo.truncate(), wo.z.abs())
    }

    fn grid(&self, angles: usize, mut f: impl FnMut(DVec2, f64, f64)) {
        for i in 0..=angles {
            let (e, rate) = unit(i as f64 * self.span / angles as f64);
            f(e, self.placed.reach(self.placed.unstretched(e)), rate);
        }
    }

    /// Where values are wanted, at (angle, radius): angles + 1 by radii + 1, those beyond the horizon at it.
    pub fn values(&self, shape: &Shape, angles: usize, radii: usize) -> Vec<DVec3> {
        let mut all = Vec::with_capacity((angles + 1) * (radii + 1));
        self.grid(angles, |e, reach, _| {
            for k in 0..=radii {
                let distance = shape.distance(k as f64 / radii as f64).min(reach * RIM);
                all.push(lifted(self.placed.direction(e * distance)));
            }
        });
        all
    }

    /// Of each of [`View::values`], whether its place is beyond the horizon.
    pub fn beyond(&self, shape: &Shape, angles: usize, radii: usize) -> Vec<bool> {
        let mut all = Vec::with_capacity((angles + 1) * (radii + 1));
        self.grid(angles, |_, reach, _| {
            let distance = |k: usize| shape.distance(k as f64 / radii as f64);
            all.extend((0..=radii).map(|k| distance(k) > reach * RIM));
        });
        all
    }

    /// Where densities are wanted, at (angle, radius), and the projected solid angle per unit of (a, v) there.
    pub fn densities(&self, shape: &Shape) -> Vec<Place> {
        let radii = shape.drawn_radii;
        let mut all = Vec::with_capacity((shape.drawn_angles + 1) * (radii + 1));
        self.grid(shape.drawn_angles, |e, reach, rate| {
            let whole = scale(reach / shape.core);
            for k in 0..=radii {
                let rho = distance(whole * k as f64 / radii as f64, shape.core);
                let wo = lifted(self.placed.direction(e * rho));
                let plane = rho * (rho + shape.core) * whole * rate;
                all.push(Place { wo, size: plane / self.placed.area(wo.truncate(), wo.z) });
            }
        });
        all
    }

    /// Two places in each of `angles` by `radii / 2` cells over the whole hemisphere, and the projected solid angle of each:
    /// together, Gauss's rule along the radius.
    ///
    /// Where one half mirrors the other, of that half, and twice the size. Cells widen from `core` on as densities' do.
    pub fn cells(&self, angles: usize, radii: usize, core: f64) -> Vec<Place> {
        let mut all = Vec::with_capacity(angles * radii);
        let cells = radii / 2;
        for i in 0..angles {
            let (e, rate) = unit((i as f64 + 0.5) * self.span / angles as f64);
            let whole = scale(self.placed.reach(self.placed.unstretched(e)) / core);
            for k in 0..2 * cells {
                let side = if k % 2 == 0 { -1.0 } else { 1.0 };
                let v = ((k / 2) as f64 + 0.5 + side * 0.5 / 3.0_f64.sqrt()) / cells as f64;
                let rho = distance(whole * v, core);
                let wo = lifted(self.placed.direction(e * rho));
                let cell = 4.0 / (angles * 2 * cells) as f64;
                let plane = rho * (rho + core) * whole * rate * cell;
                all.push(Place { wo, size: plane / self.placed.area(wo.truncate(), wo.z) });
            }
        }
        all
    }
}
