//! Coordinates in which a peak stands still.

use serde::{Deserialize, Serialize};

use super::incidence::Incidence;
use crate::{DVec2, Error, Result};

/// The plane that a frame moves in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FrameKind {
    /// Direction cosines less those of the peak, stretched along the peak's azimuth by 1/cos of its polar angle.
    Cosines,
    /// The slope of the half vector, of both directions taken on one side: peaks of facets stand still in it, their middle
    /// where light is mirrored, or goes straight through.
    Slopes,
}

/// Coordinates q of the scattered direction that move with the incident one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// The plane.
    pub kind: FrameKind,
    /// Direction cosines of the peak, of those of the incident direction: rows of a matrix. Of slopes not used.
    pub law: [[f64; 2]; 2],
    /// Beside these, at every incidence.
    pub offset: [f64; 2],
    /// Symmetric stretch of the plane, xx, xy, yy: makes peaks round.
    pub stretch: [f64; 3],
}

/// Peaks further out than this count as there: beyond, the hemisphere looks too flat.
const FARTHEST: f64 = 0.995;

/// Smallest |cos θo| that is divided by.
const GRAZING: f64 = 1e-9;

/// A symmetric matrix.
#[derive(Clone, Copy, Debug)]
struct Symmetric {
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Symmetric {
    #[inline(always)]
    fn apply(self, v: DVec2) -> DVec2 {
        DVec2::new(self.xx * v.x + self.xy * v.y, self.xy * v.x + self.yy * v.y)
    }

    #[inline(always)]
    fn det(self) -> f64 {
        self.xx * self.yy - self.xy * self.xy
    }

    #[inline(always)]
    fn inverse(self) -> Self {
        let d = 1.0 / self.det();
        Self { xx: self.yy * d, xy: -self.xy * d, yy: self.xx * d }
    }
}

/// A frame for one incidence.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    kind: FrameKind,
    xy: DVec2,
    z: f64,
    /// Cosines of the peak.
    centre: DVec2,
    /// q = stretch · turned(p − centre); of slopes the second factor is 1.
    stretch: Symmetric,
    /// Along the peak's azimuth: its direction, and the stretch less 1.
    along: DVec2,
    more: f64,
}

impl Frame {
    /// Whether all numbers make sense.
    ///
    /// Errors: argument.
    pub fn check(&self) -> Result<()> {
        let [xx, xy, yy] = self.stretch;
        let sound = xx > 0.0 && yy > 0.0 && xx * yy - xy * xy > 1e-9 * xx * yy;
        let sound = sound && [xx, yy].iter().all(|s| (1e-6..=1e6).contains(s));
        if !sound {
            let found = self.stretch;
            return Err(Error::argument(format!(
                "stretch: expected a positive symmetric matrix, found {found:?}"
            )));
        }
        if self.law.iter().flatten().chain(&self.offset).any(|c| !(-100.0..=100.0).contains(c)) {
            let found = self.law;
            return Err(Error::argument(format!("law: expected at most 100, found {found:?}")));
        }
        Ok(())
    }

    /// The frame for one incidence; `moved` is added to the law.
    #[inline]
    pub(crate) fn at(&self, at: &Incidence, moved: DVec2) -> Placed {
        let [xx, xy, yy] = self.stretch;
        let stretch = Symmetric { xx, xy, yy };
        let mut placed = Placed {
            kind: self.kind,
            xy: at.xy,
            z: at.z,
            centre: DVec2::ZERO,
            stretch,
            along: DVec2::X,
            more: 0.0,
        };
        if self.kind == FrameKind::Cosines {
            let [x, y] = self.law;
            let centre =
                DVec2::new(x[0] * at.xy.x + x[1] * at.xy.y, y[0] * at.xy.x + y[1] * at.xy.y);
            let centre = centre + moved + DVec2::from_array(self.offset);
            let centre = centre.clamp_length_max(FARTHEST);
            let squared = centre.length_squared();
            placed.centre = centre;
            if squared > 0.0 {
                placed.along = centre / squared.sqrt();
                placed.more = 1.0 / (1.0 - squared).sqrt() - 1.0;
            }
        }
        placed
    }
}

impl Placed {
    /// The place of a scattered direction of these x, y and cosine z ≥ 0.
    #[inline(always)]
    pub(crate) fn place(&self, xy: DVec2, z: f64) -> DVec2 {
        let v = match self.kind {
            FrameKind::Slopes => (self.xy + xy) / (self.z + z),
            FrameKind::Cosines => {
                let v = xy - self.centre;
                v + self.along * (self.more * v.dot(self.along))
            }
        };
        self.stretch.apply(v)
    }

    /// v of q.
    #[inline(always)]
    fn unstretched(&self, q: DVec2) -> DVec2 {
        let v = self.stretch.inverse().apply(q);
        match self.kind {
            FrameKind::Slopes => v,
            FrameKind::Cosines => {
                v - self.along * (v.dot(self.along) * self.more / (1.0 + self.more))
            }
        }
    }

