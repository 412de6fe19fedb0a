//! What Zemax' tables answer between their nodes.

use bsdfkit::{DVec3, Side};

use super::{Zemax, frame};
use bsdfkit_represent::dense::{Dense, around, between, mirror_peak};
use bsdfkit_represent::{Peak, Slice, Source};

impl Source for Zemax {
    fn incident(&self) -> Side {
        Side::Front
    }

    fn scattered(&self) -> Side {
        self.side()
    }

    fn isotropic(&self) -> bool {
        self.rotations.len() == 1
    }

    fn channels(&self) -> usize {
        self.channels.len()
    }

    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        // No zero has a sign here: along the normal light comes from azimuth 0.
        let rotation = 180.0 - (wi.y + 0.0).atan2(wi.x + 0.0).to_degrees();
        let theta = wi.truncate().length().atan2(wi.z).to_degrees();
        let mut tables = Vec::new();
        for (r, along_rotation) in around(&self.rotations, rotation, 360.0) {
            for (i, along_incidence) in between(&self.incidences, theta) {
                let weight = along_rotation * along_incidence;
                if weight > 0.0 {
                    tables.push((weight, r, i));
                }
            }
        }
        Box::new(At { zemax: self, wi, frame: frame(wi), tables })
    }
}

impl Dense for Zemax {
    fn incidences(&self) -> usize {
        self.rotations.len() * self.incidences.len()
    }

    fn structure(&self) -> &'static str {
        "Zemax' tables about the specular direction"
    }
}

/// One incident direction.
struct At<'a> {
    zemax: &'a Zemax,
    wi: DVec3,
    frame: [DVec3; 3],
    /// Weight, rotation, incidence.
    tables: Vec<(f64, usize, usize)>,
}

impl At<'_> {
    fn value(&self, wo: DVec3, out: &mut [f32]) {
        let zemax = self.zemax;
        let wo = if zemax.transmitted { DVec3::new(wo.x, wo.y, -wo.z) } else { wo };
        let [z, x, y] = self.frame.map(|axis| axis.dot(wo));
        let radial = x.hypot(y).atan2(z).to_degrees();
        let last = zemax.radials[zemax.radials.len() - 1];
        if self.wi.z <= 0.0 || wo.z <= 0.0 || radial > last {
            return out.fill(0.0);
        }
        let azimuth = y.atan2(x).to_degrees();
        let azimuths = match zemax.mirrored {
            true => between(&zemax.azimuths, azimuth.abs()),
            false => around(&zemax.azimuths, azimuth, 360.0),
        };
        let radials = between(&zemax.radials, radial);
        for (channel, out) in zemax.channels.iter().zip(out) {
            let mut sum = 0.0;
            for (weight, r, i) in &self.tables {
                for (a, along_azimuth) in azimuths {
                    for (d, along_radial) in radials {
                        let value = f64::from(channel[zemax.at(*r, *i, a, d)]);
                        sum += weight * along_azimuth * along_radial * value;
                    }
                }
            }
            *out = sum.max(0.0) as f32;
        }
    }
}

impl Slice for At<'_> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        for (wo, out) in wo.iter().zip(out.chunks_exact_mut(self.zemax.channels.len())) {
            self.value(*wo, out);
        }
    }

    fn peaks(&self, out: &mut Vec<Peak>) {
        let side = self.zemax.side().sign();
        let on_side = |mut peak: Peak| {
            peak.direction.z *= side;
            peak
        };
        if side > 0.0 {
            out.push(mirror_peak(self, self.wi, self.zemax.channels.len()));
        } else {
            let direction = DVec3::new(-self.wi.x, -self.wi.y, self.wi.z);
            out.push(on_side(Peak { direction, radius: self.finest() }));
        }
    }
}

impl At<'_> {
    /// The finest step of radial angles, radians.
    fn finest(&self) -> f64 {
        let steps = self.zemax.radials.windows(2).map(|w| w[1] - w[0]);
        steps.fold(10.0, f64::min).to_radians()
    }
}
