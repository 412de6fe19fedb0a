//! What an instrument makes of a beam that nothing widens.

use std::f64::consts::TAU;
use std::path::Path;

use bsdfkit::{DVec3, Error, Result};

use bsdfkit_measure::{Incidence, ReadOptions};

/// How an instrument sees a ray: light per solid angle over the angle from it, of which the integral is 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Signature {
    /// Between neighbouring values, radians.
    step: f64,
    /// 1/sr, from the middle outward; 0 beyond.
    values: Vec<f64>,
    /// Beyond this even a bright peak is lost in its surround, radians.
    edge: f64,
}

/// Values from the middle to the edge.
const VALUES: usize = 200;
/// Apertures that instruments have, degrees across.
const APERTURES: std::ops::RangeInclusive<f64> = 0.01..=10.0;
/// What is left of the peak at the edge of its footprint.
const EDGE: f64 = 0.01;
/// What is left of the peak where it begins to fall.
const LEVEL: f64 = 0.95;
/// Of a scanned beam, light below this share of the peak is stray light.
const STRAY: f64 = 5e-4;
/// How far a Gaussian of blur reaches: of a peak ten thousand times as bright as its surround a thirtieth of that is left.
const TAIL: f64 = 4.5;
/// Points that a scan must have within half its height.
const FEWEST: usize = 5;

impl Signature {
    /// Of a detector that sees a cone of that diameter, lit by a beam that is narrow beside it.
    ///
    /// Errors: argument, outside 0.01 to 10 degrees.
    pub fn of_aperture(degrees: f64) -> Result<Self> {
        if !APERTURES.contains(&degrees) {
            return Err(Error::argument(format!(
                "aperture: expected {} to {} degrees across, found {degrees}",
                APERTURES.start(),
                APERTURES.end()
            )));
        }
        let radius = 0.5 * degrees.to_radians();
        let step = radius / (VALUES as f64 - 0.5);
        Ok(Self { step, values: vec![1.0; VALUES], edge: radius }.normalised())
    }

    /// Of a scan of the empty beam: a measurement file of one incident direction without a specimen.
    ///
    /// Errors: as [`bsdfkit_measure::read`]; format where it holds several incidences, or no peak with at least 5 points
    /// that is narrower than 10 degrees.
    pub fn read(path: &Path) -> Result<Self> {
        let options = ReadOptions { incomplete: true, ..ReadOptions::default() };
        let measured = bsdfkit_measure::read(&[path.to_owned()], &options)?;
        let fault = |text: String| Error::format(text).context(path.display());
        let incidences: usize = measured.iter().map(|m| m.incidences.len()).sum();
        let brightest = |m: &bsdfkit_measure::Measurement| {
            let y = m.colorimetry.luminance_channel();
            m.incidences.iter().flat_map(|i| i.channel(y)).fold(0.0, f64::max)
        };
        let most = measured.iter().max_by(|a, b| brightest(a).total_cmp(&brightest(b)));
        let Some((m, 1)) = most.map(|m| (m, m.incidences.len())) else {
            return Err(fault(format!(
                "signature: expected one incident direction (the empty beam), found {incidences}"
            )));
        };
        Self::of_scan(&m.incidences[0], m.colorimetry.luminance_channel())
            .map_err(|e| e.context(path.display()))
    }

    fn of_scan(scan: &Incidence, channel: usize) -> Result<Self> {
        let light = |(w, f): (DVec3, f64)| (w, f * w.z.abs());
        let points: Vec<(DVec3, f64)> = scan.points(channel).map(light).collect();
        let top = points.iter().map(|p| p.1).fold(0.0, f64::max);
        let high = || points.iter().filter(|p| p.1 > 0.5 * top);
        let centre = high().map(|p| p.0).sum::<DVec3>().normalize_or_zero();
        let half = high().map(|p| p.0.angle_between(centre)).fold(0.0, f64::max);
        let widest = 0.5 * APERTURES.end().to_radians();
        if high().count() < FEWEST || !(half > 0.0 && half < widest) {
            return Err(Error::format(format!(
                "signature: expected a peak narrower than {} degrees with {FEWEST} points or more above half its height, found {} of them within {:.2} degrees",
                APERTURES.end(),
                high().count(),
                half.to_degrees()
            )));
        }
        let mut by_angle: Vec<(f64, f64)> =
            points.iter().map(|(w, y)| (w.angle_between(centre), y.max(0.0))).collect();
        by_angle.sort_by(|a, b| a.0.total_cmp(&b.0));
        let end = by_angle.iter().position(|p| p.0 > 6.0 * half).unwrap_or(by_angle.len());
        let groups: Vec<(f64, f64)> = by_angle[..end]
            .chunks(FEWEST)
            .map(|group| {
                let mean = |f: fn(&(f64, f64)) -> f64| {
                    group.iter().map(f).sum::<f64>() / group.len() as f64
                };
                (mean(|p| p.0), mean(|p| p.1))
            })
            .collect();
        let stray = |g: &&(f64, f64)| g.1 < STRAY * top;
        let reach = groups.iter().find(stray).map_or(6.0 * half, |g| g.0);
        let step = reach / VALUES as f64;
        let between = |r: f64| {
            let after = groups.partition_point(|g| g.0 < r);
            match (after.checked_sub(1).map(|k| groups[k]), groups.get(after)) {
                (Some(a), Some(&b)) => a.1 + (b.1 - a.1) * (r - a.0) / (b.0 - a.0).max(1e-12),
                (Some(a), None) => a.1,
                (None, _) => groups[0].1,
            }
        };
        let values = (0..VALUES).map(|k| between(k as f64 * step)).collect();
        Ok(Self { step, values, edge: reach }.normalised())
    }

