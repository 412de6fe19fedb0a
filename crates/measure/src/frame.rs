//! Coordinates in which distributions of neighbouring incidences differ least.
//!
//! Peaks move with the incident direction. A frame takes out one hypothetical motion, so that
//! transport has only the rest to do. No hypothesis is assumed: the frame is chosen for each
//! material by leaving incidences out (see [`super::select`]).

use bsdfkit_sphere::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// A hypothesis on how scattering moves with the incident direction.
///
/// Convention: u = (x, y) of the scattered vector, p = (x, y) of the incident vector, both
/// pointing away from the surface; cᵢ, cₒ their |cosines|. The mirror and the straight-through
/// direction are both u = −p.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// q = u: nothing moves.
    Fixed,
    /// q = u + p: shift invariance in direction cosines (Harvey–Shack).
    Shift,
    /// q = (u + p)/(cᵢ + cₒ): the slope of the half vector (reflecting facets).
    Half,
    /// q = (u + p)/(√(n² − u²) − cᵢ): the slope of a facet that refracts into index n, then
    /// leaves through a flat face.
    Refracted {
        /// Refractive index n.
        index: f64,
    },
    /// Equal-area coordinates about the mirror or straight-through direction, the sphere being
    /// turned by the great circle that brings that direction to the pole.
    Turned,
    /// The same about the direction that light came from.
    Back,
    /// q = (αₒ + s αᵢ, y of u + p) turned to the grooves: what a surface drawn out along a line does. α is the angle in the
    /// plane across the grooves (profile angle), the second coordinate the cosine along them.
    Profile {
        /// Azimuth of the grooves, radians.
        azimuth: f64,
        /// s: 1 where profile angles are mirrored or go straight on, -1 where they turn back, 0 where they stay.
        sense: f64,
    },
}

/// A [`Frame`] at one incident direction.
#[derive(Clone, Copy, Debug)]
pub struct FrameAt {
    frame: Frame,
    /// (x, y) of the incident vector.
    p: DVec2,
    /// Its |cosine|.
    c: f64,
    /// Along the grooves; of frames that turn, from the normal to the mirror direction.
    along: DVec2,
    /// Of grooves: profile angle of the incident vector, and cosine along them. Of frames that turn: |p|, and nothing.
    own: DVec2,
}

/// Below this |cosine| the densities stop falling: keeps values bounded at the horizon.
/// Doubling it changes values past 85 degrees only. A guess.
const SOFT: f64 = 0.04;

fn soft(c: f64) -> f64 {
    (c * c + SOFT * SOFT).sqrt()
}

fn cosine(u: DVec2) -> f64 {
    (1.0 - u.length_squared()).max(0.0).sqrt()
}

impl Frame {
    /// What of it cannot be, what was expected, and what was found.
    pub fn wrong(self) -> Option<(&'static str, &'static str, f64)> {
        match self {
            Self::Refracted { index } if !(1.0 < index && index < 10.0) => {
                Some(("frame.index", "1 to 10", index))
            }
            Self::Profile { azimuth, .. } if !azimuth.is_finite() => {
                Some(("frame.azimuth", "a number", azimuth))
            }
            Self::Profile { sense, .. } if !(-1.0..=1.0).contains(&sense) => {
                Some(("frame.sense", "-1 to 1", sense))
            }
            _ => None,
        }
    }

    /// The frame at incident direction `wi`.
    pub fn at(self, wi: DVec3) -> FrameAt {
        let p = if self == Self::Back { -wi.truncate() } else { wi.truncate() };
        let c = wi.z.abs();
        let (along, own) = match self {
            Self::Turned | Self::Back => {
                let sin = p.length();
                (-p / sin.max(1e-12), DVec2::new(sin, 0.0))
            }
            Self::Profile { azimuth, .. } => {
                let along = DVec2::from_angle(azimuth);
                (along, profile(along, p, c))
            }
            _ => (DVec2::ZERO, DVec2::ZERO),
        };
        FrameAt { frame: self, p, c, along, own }
    }
}