    /// x and y of the scattered direction at a place; on the rim where that is beyond it.
    #[inline]
    pub(crate) fn direction(&self, q: DVec2) -> DVec2 {
        let v = self.unstretched(q);
        let xy = match self.kind {
            FrameKind::Cosines => self.centre + v,
            FrameKind::Slopes => {
                let h = v.extend(1.0);
                let wi = self.xy.extend(self.z);
                (h * (2.0 * wi.dot(h) / h.length_squared()) - wi).truncate()
            }
        };
        xy.clamp_length_max(1.0)
    }

    /// Area of the plane per projected solid angle at a scattered direction.
    #[inline(always)]
    pub(crate) fn area(&self, xy: DVec2, z: f64) -> f64 {
        let plane = match self.kind {
            FrameKind::Cosines => 1.0 + self.more,
            FrameKind::Slopes => {
                // dω_o = 4 (wi·h) dω_h, and dω_h = h_z³ d(slope).
                let dot = self.xy.dot(xy) + self.z * z;
                let squared = (2.0 + 2.0 * dot).max(1e-12);
                let length = squared.sqrt();
                let cosine = (self.z + z) / length;
                let facing = 0.5 * length;
                1.0 / (z.max(GRAZING) * 4.0 * facing * (cosine * cosine * cosine))
            }
        };
        plane * self.stretch.det()
    }

    /// How far it is along the unit vector `e` of the plane from the peak to the horizon.
    #[inline(always)]
    pub(crate) fn reach(&self, e: DVec2) -> f64 {
        let d = self.unstretched(e);
        // |d|² R² − 2 b R − c = 0.
        let (b, c) = match self.kind {
            FrameKind::Cosines => {
                (-d.dot(self.centre), (1.0 - self.centre.length_squared()).max(1e-6))
            }
            FrameKind::Slopes => (d.dot(self.xy) / self.z, 1.0),
        };
        let squared = d.length_squared();
        let root = (b * b + squared * c).sqrt();
        if b >= 0.0 { (b + root) / squared } else { c / (root - b) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DVec3;
    use crate::render::chart::{Chart, Fold};

    fn frames() -> Vec<Frame> {
        let stretch = [1.5, 0.4, 0.9];
        vec![
            Frame { kind: FrameKind::Slopes, law: [[0.0; 2]; 2], offset: [0.0; 2], stretch },
            Frame {
                kind: FrameKind::Cosines,
                law: [[-1.0, 0.0], [0.0, -1.0]],
                offset: [0.0; 2],
                stretch,
            },
            Frame {
                kind: FrameKind::Cosines,
                law: [[0.3, 0.2], [0.1, 0.9]],
                offset: [0.2, -0.1],
                stretch,
            },
        ]
    }

    fn directions() -> impl Iterator<Item = DVec3> {
        (0..60).map(|k| {
            let z = 0.02 + 0.97 * f64::from(k * 37 % 60) / 60.0;
            (DVec2::from_angle(f64::from(k) * 1.1) * (1.0 - z * z).sqrt()).extend(z)
        })
    }

    #[test]
    fn places_are_directions_and_areas_are_theirs() {
        let chart = Chart::new(Fold::None, 3, 1.0).unwrap();
        for frame in frames() {
            for wi in directions() {
                let placed = frame.at(&chart.incidence(wi), DVec2::new(0.01, -0.02));
                for wo in directions() {
                    let xy = wo.truncate();
                    let q = placed.place(xy, wo.z);
                    let back = placed.direction(q);
                    assert!((back - xy).length() < 1e-9, "{frame:?} {wi} {wo}: {back}");
                    // The Jacobian, by differences.
                    let step = 1e-6;
                    let at = |d: DVec2| {
                        let xy = xy + d;
                        placed.place(xy, (1.0 - xy.length_squared()).max(0.0).sqrt())
                    };
                    let dx = (at(DVec2::X * step) - at(DVec2::X * -step)) / (2.0 * step);
                    let dy = (at(DVec2::Y * step) - at(DVec2::Y * -step)) / (2.0 * step);
                    let found = dx.perp_dot(dy).abs();
                    let area = placed.area(xy, wo.z);
                    assert!(
                        (found / area - 1.0).abs() < 1e-3,
                        "{frame:?} {wi} {wo}: {found} {area}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_horizon_is_where_it_is_reached() {
        let chart = Chart::new(Fold::None, 3, 1.0).unwrap();
        for frame in frames() {
            for wi in directions() {
                let placed = frame.at(&chart.incidence(wi), DVec2::ZERO);
                for k in 0..16 {
                    let e = DVec2::from_angle(f64::from(k) * 0.4);
                    let reach = placed.reach(e);
                    let rim = placed.place(placed.direction(e * reach), 0.0);
                    assert!((placed.direction(e * reach).length() - 1.0).abs() < 1e-6);
                    assert!((rim - e * reach).length() < 1e-5 * reach.max(1.0), "{frame:?} {wi}");
                }
            }
        }
    }
}
