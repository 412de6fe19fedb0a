//! Peaks of one scan that are as narrow as the instrument shows any.

use bsdfkit::{DVec2, DVec3};

use super::footprint::{AROUND, Near};
use super::signature::Signature;
use bsdfkit_measure::Incidence;

/// A peak that the instrument does not resolve.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// Its middle.
    pub(super) wo: DVec3,
}

/// A peak must rise so many times above the surround's light: below, a smooth lobe with noise may do as much.
pub(super) const RISES: f64 = 3.0;
/// It must hold so much of the incident light: a guess, what readings of stray light may amount to.
const LEAST: f64 = 2e-3;
/// What is left unexplained of a peak's readings, as a share of its height. A lobe half as wide again as the aperture
/// leaves a quarter.
const UNEXPLAINED: f64 = 0.12;
/// Points within the half-height radius that make a peak.
const FEWEST: usize = 3;
/// Bright places looked at, and peaks found, of one scan.
const TRIES: usize = 60;
const MOST: usize = 9;
/// Widths of a beam or a core that still count as none, in radii of the signature.
pub(super) const BLURS: [f64; 6] = [0.0, 0.1, 0.2, 0.3, 0.45, 0.6];

/// The peaks of a scan, the brightest first.
pub(super) fn candidates(
    scan: &Incidence,
    channel: usize,
    signatures: &[Signature],
) -> Vec<Candidate> {
    let signature = &signatures[0];
    let (radius, widest) = (signature.radius(), signatures[signatures.len() - 1].footprint());
    let light: Vec<f64> = scan.points(channel).map(|(w, f)| f * w.z.abs()).collect();
    let mut order: Vec<usize> = (0..light.len()).collect();
    order.sort_by(|&a, &b| light[b].total_cmp(&light[a]));
    let mut taken = vec![false; light.len()];
    let mut found: Vec<Candidate> = Vec::new();
    let mut tries = 0;
    for k in order {
        if light[k] < LEAST * signature.at(0.0) || tries == TRIES || found.len() == MOST {
            break;
        }
        if taken[k] {
            continue;
        }
        tries += 1;
        let near = Near::new(scan, scan.wo.at(k), (1.0 + AROUND) * widest);
        let one = candidate(&near, channel, signatures);
        let middle = one.map_or(near.centre, |c| c.wo);
        let gone = if one.is_some() { 1.5 * widest } else { radius };
        let least = gone.cos();
        for (taken, w) in taken.iter_mut().zip(scan.wo.iter()) {
            *taken |= w.dot(middle) >= least;
        }
        found.extend(one);
    }
    found
}

fn candidate(near: &Near<'_>, channel: usize, signatures: &[Signature]) -> Option<Candidate> {
    let radius = signatures[0].radius();
    let outer = signatures[signatures.len() - 1].footprint();
    // Most lobes are refused by this: nothing is fitted.
    let median = |low: f64, high: f64, middle: DVec2| {
        let mut values: Vec<f64> = near
            .by_distance(middle, channel)
            .filter(|(r, _)| (low..=high).contains(r))
            .map(|p| p.1)
            .collect();
        values.sort_by(f64::total_cmp);
        (values.len() > 1).then(|| values[values.len() / 2])
    };
    let around = median(radius + outer, AROUND * outer, DVec2::ZERO)?.max(0.0);
    let here = median(0.0, radius, DVec2::ZERO)?;
    if here < RISES * around {
        return None;
    }
    let mut best: Option<(f64, DVec2, f64, f64)> = None;
    for signature in signatures {
        let (middle, missed, amplitude) = placed(near, channel, signature)?;
        if best.is_none_or(|b| missed < b.0) {
            best = Some((missed, middle, amplitude, signature.footprint()));
        }
    }
    let (missed, middle, amplitude, footprint) = best?;
    let surround = near.surround(middle, footprint, channel)?;
    let height = amplitude * signatures[0].at(0.0);
    let core = near.within(middle, radius).len();
    let sound = missed < UNEXPLAINED
        && core >= FEWEST
        && amplitude > LEAST
        && height > (RISES - 1.0) * surround.at(middle).max(surround.level);
    sound.then(|| Candidate { wo: near.direction(middle) })
}

/// Where the peak stands, what is left unexplained, and its light: the best place of finer and finer grids.
fn placed(near: &Near<'_>, channel: usize, signature: &Signature) -> Option<(DVec2, f64, f64)> {
    let surround = near.surround(DVec2::ZERO, 1.5 * signature.footprint(), channel)?;
    let fit = |middle: DVec2| near.amplitude(middle, signature, &surround, channel);
    let mut best = (DVec2::ZERO, f64::INFINITY, 0.0);
    let mut width = 0.9 * signature.radius();
    for _ in 0..4 {
        let from = best.0;
        for k in 0..49 {
            let at = DVec2::new(f64::from(k / 7) - 3.0, f64::from(k % 7) - 3.0) / 3.0;
            let middle = from + width * at;
            let (amplitude, missed) = fit(middle);
            if amplitude > 0.0 && missed < best.1 {
                best = (middle, missed, amplitude);
            }
        }
        width /= 3.0;
    }
    best.1.is_finite().then_some(best)
}
