//! The light: energy, sides that fit each other, reciprocity, symmetry.

use bsdfkit_sphere::direction::{from_degrees, to_degrees};

use super::examine::Findings;
use crate::component::name_of_sides;
use crate::matrix::KlemsMatrix;
use crate::{Bsdf, Component, Components, DVec3, Lambertian, Metadata, Side, reciprocity};

/// Scattered light beyond the incident that is taken for noise: instruments are calibrated to 1 or 2 %.
pub const ENERGY_TOLERANCE: f64 = 0.02;

/// How far from reciprocal is more than noise. A guess: measured files that went through several programs
/// have up to .16; doubled, only gross faults are told.
const RECIPROCITY_NOISE: f64 = 0.2;

/// Share of the incident light that must differ for it to count: single rays of a simulation do not.
const RECIPROCITY_LIGHT: f64 = 0.01;

/// Share of transmitted light that EnergyPlus may send elsewhere without being told of. A guess.
const ASYMMETRY: f64 = 0.01;

/// Radiance takes a direction that scatters less for diffuse (-st), and drops it below the second.
const WEAK: f64 = 0.15;
const FAINT: f64 = 0.001;

/// Pairs of directions at which reciprocity is looked at: a standard error of 1.6 %.
const PAIRS: u32 = 4096;

/// The largest total of a side, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Total {
    /// The share of light that is scattered.
    pub total: f64,
    /// The incident direction.
    pub wi: DVec3,
}

impl Total {
    /// Whether that is more than arrives, beyond noise.
    pub fn is_too_much(&self) -> bool {
        self.total.is_nan() || self.total > 1.0 + ENERGY_TOLERANCE
    }
}

/// Where light from one side is scattered most; `None` where none is stored of that side.
///
/// Looks at four azimuths of six polar angles, as trees are not symmetric, and at the centre of each patch of a
/// matrix.
pub fn largest_total(bsdf: &Bsdf, side: Side) -> Option<Total> {
    let of_side =
        |c: &&Component| c.incident == side || (c.is_transmission() && c.scattered == side);
    let mut stored = bsdf.components().iter().filter(of_side).peekable();
    stored.peek()?;
    let patches = stored.filter_map(|c| c.distribution().downcast_ref::<KlemsMatrix>()).next();
    let patches = patches.map(|matrix| {
        let basis = matrix.incident();
        (0..basis.directions()).map(|k| basis.centre(k)).collect::<Vec<_>>()
    });
    let around = [0.0, 45.0, 110.0, 250.0];
    let even = (0..=5).flat_map(|k| around.map(|phi| from_degrees(15.0 * f64::from(k) + 2.0, phi)));
    let all = even.chain(patches.into_iter().flatten());
    let totals = all.map(|w| {
        let wi = DVec3::new(w.x, w.y, w.z.abs() * side.sign());
        Total { total: bsdf.directional_hemispherical(wi, Components::ALL), wi }
    });
    totals.max_by(|a, b| a.total.total_cmp(&b.total))
}

pub(super) fn look(bsdf: &Bsdf, found: &mut Findings) {
    for (band, alone) in bands(bsdf) {
        energy(&band, &alone, found);
        strength(&band, &alone, found);
        reciprocal(&band, &alone, found);
        symmetric(&band, &alone, found);
    }
}

/// Each band as a BSDF of its own, with its name and a blank: of the visible one nothing.
pub(super) fn bands(bsdf: &Bsdf) -> Vec<(String, Bsdf)> {
    let further = bsdf.bands().iter().map(|band| {
        let components = band.components.clone();
        let alone = Bsdf::new(Metadata::default(), components, Lambertian::default());
        (format!("{} ", band.name), alone)
    });
    std::iter::once((String::new(), bsdf.clone())).chain(further).collect()
}

fn energy(band: &str, bsdf: &Bsdf, found: &mut Findings) {
    let sides = [Side::Front, Side::Back];
    let mut too_much = Vec::new();
    for side in sides {
        let Some(most) = largest_total(bsdf, side).filter(Total::is_too_much) else { continue };
        let name = if side == Side::Front { "front" } else { "back" };
        let (theta, phi) = to_degrees(most.wi);
        too_much.push((
            format!("{band}{name}"),
            format!(
                "scatters {:.4} of the light at theta {theta:.0} phi {phi:.0}, expected at most 1",
                most.total
            ),
        ));
    }
    let exchanged = || {
        let components = exchanged_reflection(bsdf.components());
        let other = Bsdf::new(Metadata::default(), components, Lambertian::default());
        sides.iter().all(|side| largest_total(&other, *side).is_none_or(|t| !t.is_too_much()))
    };
    let reflections = bsdf.components().iter().filter(|c| !c.is_transmission()).count();
    let mixed = bsdf.components().len() > reflections && reflections > 0;
    let code = match band {
        _ if !too_much.is_empty() && mixed && exchanged() => "exchanged-sides",
        "" => "energy",
        _ => "band-energy",
    };
    for (place, text) in too_much {
        let text = match code {
            "energy" | "band-energy" => text,
            _ => format!("{text}; with the reflections of front and back exchanged no side does"),
        };
        found.add(code, place, text);
    }
}

/// The same with the reflections of both sides exchanged.
pub(super) fn exchanged_reflection(components: &[Component]) -> Vec<Component> {
    let exchanged = components.iter().cloned().map(|mut c| {
        if !c.is_transmission() {
            (c.incident, c.scattered) = (c.incident.opposite(), c.scattered.opposite());
        }
        c
    });
    exchanged.collect()
}

fn strength(band: &str, bsdf: &Bsdf, found: &mut Findings) {
    for c in bsdf.components() {
        let most = c.distribution().max_total(0.0);
        let code = match most {
            m if m <= 0.0 || m >= WEAK => continue,
            m if m < FAINT => "faint",
            _ => "weak",
        };
        let place = format!("{band}{}", name_of_sides(c.incident, c.scattered));
        found.add(code, place, format!("scatters at most {:.2} %", 100.0 * most));
    }
}

fn reciprocal(band: &str, bsdf: &Bsdf, found: &mut Findings) {
    for c in bsdf.components() {
        // Both directions of a transmission differ from each other alike.
        let back = (c.scattered, c.incident);
        let other = bsdf.components().iter().any(|o| (o.incident, o.scattered) == back);
        if c.is_transmission() && (!other || c.incident == Side::Back) {
            continue;
        }
        let defect = reciprocity::defect(bsdf, c.incident, c.scattered, PAIRS);
        let light = c.distribution().max_total(0.0);
        let counts = |d: &f64| *d > RECIPROCITY_NOISE && d * light > RECIPROCITY_LIGHT;
        if let Some(defect) = defect.filter(counts) {
            let place = format!("{band}{}", name_of_sides(c.incident, c.scattered));
            let percent = 100.0 * defect;
            found.add(
                "not-reciprocal",
                place,
                format!("{percent:.0} % of the light differs when it goes back"),
            );
        }
    }
}

fn symmetric(band: &str, bsdf: &Bsdf, found: &mut Findings) {
    for c in bsdf.components().iter().filter(|c| c.is_transmission()) {
        let Some(matrix) = c.distribution().downcast_ref::<KlemsMatrix>() else { continue };
        if let Some(share) = matrix.asymmetry().filter(|share| *share > ASYMMETRY) {
            let place = format!("{band}{}", name_of_sides(c.incident, c.scattered));
            found.add("asymmetric", place, format!("{:.0} % of it differs", 100.0 * share));
        }
    }
}
