//! `Material` and `Geometry`: the description apart from the numbers.

use super::document::{Document, Node, clip};
use super::kept::{GEOMETRY, MATERIAL, keep};
use super::limits::Limits;
use super::placeholders;
use super::report::{Fault, Report};
use crate::Metadata;

/// Text of an element, trimmed; a fault and empty when longer than the limit.
pub(crate) fn short_text(node: Node<'_, '_>, limits: &Limits, report: &mut Report) -> String {
    let text = node.text();
    let text = text.trim();
    if text.len() > limits.text_bytes {
        let text = format!("expected at most {} bytes, found {}", limits.text_bytes, text.len());
        report.fault(Fault::limit(node.place(), text));
        return String::new();
    }
    text.to_owned()
}

/// Comments outside of data and of what is kept as it was written, but for those that tell of
/// placeholders: a writer makes these anew.
pub(crate) fn comments(
    document: &Document<'_>,
    optical: Node<'_, '_>,
    layer: Node<'_, '_>,
) -> Vec<String> {
    let described = ["Material", "Geometry", "DataDefinition"].map(|name| layer.child(name));
    let parents =
        [document.root(), optical, layer].into_iter().chain(described.into_iter().flatten());
    let parents: Vec<Node<'_, '_>> = parents.collect();
    let comments = document.comments(&parents);
    let own = comments.filter(|c| !c.is_empty() && placeholders::named(c).is_none());
    own.map(str::to_owned).collect()
}

/// The fields of a layer's `Material` that a comment in it calls placeholders.
pub(crate) fn marked<'a>(document: &Document<'a>, layer: Node<'_, 'a>) -> Vec<&'a str> {
    let Some(material) = layer.child("Material") else { return Vec::new() };
    document.comments(&[material]).filter_map(placeholders::named).flatten().collect()
}

/// Reads `Material`: names, sizes in metres, everything else as properties; of a `marked` field
/// that still has the placeholder's value nothing.
pub(crate) fn read_material(
    material: Node<'_, '_>,
    marked: &[&str],
    limits: &Limits,
    metadata: &mut Metadata,
    report: &mut Report,
) {
    let known = |field: &str| {
        let own = material.child(field).filter(|_| !marked.contains(&field));
        own.and_then(|child| child.text().trim().parse().ok())
    };
    for child in material.children() {
        match child.name() {
            field
                if marked.contains(&field)
                    && child.text().trim() == placeholders::placeholder(field, known)
                    && child.attribute("unit").is_none_or(|u| u.eq_ignore_ascii_case("Meter")) => {}
            "Name" => metadata.name = short_text(child, limits, report),
            "Manufacturer" => metadata.manufacturer = short_text(child, limits, report),
            "Width" => metadata.width = length(child, limits, report),
            "Height" => metadata.height = length(child, limits, report),
            "Thickness" => metadata.thickness = length(child, limits, report),
            _ if child.is_plain() => {
                let key = child.name().to_owned();
                metadata.properties.push((key, short_text(child, limits, report)));
            }
            _ => keep(metadata, MATERIAL, child.verbatim()),
        }
    }
}

/// Reads `Geometry`: MGF text in metres; other descriptions are kept as they are.
pub(crate) fn read_geometry(geometry: Node<'_, '_>, metadata: &mut Metadata, report: &mut Report) {
    if let Some(format) = geometry.attribute("format")
        && !format.eq_ignore_ascii_case("MGF")
    {
        let text = format!("expected geometry format MGF, found {:?}", clip(&format));
        report.fault(Fault::format(geometry.place(), text));
        return;
    }
    for child in geometry.children() {
        if child.name() != "MGFblock" || metadata.geometry.is_some() {
            keep(metadata, GEOMETRY, child.verbatim());
            continue;
        }
        let Some(factor) = metres_per_unit(child, report) else { continue };
        // Line ends are normalised, as XML wants of all text.
        let text = child.text().replace("\r\n", "\n");
        let text = text.trim_start();
        if text.is_empty() {
            continue;
        }
        metadata.geometry = Some(if (factor - 1.0).abs() > 0.01 {
            format!("xf -s {factor:.5}\n{text}\nxf\n")
        } else {
            text.to_owned()
        });
    }
}

/// A length in metres; 0 when the element is empty.
fn length(node: Node<'_, '_>, limits: &Limits, report: &mut Report) -> f64 {
    let Some(factor) = metres_per_unit(node, report) else { return 0.0 };
    let text = short_text(node, limits, report);
    if text.is_empty() {
        return 0.0;
    }
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => value * factor,
        _ => {
            let text = format!("expected a length of at least 0, found {:?}", clip(&text));
            report.fault(Fault::format(node.place(), text));
            0.0
        }
    }
}

fn metres_per_unit(node: Node<'_, '_>, report: &mut Report) -> Option<f64> {
    let unit = node.attribute("unit").unwrap_or_default();
    match unit.to_ascii_lowercase().as_str() {
        "" | "meter" => Some(1.0),
        "foot" => Some(0.3048),
        "inch" => Some(0.0254),
        "centimeter" => Some(0.01),
        "millimeter" => Some(0.001),
        _ => {
            let text = format!(
                "expected unit Meter, Centimeter, Millimeter, Inch or Foot, found {:?}",
                clip(&unit)
            );
            report.fault(Fault::format(node.place(), text));
            None
        }
    }
}
