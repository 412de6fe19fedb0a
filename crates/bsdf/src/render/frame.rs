//! Coordinates in which a peak stands still.

use serde::{Deserialize, Serialize};

use super::incidence::Incidence;
use crate::DVec2;

/// The plane that a frame moves in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FrameKind {
    /// Direction cosines less those of the peak.
    Cosines,
    /// The slope of the half vector, of both directions taken on one side: peaks of facets stand still in it, their middle
    /// where light is mirrored, or goes straight through.
    Slopes,
}

/// The plane that the peak of a layer is looked at in, and the law that takes it along with the light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// The plane.
    pub kind: FrameKind,
    /// The peak is at so many times the incident cosines, and what its pose adds: -1 mirrored or straight through, 1
    /// back, 0 where it is. Poses then hardly change from node to node.
    pub factor: f64,
}

/// Where the peak of a layer is at one incident direction, and what makes it round.
///
/// Of [`FrameKind::Slopes`] the centre is not used: it is where light is mirrored, or goes straight through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Direction cosines x and y of its middle, less those that [`Frame::factor`] gives.
    pub centre: [f32; 2],
    /// Symmetric stretch of the plane, xx, xy, yy: about 1 over its width along either axis.
    pub stretch: [f32; 3],
}

impl Pose {
    /// Numbers of a pose.
    pub(crate) const NUMBERS: usize = 5;

    /// About the normal, stretched by `factor`.
    pub fn about_normal(factor: f32) -> Self {
        Self { centre: [0.0; 2], stretch: [factor, 0.0, factor] }
    }

    pub(crate) fn numbers(self) -> [f32; Self::NUMBERS] {
        let ([x, y], [a, b, c]) = (self.centre, self.stretch);
        [x, y, a, b, c]
    }
}

/// Peaks further out than this count as there: beyond, the hemisphere looks too flat.
const FARTHEST: f64 = 0.995;

/// Smallest |cos θo| that is divided by.
const GRAZING: f64 = 1e-9;

/// Largest stretch.
const SHARPEST: f64 = 1e5;

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

/// A frame for one incidence: q = stretch · (p − centre), p the direction cosines; or stretch · slope.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    frame: FrameKind,
    xy: DVec2,
    z: f64,
    centre: DVec2,
    stretch: Symmetric,
}

impl Placed {
    /// The frame for an incidence at which the peak has the pose of these numbers, whatever they are.
    #[inline(always)]
    pub(crate) fn new(frame: Frame, at: &Incidence, [x, y, xx, xy, yy]: [f64; 5]) -> Self {
        let mut stretch = Symmetric { xx, xy, yy };
        let sound = xx > 0.0 && yy > 0.0 && xx + yy < SHARPEST && stretch.det() > 1e-6 * xx * yy;
        if !sound {
            stretch = Symmetric { xx: 1.0, xy: 0.0, yy: 1.0 };
        }
        let mut centre = DVec2::ZERO;
        if frame.kind == FrameKind::Cosines {
            centre = at.xy * frame.factor + DVec2::new(x, y);
            let length = centre.length();
            if !length.is_finite() {
                centre = DVec2::ZERO;
            } else if length > FARTHEST {
                centre *= FARTHEST / length;
            }
        }
        Self { frame: frame.kind, xy: at.xy, z: at.z, centre, stretch }
    }

    /// The place of a scattered direction of these x, y and cosine z ≥ 0.
    pub(crate) fn place(&self, xy: DVec2, z: f64) -> DVec2 {
        self.stretched(self.apart(xy, z))
    }

    /// The same before the plane is stretched.
    #[inline(always)]
    pub(crate) fn apart(&self, xy: DVec2, z: f64) -> DVec2 {
        match self.frame {
            FrameKind::Slopes => (self.xy + xy) * (1.0 / (self.z + z)),
            FrameKind::Cosines => xy - self.centre,
        }
    }

    #[inline(always)]
    pub(crate) fn stretched(&self, v: DVec2) -> DVec2 {
        self.stretch.apply(v)
    }

