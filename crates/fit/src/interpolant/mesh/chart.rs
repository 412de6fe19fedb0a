//! Incident directions laid out in the plane, where weights between incidences are linear.

use bsdfkit::{DVec2, DVec3, Side};
use bsdfkit_sphere::concentric::disk_to_hemisphere;
use serde::{Deserialize, Serialize};

/// A layout of the front hemisphere that keeps azimuths. Triangles of the Delaunay mesh are
/// straight-edged in either.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Chart {
    /// (x, y): mirror, refracted, diffracted and retro-reflected directions are affine in it, so lobes that
    /// travel stay on their tracks.
    #[default]
    Disk,
    /// (x, y)/(z + [`DEPTH`]): seen from beneath the surface. Near grazing, where scattering changes most, it
    /// is as the tangent, in which that is nearly linear; and edges from azimuth to azimuth hardly
    /// dip toward the normal (from 75 to 74.4 degrees between azimuths 30 apart, in the disk to 68.9).
    Beneath,
    /// (profile angle, share × angle along the grooves): what is drawn out along a line answers to the profile angle first, so
    /// incidences that share it are neighbours, however far apart along the grooves.
    Profile {
        /// Azimuth of the grooves, radians.
        azimuth: f64,
        /// How far apart incidences along the grooves are, in proportion.
        share: f64,
    },
}

/// A guess, about the tangent of 0.95 of the angle: with tangents of 0.8 to 0.99 of it, prototypes on nine
/// materials erred by up to two fifths more or a fifth less; in the disk by up to three times as much. Other
/// depths were not tried.
const DEPTH: f64 = 0.1;

/// A plane so much smaller than the sphere is flat.
const FLAT: f64 = 0.1;

impl Chart {
    /// The place of an incident direction (front hemisphere).
    pub fn place(self, wi: DVec3) -> DVec2 {
        match self {
            Self::Disk => wi.truncate(),
            Self::Beneath => wi.truncate() / (wi.z.max(0.0) + DEPTH),
            Self::Profile { azimuth, share } => {
                let along = DVec2::from_angle(azimuth);
                let (s, across) = (wi.truncate().dot(along), -wi.truncate().dot(along.perp()));
                let q = DVec2::new(across.atan2(wi.z.max(1e-9)), share * s.clamp(-1.0, 1.0).asin());
                q.y * along - q.x * along.perp()
            }
        }
    }

    /// How far apart two incident directions are: as errors of interpolation see it.
    pub fn distance(self, a: DVec3, b: DVec3) -> f64 {
        match self {
            Self::Disk => a.distance(b),
            _ => self.place(a).distance(self.place(b)),
        }
    }

    /// A direction in whose neighbourhood a Delaunay mesh is to be looked for: those of the sphere, but where the chart
    /// has neighbours of its own, the chart seen from far away.
    pub(crate) fn lifted(self, wi: DVec3) -> DVec3 {
        match self {
            Self::Disk | Self::Beneath => wi,
            Self::Profile { .. } => (FLAT * self.place(wi)).extend(1.0).normalize(),
        }
    }

    /// The incident direction of a place; beyond the horizon, the horizon.
    pub fn direction(self, p: DVec2) -> DVec3 {
        match self {
            Self::Disk => disk_to_hemisphere(p, Side::Front),
            Self::Beneath => {
                // r (z + d) = √(1 − z²), solved for z.
                let r2 = p.length_squared();
                let root = (1.0 + r2 * (1.0 - DEPTH * DEPTH)).sqrt();
                let z = ((root - r2 * DEPTH) / (1.0 + r2)).max(0.0);
                (p * (z + DEPTH)).extend(z).normalize_or(DVec3::Z)
            }
            Self::Profile { azimuth, share } => {
                let along = DVec2::from_angle(azimuth);
                let quarter = std::f64::consts::FRAC_PI_2;
                let a = (-p.dot(along.perp())).clamp(-quarter, quarter);
                let b = (p.dot(along) / share).clamp(-quarter, quarter);
                let (sin, cos) = b.sin_cos();
                (sin * along - cos * a.sin() * along.perp()).extend(cos * a.cos())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_sphere::direction::from_degrees;

    #[test]
    fn direction_undoes_place() {
        for chart in [Chart::Disk, Chart::Beneath, Chart::Profile { azimuth: 0.4, share: 0.3 }] {
            for theta in [0.0, 1e-7, 20.0, 75.0, 89.0, 90.0] {
                for phi in [0.0, 100.0, 250.0] {
                    let wi = from_degrees(theta, phi);
                    let back = chart.direction(chart.place(wi));
                    assert!(back.distance(wi) < 1e-7, "{chart:?} {theta} {phi}: {back}");
                }
            }
        }
        let beyond = Chart::Beneath.direction(DVec2::new(0.0, 50.0));
        assert!(beyond.distance(DVec3::Y) < 1e-9, "{beyond}");
    }
}