impl FrameAt {
    /// Disk coordinates of a scattered direction → frame coordinates.
    #[inline(always)]
    pub fn forward(&self, u: DVec2) -> DVec2 {
        match self.frame {
            Frame::Fixed => u,
            Frame::Shift => u + self.p,
            Frame::Half => (u + self.p) / (self.c + cosine(u)).max(1e-3),
            Frame::Refracted { index } => {
                (u + self.p) / ((index * index - u.length_squared()).sqrt() - self.c)
            }
            Frame::Turned | Frame::Back => {
                let w = self.turn(DVec3::new(u.x, u.y, cosine(u)), 1.0);
                w.truncate() * (2.0 / (1.0 + w.z).max(1e-6)).sqrt()
            }
            Frame::Profile { sense, .. } => {
                let (along, i) = (self.along, self.own);
                let o = profile(along, u, cosine(u));
                let q = DVec2::new(o.x + sense * i.x, o.y + i.y);
                q.y * along - q.x * along.perp()
            }
        }
    }

    /// Frame coordinates → disk coordinates of the scattered direction, and its cosine, negative
    /// when it falls below the horizon.
    #[inline(always)]
    pub fn inverse(&self, q: DVec2) -> (DVec2, f64) {
        self.inverse_each([q])[0]
    }

    /// [`FrameAt::inverse`] of several places.
    #[inline(always)]
    pub fn inverse_each<const N: usize>(&self, q: [DVec2; N]) -> [(DVec2, f64); N] {
        let (p, c) = (self.p, self.c);
        match self.frame {
            Frame::Fixed => q.map(signed),
            Frame::Shift => q.map(|q| signed(q - p)),
            // The reflection of the incident vector about (q, 1).
            Frame::Half => q.map(|q| {
                let s = 2.0 * (p.dot(q) + c) / (q.length_squared() + 1.0);
                (s * q - p, s - c)
            }),
            // u + p = q (√(n² − u²) − c): solve for s = √(n² − u²) on the line u = q (s − c) − p.
            Frame::Refracted { index } => q.map(|q| {
                let (a, e) = (1.0 + q.length_squared(), q * c + p);
                let b = -q.dot(e);
                let d = e.length_squared() - index * index;
                let s = (-b + (b * b - a * d).max(0.0).sqrt()) / a;
                signed(q * (s - c) - p)
            }),
            Frame::Turned | Frame::Back => q.map(|q| {
                let r2 = q.length_squared().min(4.0);
                let xy = q * (1.0 - 0.25 * r2).max(0.0).sqrt();
                let w = self.turn(DVec3::new(xy.x, xy.y, 1.0 - 0.5 * r2), -1.0);
                (w.truncate(), w.z)
            }),
            Frame::Profile { sense, .. } => {
                let (along, i) = (self.along, self.own);
                q.map(|q| {
                    let (a, s) = (-q.dot(along.perp()) - sense * i.x, q.dot(along) - i.y);
                    let d = 1.0 - s * s;
                    let (sin, cos) = a.sin_cos();
                    let z = if d < 0.0 { -(-d).sqrt() } else { d.sqrt() * cos };
                    let z = if a.abs() > std::f64::consts::PI { -z.abs() } else { z };
                    (s * along - d.max(0.0).sqrt() * sin * along.perp(), z)
                })
            }
        }
    }