    /// Light per solid angle at an angle from the ray, 1/sr.
    pub fn at(&self, radians: f64) -> f64 {
        let place = radians / self.step;
        let k = place as usize;
        let value = |k: usize| self.values.get(k).copied().unwrap_or(0.0);
        if k >= self.values.len() {
            return 0.0;
        }
        value(k) + (value(k + 1) - value(k)) * (place - k as f64)
    }

    /// The angle at which half of the height is left, radians: the instrument's resolution.
    pub fn radius(&self) -> f64 {
        self.falls_to(0.5)
    }

    /// The angle up to which it hardly falls, wherever the middle is taken to be within a fifth of that, radians.
    pub(super) fn level(&self) -> f64 {
        0.8 * self.falls_to(LEVEL)
    }

    /// The angle beyond which next to nothing is, radians.
    pub(super) fn footprint(&self) -> f64 {
        self.falls_to(EDGE)
    }

    /// The angle within which all of it is that a surround may be mistaken for, radians.
    pub(super) fn edge(&self) -> f64 {
        self.edge
    }

    fn falls_to(&self, share: f64) -> f64 {
        let top = self.values.iter().copied().fold(0.0, f64::max);
        let last = self.values.iter().rposition(|v| *v >= share * top);
        self.step * (last.unwrap_or(0) as f64 + 0.5)
    }

    /// The same of a ray that is widened to a Gaussian of `sigma` radians.
    pub(super) fn blurred(&self, sigma: f64) -> Self {
        /// Circles of as much light each, and points on them.
        const CIRCLES: usize = 48;
        const POINTS: usize = 24;
        if sigma <= 0.0 {
            return self.clone();
        }
        let reach = self.step * self.values.len() as f64 + 3.5 * sigma;
        let step = reach / VALUES as f64;
        let circle = |k: usize| sigma * (-2.0 * ((k as f64 + 0.5) / CIRCLES as f64).ln()).sqrt();
        let circles: Vec<f64> = (0..CIRCLES).map(circle).collect();
        let turns: Vec<f64> =
            (0..POINTS).map(|k| (TAU * (k as f64 + 0.5) / POINTS as f64).cos()).collect();
        let value = |k: usize| {
            let r = k as f64 * step;
            let on = circles.iter().flat_map(|c| turns.iter().map(move |t| (c, t)));
            let sum: f64 =
                on.map(|(c, t)| self.at((r * r + c * c + 2.0 * r * c * t).max(0.0).sqrt())).sum();
            sum / (CIRCLES * POINTS) as f64
        };
        let edge = self.edge + TAIL * sigma;
        Self { step, values: (0..VALUES).map(value).collect(), edge }.normalised()
    }

    fn normalised(mut self) -> Self {
        // Rings about the middle, small angles.
        let ring = |(k, v): (usize, &f64)| {
            let (inner, outer) = ((k as f64 - 0.5).max(0.0), k as f64 + 0.5);
            let solid_angle = TAU * ((inner * self.step).cos() - (outer * self.step).cos());
            v * solid_angle
        };
        let whole: f64 = self.values.iter().enumerate().map(ring).sum();
        self.values.iter_mut().for_each(|v| *v /= whole);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integral(s: &Signature) -> f64 {
        let h = 1e-5;
        (0..60_000).map(|k| (f64::from(k) + 0.5) * h).map(|r| s.at(r) * TAU * r.sin() * h).sum()
    }

    #[test]
    fn a_signature_is_one_ray() {
        let hat = Signature::of_aperture(1.0).unwrap();
        let solid_angle = TAU * (1.0 - 0.5f64.to_radians().cos());
        assert!((hat.at(0.2f64.to_radians()) * solid_angle - 1.0).abs() < 1e-9);
        assert!((hat.radius().to_degrees() - 0.5).abs() < 5e-3);
        assert_eq!(hat.at(0.51f64.to_radians()), 0.0);
        for sigma in [0.0, 0.1, 0.3] {
            let blurred = hat.blurred(f64::to_radians(sigma));
            assert!((integral(&blurred) - 1.0).abs() < 6e-3, "{sigma}: {}", integral(&blurred));
        }
        // The middle of a Gaussian seen through a disc, in closed form.
        let wide = hat.blurred(0.4f64.to_radians()).at(0.0) * solid_angle;
        assert!((wide - (1.0 - (-0.5 * (0.5f64 / 0.4).powi(2)).exp())).abs() < 0.02, "{wide}");
    }

    #[test]
    fn absurd_apertures() {
        for degrees in [0.0, -1.0, 45.0, f64::NAN, f64::INFINITY] {
            let e = Signature::of_aperture(degrees).unwrap_err();
            assert!(e.to_string().contains("expected 0.01 to 10 degrees"), "{e}");
        }
    }
}
