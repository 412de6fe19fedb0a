//! Which symmetry a component has: from its incident azimuths, and from the data where these leave a choice.

use bsdfkit::{DVec2, DVec3, Error, Result};
use bsdfkit_sphere::direction;

use super::agreement::{Disagreement, compare};
use super::seen::{Seen, limit};
use super::{Image, Incidence, Measurement, Mirror, Symmetry, SymmetryKind};

/// Azimuths nearer than this are one, and an incidence nearer to the normal than this has none, degrees. Stages are
/// set to whole degrees; doubled, a fine azimuth scan (2°) would look like one plane.
const SAME_DEGREES: f64 = 1.0;

/// Polar angles nearer than this may be compared: a lobe of 1° moved by it differs by a tenth.
const COMPARABLE_DEGREES: f64 = 0.1;

/// The largest azimuth without an incidence, images counted: with more, the incidences would not surround the normal
/// well (three planes of incidence do, a half plane and its opposite do not).
const LARGEST_GAP_DEGREES: f64 = 120.0;

/// L1 beyond noise at which a given symmetry is refused. A guess: real specimens called symmetric reach 0.05, a
/// brushed metal called isotropic 1.
const REFUSED: f64 = 0.3;

/// L1 beyond noise up to which two planes of incidence show the same isotropic specimen. A guess between the same.
const ISOTROPIC: f64 = 0.1;

/// L1 beyond noise that a note tells.
const NOTED: f64 = 0.03;

/// Pairs of distributions compared for one component: each costs about 50 ms at 50,000 points.
const MOST_PAIRS: usize = 6;

/// Settles the symmetry of `component`.
///
/// Errors: class argument where `given` contradicts the data or needs more incidences; class format where the data
/// cover less than any symmetry needs, unless `incomplete` is allowed (then it is a note).
pub(super) fn settle(
    component: &mut Measurement,
    given: Option<SymmetryKind>,
    incomplete: bool,
) -> Result<()> {
    let channel = component.colorimetry.luminance_channel();
    let evidence = Evidence { incidences: &component.incidences, channel };
    let mut notes = Vec::new();
    let symmetry = match given {
        Some(SymmetryKind::Isotropic) => Symmetry::Isotropic,
        Some(SymmetryKind::Quadrilateral) => Symmetry::Quadrilateral,
        Some(SymmetryKind::Bilateral(Some(mirror))) => Symmetry::Bilateral(mirror),
        Some(SymmetryKind::Bilateral(None)) => Symmetry::Bilateral(evidence.mirror()),
        Some(SymmetryKind::Rotational180) => Symmetry::Rotational180,
        Some(SymmetryKind::None) => Symmetry::None,
        None => evidence.detect(&mut notes),
    };
    if let Some(worst) = evidence.worst(symmetry) {
        if given.is_some() && worst.disagreement.excess() > REFUSED {
            return Err(Error::argument(format!("symmetry {symmetry}: {worst}")));
        }
        if worst.disagreement.excess() > NOTED {
            notes.push(format!("symmetry {symmetry} is approximate: {worst}"));
        }
    }
    let missing = evidence.missing(symmetry);
    match missing {
        Some(reason) if incomplete => notes.push(reason),
        Some(reason) if given.is_some() => return Err(Error::argument(reason)),
        Some(reason) => return Err(Error::format(reason)),
        None => {}
    }
    component.symmetry = symmetry;
    component.notes.extend(notes);
    Ok(())
}

/// What the data say about symmetry.
struct Evidence<'a> {
    incidences: &'a [Incidence],
    channel: usize,
}

/// Two distributions that a symmetry says are the same.
struct Comparison {
    disagreement: Disagreement,
    /// (θ, φ) in degrees.
    a: (f64, f64),
    b: (f64, f64),
}

impl std::fmt::Display for Comparison {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Disagreement { distance, floor } = self.disagreement;
        let ((ta, pa), (tb, pb)) = (self.a, self.b);
        if self.a == self.b {
            write!(
                f,
                "expected the distribution at incidence theta {ta:.1} phi {pa:.1} to be its own image"
            )?;
        } else {
            write!(
                f,
                "expected the distributions at incidence theta {ta:.1} phi {pa:.1} and theta {tb:.1} phi {pb:.1} to be images of each other"
            )?;
        }
        write!(
            f,
            ", found that they differ by {:.1} % of their light, of which noise explains {:.1} %",
            100.0 * distance,
            100.0 * floor
        )
    }
}

