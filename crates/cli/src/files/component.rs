//! What a stored component or a part of an interpolant is, in words and figures.

use bsdfkit::component::name_of_sides;
use bsdfkit::matrix::KlemsMatrix;
use bsdfkit::render::RenderTable;
use bsdfkit::tree::{TensorTree, TreeDistribution};
use bsdfkit::{Component, Side, Specular};
use bsdfkit_fit::interpolant::Part;
use bsdfkit_represent::Source;
use bsdfkit_sphere::direction::from_degrees;
use serde_json::{Value, json};

/// A component's name by its sides.
pub(crate) fn name(incident: Side, scattered: Side) -> String {
    name_of_sides(incident, scattered).to_owned()
}

/// A component's structure as (key, value), in the order to print.
pub(crate) type Facts = Vec<(&'static str, Value)>;

/// What a stored component consists of.
pub(crate) fn stored(component: &Component) -> Facts {
    let distribution = component.distribution();
    let mut facts: Facts =
        vec![("component", name(component.incident, component.scattered).into())];
    if let Some(tree) = distribution.downcast_ref::<TreeDistribution>() {
        let luminance = tree.luminance();
        facts.extend([
            ("structure", format!("tensor tree of rank {}", luminance.rank().dimensions()).into()),
            ("leaves", luminance.leaf_count().into()),
            ("depth", luminance.depth().into()),
            ("largest", leaves(luminance).fold(0.0, f32::max).into()),
        ]);
    } else if let Some(matrix) = distribution.downcast_ref::<KlemsMatrix>() {
        let (incident, scattered) = (matrix.incident(), matrix.scattered());
        let largest = matrix.values().iter().fold(0.0f32, |a, &b| a.max(b));
        facts.extend([
            ("structure", "matrix".into()),
            ("incident_basis", incident.name().into()),
            ("scattered_basis", scattered.name().into()),
            ("incident_directions", incident.directions().into()),
            ("scattered_directions", scattered.directions().into()),
            ("largest", largest.into()),
        ]);
    }
    if let Some(table) = distribution.downcast_ref::<RenderTable>() {
        facts.extend([
            ("structure", "render form".into()),
            ("nodes", table.chart().nodes().into()),
            ("layers", table.layers().len().into()),
            ("bytes", table.bytes().into()),
        ]);
    }
    if let Some(bands) = distribution.wavelengths() {
        facts.push(("spectrum", bands.to_string().into()));
    }
    facts.extend([
        ("coloured", distribution.is_coloured().into()),
        ("constant_part", component.floor().y.into()),
        ("negligible", component.is_negligible().into()),
        ("smallest_projected_solid_angle", distribution.min_projected_solid_angle().into()),
    ]);
    facts
}

/// What a part of an interpolant consists of.
pub(crate) fn continuous(part: &Part) -> Facts {
    let mut facts: Facts = vec![("component", name(part.incident(), part.scattered()).into())];
    match part {
        Part::Transported(c) => {
            let errors = c.incidences().iter().map(|i| i.fit_error);
            let count = c.incidences().len().max(1) as f64;
            let extent = c.extent();
            facts.extend([
                ("structure", "lobes and transport".into()),
                ("symmetry", c.symmetry().to_string().into()),
                ("motion", serde_json::to_value(c.motion()).unwrap_or_default()),
                ("incidences", c.incidences().len().into()),
                ("points", c.incidences().iter().map(|i| i.points).sum::<usize>().into()),
                ("lobes", c.incidences().iter().map(|i| i.lobes.lobes.len()).sum::<usize>().into()),
                ("fit_error", json!(errors.clone().sum::<f64>() / count)),
                ("largest_fit_error", json!(errors.fold(0.0, f64::max))),
                ("expected_error", c.expected_error.map_or("unknown".into(), Value::from)),
                ("coverage", extent.to_string().into()),
                ("incidence_extrapolated", extent.incidence_extrapolated.into()),
                ("extrapolated", extent.extrapolated.into()),
                ("seen", extent.seen.into()),
            ]);
            if let Some(spectra) = c.spectra() {
                facts.extend([
                    ("spectrum", spectra.bands().to_string().into()),
                    ("spectral_rank", spectra.rank().into()),
                    ("spectral_error", spectra.error().into()),
                    ("seen_as", c.view().map(|view| view.to_string()).into()),
                ]);
            }
        }
        Part::Sir(part) => {
            let sir = &part.sir;
            facts.extend([
                ("structure", "Radiance's lobes and plans".into()),
                ("isotropic", sir.isotropic().into()),
                ("channels", sir.channels().into()),
                ("incidences", sir.nodes().len().into()),
                ("lobes", sir.nodes().iter().map(|n| n.lobes.len()).sum::<usize>().into()),
                ("plans", sir.migrations().len().into()),
                ("plans_repaired", sir.repaired().into()),
                ("floor", sir.floor().into()),
            ]);
        }
        Part::Dense(part) => {
            facts.extend([
                ("structure", part.function.structure().into()),
                ("isotropic", part.function.isotropic().into()),
                ("channels", part.function.channels().into()),
                ("incidences", part.function.incidences().into()),
            ]);
        }
    }
    facts
}

/// A peak's coefficient at these polar angles in the plane of azimuth 0.
fn coefficients(peak: &Specular) -> [f64; 3] {
    [0.0, 30.0, 60.0].map(|theta| peak.coefficient.at(from_degrees(theta, 0.0)).y)
}

/// What is known of a peak of no width.
pub(crate) fn specular(peak: &Specular) -> Facts {
    let [rings, azimuths] = peak.coefficient.shape();
    vec![
        ("component", name(peak.incident, peak.scattered).into()),
        ("structure", "specular: a peak of no width".into()),
        ("law", peak.name().into()),
        ("matrix", json!(peak.law.linear())),
        ("offset", json!(peak.law.offset().to_array())),
        ("coefficient_0_30_60_degrees", json!(coefficients(peak))),
        ("table", json!([rings, azimuths])),
        ("residual", peak.residual.map_or("unknown".into(), Value::from)),
        ("width_degrees", peak.width_degrees.into()),
    ]
}

/// A peak of no width, in a sentence.
pub(crate) fn peak(peak: &Specular) -> String {
    let [a, b, c] = coefficients(peak);
    let known = match peak.residual {
        Some(r) => format!("between incidences within {:.1} %", 100.0 * r),
        None => "how well is not known".to_owned(),
    };
    let wide = match peak.width_degrees > 0.0 {
        true => format!("; seen {:.2}° wide", peak.width_degrees),
        false => String::new(),
    };
    format!(
        "{}: specular, {}: coefficient {a:.3} at 0°, {b:.3} at 30°, {c:.3} at 60°, {known}{wide}",
        name(peak.incident, peak.scattered),
        peak.name()
    )
}

/// How far the measurement behind a part of an interpolant reaches, in a sentence.
pub(crate) fn coverage(part: &Part) -> Option<String> {
    match part {
        Part::Transported(c) => {
            Some(format!("{}: {}", name(part.incident(), part.scattered()), c.extent()))
        }
        Part::Sir(_) | Part::Dense(_) => None,
    }
}

/// The error to expect between the incidences behind a part of an interpolant, in a sentence.
pub(crate) fn between(part: &Part) -> Option<String> {
    let Part::Transported(c) = part else { return None };
    let (place, error) = (name(c.incident(), c.scattered()), c.expected_error?);
    Some(format!("{place}: between incidences an L1 error of {error:.3} is to be expected"))
}

/// The bands behind a part of an interpolant, in a sentence.
pub(crate) fn spectrum(part: &Part) -> Option<String> {
    let Part::Transported(c) = part else { return None };
    let (place, spectra) = (name(c.incident(), c.scattered()), c.spectra()?);
    let (rank, error) = (spectra.rank(), spectra.error());
    Some(format!(
        "{place}: spectrum of {} by {rank} numbers a point, {error:.4} off (L1)",
        spectra.bands()
    ))
}

/// Values of all leaves.
pub(crate) fn leaves(tree: &TensorTree) -> impl Iterator<Item = f32> {
    let slots = tree.slots().iter().copied().chain([tree.root_slot()]);
    // A slot with its highest bit numbers a branch, see the container's specification.
    slots.filter(|s| s >> 31 == 0).map(f32::from_bits)
}
