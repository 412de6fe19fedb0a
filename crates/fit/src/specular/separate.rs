//! A measurement → its peaks of no width, and the measurement without them.

use bsdfkit::spectrum::{Illuminant, View};
use bsdfkit::specular::{Law, Specular};
use bsdfkit::{DVec2, DVec3, Result, Xyz};
use rayon::prelude::*;

use super::agreement::{Scanned, Search};
use super::candidate::{BLURS, RISES, candidates};
use super::course::course;
use super::footprint::{AROUND, Near};
use super::signature::Signature;
use bsdfkit_measure::{Colorimetry, Image, Incidence, Measurement, Symmetry};

/// A peak of no width, and how well it is known.
#[derive(Clone, Debug)]
pub struct FoundPeak {
    /// Law and coefficient.
    pub specular: Specular,
    /// Coefficients at the incidences that show it.
    pub measured: Vec<(DVec3, f64)>,
}

/// What [`separate`] makes of a measurement.
#[derive(Clone, Debug)]
pub struct Separated {
    /// The points below the peaks say what the surround does.
    pub measurement: Measurement,
    /// The peaks, that which most incidences show first.
    pub peaks: Vec<FoundPeak>,
}

/// Points within the half-height radius of a peak that tell its coefficient.
const CORE: usize = 3;
/// Widths tried of what the beam or the core adds, finer than when peaks are looked for: in radii.
const FINE: usize = 25;

/// Separates peaks that are as narrow as the instrument shows any from what is scattered about them.
///
/// A peak counts where its readings have the signature's shape, rise three times above the surround, and stand where one
/// law says at three incidences or more. Its points get what the surround says, its light becomes a coefficient at each
/// incidence: in colour where the measurement is in colour, as seen in daylight where it is a spectrum.
///
/// Accuracy: of virtual measurements without noise the coefficient is within 1 %.
/// Cost: about 10 ms an incidence of 50,000 points.
pub fn separate(m: &Measurement, signature: &Signature) -> Result<Separated> {
    let y = m.colorimetry.luminance_channel();
    let blurs = BLURS.map(|b| signature.blurred(b * signature.radius()));
    let scanned: Vec<Scanned> = m
        .incidences
        .par_iter()
        .map(|i| Scanned { wi: i.wi, candidates: candidates(i, y, &blurs) })
        .collect();
    let radius = signature.radius();
    let shows = |k: usize, wo: DVec3| core_of(&m.incidences[k], wo, radius) >= CORE;
    let search = Search {
        scanned: &scanned,
        radius,
        isotropic: m.symmetry == Symmetry::Isotropic,
        shows: &shows,
    };
    let laws = search.laws();
    let mut separated = Separated { measurement: m.clone(), peaks: Vec::new() };
    let mut taken = vec![Vec::new(); m.incidences.len()];
    for law in laws.into_iter().map(|law| symmetric(law, m.symmetry, radius)) {
        let family = Family { m, law, scanned: &scanned, radius, taken: &taken };
        if let Some((found, footprint)) = family.found(signature)? {
            family.take_out(footprint, &mut separated.measurement);
            let places: Vec<Option<DVec3>> = (0..taken.len()).map(|k| family.place(k)).collect();
            taken.iter_mut().zip(places).for_each(|(taken, place)| taken.extend(place));
            separated.peaks.push(found);
        }
    }
    Ok(separated)
}

/// A law that is nearly its own image under the symmetry, as its own image.
fn symmetric(law: Law, symmetry: Symmetry, radius: f64) -> Law {
    let images = symmetry.images().iter().map(|image| law.seen_through(*image).offset());
    let near: Vec<DVec2> = images.filter(|o| o.distance(law.offset()) < radius).collect();
    let mean = near.iter().sum::<DVec2>() / near.len() as f64;
    law.shifted(mean - law.offset()).unwrap_or(law)
}

/// Points within the half-height radius.
fn core_of(i: &Incidence, wo: DVec3, radius: f64) -> usize {
    let least = radius.cos();
    i.wo.iter().filter(|w| w.dot(wo) >= least).count()
}