impl Evidence<'_> {
    /// The azimuths of the incidences that have one, degrees, ascending.
    fn azimuths(&self) -> Vec<f64> {
        let mut azimuths: Vec<f64> = self
            .incidences
            .iter()
            .filter(|i| has_azimuth(i))
            .map(|i| direction::to_degrees(i.wi).1)
            .collect();
        azimuths.sort_by(f64::total_cmp);
        azimuths
    }

    /// The largest symmetry that the incidences fill, checked against the data where the azimuths alone do not tell.
    fn detect(&self, notes: &mut Vec<String>) -> Symmetry {
        let azimuths = self.azimuths();
        let Some(&first) = azimuths.first() else { return Symmetry::Isotropic };
        let all = |modulus: f64| azimuths.iter().all(|a| off(a - first, modulus) < SAME_DEGREES);
        if all(360.0) {
            return Symmetry::Isotropic;
        }
        if all(90.0) {
            match self.worst_pair(Symmetry::Isotropic) {
                Some(pair) if pair.disagreement.excess() <= ISOTROPIC => {
                    notes.push("the planes of incidence agree: isotropic".to_owned());
                    return Symmetry::Isotropic;
                }
                None if all(180.0) => {
                    notes.push(
                        "one plane of incidence on both sides of the normal: taken as isotropic"
                            .to_owned(),
                    );
                    return Symmetry::Isotropic;
                }
                _ => {}
            }
        }
        let covered = self.covered(&azimuths);
        let Some(refuted) = self.worst(covered).filter(|c| c.disagreement.excess() > REFUSED)
        else {
            return covered;
        };
        // a specimen mounted askew mirrors nothing, yet may be the same all around
        let around = self.worst_pair(Symmetry::Isotropic);
        let isotropic = around.is_some_and(|pair| pair.disagreement.excess() <= ISOTROPIC);
        let half = matches!(covered, Symmetry::Bilateral(_))
            && self.gap(Symmetry::Rotational180) <= LARGEST_GAP_DEGREES;
        let instead = match (isotropic, half) {
            (true, _) => Symmetry::Isotropic,
            (false, true) => Symmetry::Rotational180,
            (false, false) => return covered,
        };
        notes.push(format!("{instead}, not {covered}: {refuted}"));
        instead
    }

    /// The largest symmetry, isotropy apart, whose domain holds all azimuths.
    fn covered(&self, azimuths: &[f64]) -> Symmetry {
        let within = |from: f64, width: f64| {
            azimuths.iter().all(|a| {
                let past = (a - from).rem_euclid(360.0);
                past <= width + SAME_DEGREES || past >= 360.0 - SAME_DEGREES
            })
        };
        if [0.0, 90.0, 180.0, 270.0].iter().any(|&from| within(from, 90.0)) {
            return Symmetry::Quadrilateral;
        }
        if within(0.0, 180.0) || within(180.0, 180.0) {
            return Symmetry::Bilateral(Mirror::Y);
        }
        if within(90.0, 180.0) || within(270.0, 180.0) {
            return Symmetry::Bilateral(Mirror::X);
        }
        let full = self.gap(Symmetry::None) <= LARGEST_GAP_DEGREES;
        if !full && self.gap(Symmetry::Rotational180) <= LARGEST_GAP_DEGREES {
            return Symmetry::Rotational180;
        }
        Symmetry::None
    }

    /// The mirror that a bilateral specimen must have: the one that its incidences' half belongs to, else the one that
    /// the data contradict less.
    fn mirror(&self) -> Mirror {
        let gap = |mirror| self.gap(Symmetry::Bilateral(mirror));
        let excess = |mirror| {
            self.worst(Symmetry::Bilateral(mirror)).map_or(0.0, |c| c.disagreement.excess())
        };
        let by_gap = gap(Mirror::X) - gap(Mirror::Y);
        let by_excess = excess(Mirror::X) - excess(Mirror::Y);
        let prefer_x = if by_gap.abs() > SAME_DEGREES { by_gap < 0.0 } else { by_excess < 0.0 };
        if prefer_x { Mirror::X } else { Mirror::Y }
    }

    /// The largest azimuth without an incidence, the images under `symmetry` counted; 0 where it does not matter.
    fn gap(&self, symmetry: Symmetry) -> f64 {
        if symmetry == Symmetry::Isotropic {
            return 0.0;
        }
        let mut azimuths: Vec<f64> = Vec::new();
        for incidence in self.incidences.iter().filter(|i| has_azimuth(i)) {
            azimuths.extend(
                symmetry.images().iter().map(|i| direction::to_degrees(i.apply(incidence.wi)).1),
            );
        }
        azimuths.sort_by(f64::total_cmp);
        let (Some(first), Some(last)) = (azimuths.first(), azimuths.last()) else { return 360.0 };
        let around = first + 360.0 - last;
        azimuths.windows(2).map(|w| w[1] - w[0]).fold(around, f64::max)
    }

    /// Why the incidences do not cover what `symmetry` needs, if they do not.
    fn missing(&self, symmetry: Symmetry) -> Option<String> {
        let count = self.incidences.len();
        if count < 2 {
            let (theta, phi) = direction::to_degrees(self.incidences.first()?.wi);
            return Some(format!(
                "expected at least 2 incident directions, found only theta {theta:.1} phi {phi:.1}"
            ));
        }
        let gap = self.gap(symmetry);
        if gap <= LARGEST_GAP_DEGREES + SAME_DEGREES {
            return None;
        }
        let mut found: Vec<String> = self.azimuths().iter().map(|a| format!("{a:.0}")).collect();
        found.dedup();
        found.truncate(12);
        Some(format!(
            "symmetry {symmetry}: expected incident azimuths no further apart than {LARGEST_GAP_DEGREES} degrees, images counted, found a gap of {gap:.0} (measured: {})",
            found.join(", ")
        ))
    }

    /// The worst contradiction of `symmetry` in the data, between incidences and within one.
    fn worst(&self, symmetry: Symmetry) -> Option<Comparison> {
        let within = self.worst_within(symmetry);
        let pair = self.worst_pair(symmetry);
        pair.into_iter().chain(within).max_by(by_excess)
    }

    /// The worst among pairs of incidences that `symmetry` brings together.
    fn worst_pair(&self, symmetry: Symmetry) -> Option<Comparison> {
        if symmetry == Symmetry::None {
            return None;
        }
        let near = COMPARABLE_DEGREES.to_radians().cos();
        let folded: Vec<_> = self.incidences.iter().map(|i| symmetry.fold(i.wi)).collect();
        // each with the first that it meets: as many pairs as incidences, never their square
        let mut pairs = Vec::new();
        for (b, (at, to_b)) in folded.iter().enumerate() {
            let met = |a: &usize| at.dot(folded[*a].0) >= near && has_azimuth(&self.incidences[*a]);
            if let Some(a) = (0..b).find(met) {
                pairs.push((a, b, after(folded[a].1, to_b.inverse())));
            }
        }
        let step = pairs.len().div_ceil(MOST_PAIRS).max(1);
        pairs
            .iter()
            .step_by(step)
            .filter_map(|&(a, b, image)| self.comparison(a, b, image))
            .max_by(by_excess)
    }

    /// The worst among incidences that an image under `symmetry` leaves where they are.
    fn worst_within(&self, symmetry: Symmetry) -> Option<Comparison> {
        let near = COMPARABLE_DEGREES.to_radians().cos();
        /// A rotation that no mirror or half turn imitates.
        const ANY_TURN: f64 = 1.234;
        let turn = Image::rotation_to(DVec3::new(ANY_TURN.cos(), ANY_TURN.sin(), 0.0));
        let images = match symmetry {
            Symmetry::Isotropic => &[turn][..],
            other => &other.images()[1..],
        };
        let mut fixed = Vec::new();
        for (index, incidence) in self.incidences.iter().enumerate() {
            for &image in images {
                let kept = image.apply(incidence.wi).dot(incidence.wi) >= near;
                // planes that are turned meet themselves nowhere but at the normal
                if kept && (symmetry != Symmetry::Isotropic || shows_most(incidence)) {
                    fixed.push((index, image));
                }
            }
        }
        let step = fixed.len().div_ceil(MOST_PAIRS).max(1);
        fixed
            .iter()
            .step_by(step)
            .filter_map(|&(index, image)| self.comparison(index, index, image))
            .max_by(by_excess)
    }

    fn comparison(&self, a: usize, b: usize, image: Image) -> Option<Comparison> {
        let (a, b) = (&self.incidences[a], &self.incidences[b]);
        let disagreement = compare(a, b, image, self.channel)?;
        let place = direction::to_degrees;
        Some(Comparison { disagreement, a: place(a.wi), b: place(b.wi) })
    }
}

fn by_excess(a: &Comparison, b: &Comparison) -> std::cmp::Ordering {
    a.disagreement.excess().total_cmp(&b.disagreement.excess())
}

/// `first`, then `second`.
fn after(first: Image, second: Image) -> Image {
    let through = |axis: DVec2| second.apply(first.apply(axis.extend(0.0))).truncate();
    Image { x: through(DVec2::X), y: through(DVec2::Y) }
}

/// Whether points lie over most of the hemisphere that they reach.
fn shows_most(incidence: &Incidence) -> bool {
    let limit = limit(&incidence.wo);
    Seen::of(incidence).share(limit) > 0.5 * limit * limit
}

/// Whether the incidence is far enough from the normal to have an azimuth.
fn has_azimuth(incidence: &Incidence) -> bool {
    incidence.wi.truncate().length() >= SAME_DEGREES.to_radians().sin()
}

/// How far `angle` is from a multiple of `modulus`.
fn off(angle: f64, modulus: f64) -> f64 {
    let rest = angle.rem_euclid(modulus);
    rest.min(modulus - rest)
}