    /// |du/dq| at u, softened at the horizon: f · density is what is transported, so that its
    /// integral over q is the directional-hemispherical value.
    #[inline(always)]
    pub fn density(&self, u: DVec2) -> f64 {
        match self.frame {
            Frame::Fixed | Frame::Shift => 1.0,
            Frame::Half => {
                // 4 cₒ (o·h) h_z³ = 2 cₒ (cᵢ + cₒ)³ / |i + o|², with |i + o|² = (u+p)² + (cᵢ+cₒ)²;
                // cₒ is replaced by the mean of both cosines: masking bounds f at the horizon.
                let s = (self.c + cosine(u)).max(1e-3);
                s.powi(4) / ((u + self.p).length_squared() + s * s)
            }
            Frame::Refracted { index } => {
                let s = (index * index - u.length_squared()).sqrt();
                let d = s - self.c;
                // q = (u+p)/d, dd/du = −u/s: det of (I + q uᵀ/s)/d = (1 + q·u/s)/d².
                let q = (u + self.p) / d;
                (d * d / (1.0 + q.dot(u) / s)).abs()
            }
            Frame::Turned | Frame::Back | Frame::Profile { .. } => soft(cosine(u)),
        }
    }

    /// Turns the sphere so that the mirror direction goes to the pole (`sense` 1) or back (−1).
    fn turn(&self, w: DVec3, sense: f64) -> DVec3 {
        let (sin, e) = (self.own.x, self.along);
        if sin < 1e-12 {
            return w;
        }
        // The mirror direction is (−p, c); turn about the horizontal axis perpendicular to p.
        let along = e.dot(w.truncate());
        let (a, z) = (along * self.c - sense * w.z * sin, sense * along * sin + w.z * self.c);
        let xy = w.truncate() + e * (a - along);
        DVec3::new(xy.x, xy.y, z)
    }
}

/// (profile angle, cosine along the grooves) of a direction; grooves run along `along`, across them is −perp.
fn profile(along: DVec2, u: DVec2, z: f64) -> DVec2 {
    DVec2::new((-u.dot(along.perp())).atan2(z), u.dot(along))
}

fn signed(u: DVec2) -> (DVec2, f64) {
    let d = 1.0 - u.length_squared();
    (u, d.abs().sqrt().copysign(d))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_sphere::direction::from_degrees;

    const FRAMES: [Frame; 6] = [
        Frame::Fixed,
        Frame::Shift,
        Frame::Half,
        Frame::Refracted { index: 1.5 },
        Frame::Turned,
        Frame::Profile { azimuth: 0.3, sense: 1.0 },
    ];

    #[test]
    fn inverse_undoes_forward() {
        for frame in FRAMES {
            for ti in [0.0, 20.0, 60.0, 80.0] {
                let at = frame.at(from_degrees(ti, 35.0));
                for to in [0.0, 5.0, 40.0, 70.0, 85.0] {
                    for po in [0.0, 100.0, 215.0] {
                        let u = from_degrees(to, po).truncate();
                        let (v, z) = at.inverse(at.forward(u));
                        assert!((u - v).length() < 1e-9, "{frame:?} {ti} {to} {po}: {u} {v}");
                        assert!((z - cosine(u)).abs() < 1e-7);
                    }
                }
            }
        }
    }

    #[test]
    fn mirror_direction_is_the_origin_of_the_moving_frames() {
        let wi = from_degrees(50.0, 20.0);
        for frame in &FRAMES[1..] {
            assert!(frame.at(wi).forward(-wi.truncate()).length() < 1e-9);
        }
    }

    #[test]
    fn densities_are_jacobians_away_from_the_horizon() {
        let grooves = Frame::Profile { azimuth: 1.2, sense: -1.0 };
        for frame in [Frame::Shift, Frame::Refracted { index: 1.4 }, Frame::Turned, grooves] {
            let at = frame.at(from_degrees(40.0, 10.0));
            let u = from_degrees(25.0, 120.0).truncate();
            let h = 1e-5;
            let dx = (at.forward(u + DVec2::X * h) - at.forward(u - DVec2::X * h)) / (2.0 * h);
            let dy = (at.forward(u + DVec2::Y * h) - at.forward(u - DVec2::Y * h)) / (2.0 * h);
            let jacobian = 1.0 / dx.perp_dot(dy).abs();
            assert!((at.density(u) / jacobian - 1.0).abs() < 2e-3, "{frame:?}");
        }
    }
}