/// The peaks that follow one law.
#[derive(Clone, Copy)]
struct Family<'a> {
    m: &'a Measurement,
    law: Law,
    scanned: &'a [Scanned],
    radius: f64,
    /// By incidence: where the peaks of other laws stand.
    taken: &'a [Vec<DVec3>],
}

/// How a law looks through a symmetry of the specimen.
trait SeenThrough {
    fn seen_through(&self, image: Image) -> Self;
}

impl SeenThrough for Law {
    fn seen_through(&self, image: Image) -> Self {
        let of = |v: DVec2| image.apply(v.extend(0.0)).truncate();
        let back = |v: DVec2| image.inverse().apply(v.extend(0.0)).truncate();
        let turned = |v: DVec2| of(self.cosines(back(v)) - self.offset());
        let (x, y) = (turned(DVec2::X), turned(DVec2::Y));
        let offset = of(self.offset());
        // An orthogonal map leaves a law a law.
        Self::affine([[x.x, y.x], [x.y, y.y]], offset.into()).unwrap_or(*self)
    }
}

impl Family<'_> {
    /// Where the peak of incidence `k` stands: where it was seen, if near the law's place.
    fn place(&self, k: usize) -> Option<DVec3> {
        let scanned = &self.scanned[k];
        let said = self.law.scattered(scanned.wi, self.m.scattered)?;
        let seen = scanned.candidates.iter().map(|c| (c.wo.angle_between(said), c.wo));
        let nearest = seen.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|c| c.0 < self.radius);
        Some(nearest.map_or(said, |c| c.1))
    }

    /// The incidences that show the peak, and the points about it.
    fn near(&self, reach: f64) -> Vec<(usize, Near<'_>)> {
        let all = (0..self.m.incidences.len()).filter_map(|k| Some((k, self.place(k)?)));
        let shown = all.filter(|&(k, wo)| {
            // Where two laws cross, all the light is the first one's.
            let free = self.taken[k].iter().all(|t| t.angle_between(wo) > 2.0 * self.radius);
            free && core_of(&self.m.incidences[k], wo, self.radius) >= CORE
        });
        shown.map(|(k, wo)| (k, Near::new(&self.m.incidences[k], wo, reach))).collect()
    }

    /// The coefficient at each incidence that shows the peak.
    fn coefficients(&self, blurred: &Signature, footprint: f64) -> Vec<(DVec3, Xyz)> {
        let m = self.m;
        let seen = match &m.colorimetry {
            Colorimetry::Spectral(bands) => View::Colour(Illuminant::D65).weights(bands).ok(),
            _ => None,
        };
        let coefficient = |(k, near): &(usize, Near<'_>)| {
            let channel = |channel: usize| {
                let surround = near.surround(DVec2::ZERO, footprint, channel)?;
                let light = near.light_of(DVec2::ZERO, blurred, &surround, channel);
                Some(light.clamp(0.0, 1.5))
            };
            let y = channel(m.colorimetry.luminance_channel())?;
            let colour = match (&m.colorimetry, &seen) {
                (Colorimetry::Xyz, _) => Xyz::new(channel(0)?, y, channel(2)?),
                (Colorimetry::Spectral(bands), Some(seen)) => {
                    // After the guide.
                    let bands: Vec<f64> =
                        (1..=bands.count()).map(channel).collect::<Option<_>>()?;
                    let mut xyz = seen.apply(&bands).map(|v| v.max(0.0));
                    let x = xyz.next()?;
                    Xyz::new(x, y, xyz.nth(1)?)
                }
                _ => Xyz::grey(y),
            };
            Some((m.incidences[*k].wi, colour))
        };
        self.near((1.0 + AROUND) * footprint).iter().filter_map(coefficient).collect()
    }

    /// What the signature looks like, blurred by the beam or the core: alike at all incidences.
    fn blurred(&self, signature: &Signature) -> Option<Signature> {
        let y = self.m.colorimetry.luminance_channel();
        let most = BLURS[BLURS.len() - 1] * self.radius;
        let near = self.near((1.0 + AROUND) * signature.blurred(most).edge());
        let missed = |blurred: &Signature| -> f64 {
            let of = |(_, near): &(usize, Near<'_>)| {
                let surround = near.surround(DVec2::ZERO, blurred.edge(), y)?;
                let (amplitude, missed) = near.amplitude(DVec2::ZERO, blurred, &surround, y);
                (amplitude * blurred.at(0.0) > RISES * surround.level).then_some(missed.powi(2))
            };
            near.iter().map(|near| of(near).unwrap_or(1.0)).sum()
        };
        let fine = (0..FINE).map(|k| most * k as f64 / (FINE - 1) as f64);
        let tried: Vec<Signature> = fine.map(|sigma| signature.blurred(sigma)).collect();
        let tried = tried.into_par_iter().map(|s| (missed(&s), s));
        tried.min_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
    }

    /// The peak, and the radius within which it is seen.
    fn found(&self, signature: &Signature) -> Result<Option<(FoundPeak, f64)>> {
        let m = self.m;
        let Some(blurred) = self.blurred(signature) else { return Ok(None) };
        let footprint = blurred.edge() + 0.1 * self.radius;
        let own = self.coefficients(&blurred, footprint);
        let measured = own.iter().map(|&(wi, c)| (wi, c.y)).collect();
        let images = m.symmetry.images();
        let seen = |image: &Image| self.law.seen_through(image.inverse());
        let alike = |image: &Image| seen(image).offset().distance(self.law.offset()) < self.radius;
        let (all, symmetry) = match images.iter().all(alike) {
            true => (own, m.symmetry),
            // At the image of an incidence this law does what its own image does here.
            false => {
                let of = |image: &Image| {
                    let law = seen(image);
                    let there = Family { law, ..*self }.coefficients(&blurred, footprint);
                    let moved = there.into_iter().map(|(wi, c)| (image.apply(wi), c));
                    moved.collect::<Vec<_>>()
                };
                (images.iter().flat_map(of).collect(), Symmetry::None)
            }
        };
        let Some(course) = course(&all, symmetry, m.incident != m.scattered)? else {
            return Ok(None);
        };
        let specular = Specular {
            width_degrees: 2.0 * blurred.radius().to_degrees(),
            residual: course.residual,
            ..Specular::new((m.incident, m.scattered), self.law, course.curve)
        };
        Ok(Some((FoundPeak { specular, measured }, footprint)))
    }

    /// Puts what the surround says in the place of the points of each peak; where there is no surround, they go.
    fn take_out(&self, footprint: f64, from: &mut Measurement) {
        let channels = self.m.colorimetry.channels();
        for k in 0..self.m.incidences.len() {
            let Some(wo) = self.place(k) else { continue };
            // Of the points as they are now: another peak may have gone before.
            let scan = from.incidences[k].clone();
            let near = Near::new(&scan, wo, (1.0 + AROUND) * footprint);
            let inside = near.within(DVec2::ZERO, footprint);
            if inside.is_empty() {
                continue;
            }
            let surrounds: Option<Vec<_>> =
                (0..channels).map(|c| near.surround(DVec2::ZERO, footprint, c)).collect();
            let incidence = &mut from.incidences[k];
            let Some(surrounds) = surrounds else {
                let mut number = 0..;
                let gone = |n: usize| inside.iter().any(|(i, _)| *i == n);
                incidence.wo.retain(|_| !gone(number.next().unwrap_or(0)));
                let values = std::mem::take(&mut incidence.values);
                let rows = values.chunks_exact(channels).enumerate().filter(|(n, _)| !gone(*n));
                incidence.values = rows.flat_map(|(_, row)| row.to_vec()).collect();
                continue;
            };
            for (n, at) in inside {
                let cosine = scan.wo.at(n).z.abs().max(1e-6);
                for (c, surround) in surrounds.iter().enumerate() {
                    let f = surround.at(at).max(0.0) / cosine;
                    incidence.values[n * channels + c] = f as f32;
                }
            }
        }
    }
}
