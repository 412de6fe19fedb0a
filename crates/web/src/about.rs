//! What a file holds, for the page to say.

use bsdfkit::component::name_of_sides;
use bsdfkit::matrix::KlemsMatrix;
use bsdfkit::render::RenderTable;
use bsdfkit::tree::TreeDistribution;
use bsdfkit::xml::Warning;
use bsdfkit::{Bsdf, Component, Side, Specular};
use bsdfkit_fit::interpolant::{Continuous, Part};
use bsdfkit_fit::open::Content;
use serde_json::{Value, json};

/// `content` in words, `metadata`, `components` with their `structure` in words, peaks of no width (`specular`), names of
/// `bands`, whether anything is `coloured`, Y of the `lambertian` parts, `warnings`.
pub(crate) fn of(content: Content, bsdf: &Bsdf, warnings: &[Warning]) -> Value {
    let metadata = bsdf.metadata();
    let lambertian = |incident, scattered| bsdf.lambertian().get(incident, scattered).y;
    let (front, back) = (Side::Front, Side::Back);
    json!({
        "content": content.name(),
        "name": metadata.name,
        "manufacturer": metadata.manufacturer,
        "size": [metadata.width, metadata.height, metadata.thickness],
        "properties": metadata.properties,
        "comments": metadata.comments,
        "components": bsdf.components().iter().map(component).collect::<Vec<_>>(),
        "specular": bsdf.specular().iter().map(specular).collect::<Vec<_>>(),
        "bands": bsdf.bands().iter().map(|b| &b.name).collect::<Vec<_>>(),
        "coloured": bsdf.components().iter().any(|c| c.distribution().is_coloured()),
        "lambertian": {
            "front reflection": lambertian(front, front),
            "back reflection": lambertian(back, back),
            "front transmission": lambertian(front, back),
            "back transmission": lambertian(back, front),
        },
        "warnings": warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}

fn component(component: &Component) -> Value {
    json!({
        "name": name_of_sides(component.incident, component.scattered),
        "incident": name(component.incident),
        "scattered": name(component.scattered),
        "structure": structure(component),
    })
}

fn specular(peak: &Specular) -> Value {
    json!({
        "name": name_of_sides(peak.incident, peak.scattered),
        "incident": name(peak.incident),
        "scattered": name(peak.scattered),
        "law": peak.name(),
    })
}

fn name(side: Side) -> &'static str {
    match side {
        Side::Front => "front",
        Side::Back => "back",
    }
}

fn structure(component: &Component) -> String {
    let distribution = component.distribution();
    if let Some(tree) = distribution.downcast_ref::<TreeDistribution>() {
        let tree = tree.luminance();
        let (rank, leaves) = (tree.rank().dimensions(), tree.leaf_count());
        return format!("tensor tree of rank {rank}, {leaves} leaves");
    }
    if let Some(matrix) = distribution.downcast_ref::<KlemsMatrix>() {
        let (incident, scattered) = (matrix.incident(), matrix.scattered());
        let patches = (incident.directions(), scattered.directions());
        return format!("matrix, {} × {} patches ({})", patches.0, patches.1, scattered.name());
    }
    if let Some(table) = distribution.downcast_ref::<RenderTable>() {
        let (nodes, layers) = (table.chart().nodes(), table.layers().len());
        return format!("render form, {nodes} nodes, {layers} layers");
    }
    match distribution.downcast_ref::<Continuous>().map(Continuous::part) {
        Some(part @ Part::Transported(_)) => {
            format!("interpolant of {} measured incidences", part.incidences())
        }
        Some(part @ Part::Sir(_)) => {
            format!("Radiance interpolant of {} incidences", part.incidences())
        }
        Some(Part::Dense(_)) => "function on a grid".to_owned(),
        None => "function".to_owned(),
    }
}