    #[inline(always)]
    pub(crate) fn unstretched(&self, q: DVec2) -> DVec2 {
        self.stretch.inverse().apply(q)
    }

    /// x and y of the scattered direction at a place; on the rim where that is beyond it.
    pub(crate) fn direction(&self, q: DVec2) -> DVec2 {
        self.direction_at(self.unstretched(q))
    }

    /// The same of a place before the plane is stretched.
    #[inline(always)]
    pub(crate) fn direction_at(&self, v: DVec2) -> DVec2 {
        let xy = match self.frame {
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
    pub(crate) fn area(&self, xy: DVec2, z: f64) -> f64 {
        let (area, per) = self.area_over(xy, z);
        area / per
    }

    /// The same as numerator and denominator.
    #[inline(always)]
    pub(crate) fn area_over(&self, xy: DVec2, z: f64) -> (f64, f64) {
        match self.frame {
            FrameKind::Cosines => (self.stretch.det(), 1.0),
            FrameKind::Slopes => {
                // dω_o = 4 (wi·h) dω_h, and dω_h = h_z³ d(slope); the half vector before it is normalised is as long as
                // twice wi·h.
                let squared = (2.0 + 2.0 * (self.xy.dot(xy) + self.z * z)).max(1e-12);
                let both = self.z + z;
                (self.stretch.det() * squared, 2.0 * z.max(GRAZING) * (both * both * both))
            }
        }
    }

    /// How many times `v`, before the plane is stretched, it is from the peak to the horizon along it.
    #[inline(always)]
    pub(crate) fn reach(&self, v: DVec2) -> f64 {
        // |v|² t² − 2 b t − c = 0.
        let (b, c) = match self.frame {
            FrameKind::Cosines => {
                (-v.dot(self.centre), (1.0 - self.centre.length_squared()).max(1e-6))
            }
            FrameKind::Slopes => (v.dot(self.xy) / self.z, 1.0),
        };
        let squared = v.length_squared();
        let root = (b * b + squared * c).sqrt();
        let (over, under) = if b >= 0.0 { (b + root, squared) } else { (c, root - b) };
        over / under
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DVec3;
    use crate::render::chart::{Chart, Fold};

    fn frames() -> Vec<(Frame, [f64; 5])> {
        let of = |kind, factor| Frame { kind, factor };
        vec![
            (of(FrameKind::Slopes, 0.0), [0.0, 0.0, 15.0, 4.0, 9.0]),
            (of(FrameKind::Cosines, -1.0), [0.0, 0.0, 1.5, 0.4, 0.9]),
            (of(FrameKind::Cosines, 0.0), [0.4, -0.6, 15.0, 4.0, 9.0]),
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
                let placed = Placed::new(frame.0, &chart.incidence(wi), frame.1);
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
                let placed = Placed::new(frame.0, &chart.incidence(wi), frame.1);
                for k in 0..16 {
                    let e = DVec2::from_angle(f64::from(k) * 0.4);
                    let reach = placed.reach(placed.unstretched(e));
                    let rim = placed.place(placed.direction(e * reach), 0.0);
                    assert!((placed.direction(e * reach).length() - 1.0).abs() < 1e-6);
                    assert!((rim - e * reach).length() < 1e-5 * reach.max(1.0), "{frame:?} {wi}");
                }
            }
        }
    }

    #[test]
    fn poses_of_damaged_files_count_as_plain_ones() {
        let chart = Chart::new(Fold::None, 3, 1.0).unwrap();
        let at = chart.incidence(DVec3::Z);
        for pose in [[f64::NAN; 5], [f64::INFINITY; 5], [2.0, 0.0, 1.0, 1.0, 1.0], [-3.0; 5]] {
            let frame = Frame { kind: FrameKind::Cosines, factor: 0.0 };
            let placed = Placed::new(frame, &at, pose);
            let reach = placed.reach(placed.unstretched(DVec2::X));
            assert!(reach > 0.0 && reach < 3.0, "{pose:?}: {reach}");
            assert!(placed.direction(DVec2::X).length() <= 1.0);
        }
    }
}
