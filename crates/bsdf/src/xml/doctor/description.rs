//! `Material`: what WINDOW's engine and Radiance's pkgBSDF cannot do without.

use super::blocks::Outline;
use super::examine::Findings;
use crate::xml::document::Node;

/// Without these a file is refused.
const NEEDED: [&str; 3] = ["Name", "Manufacturer", "Thickness"];
/// Without these there is no U-value.
const THERMAL: [&str; 4] = ["ThermalConductivity", "EmissivityFront", "EmissivityBack", "TIR"];

/// Sides of the pane that pkgBSDF makes.
const SIZES: [&str; 2] = ["Width", "Height"];

pub(super) fn look(outline: &Outline<'_, '_>, found: &mut Findings) {
    let Some(layer) = outline.layer else { return };
    let material = layer.child("Material");
    let place = material.unwrap_or(layer).place();
    let is_zero = |field: &str| {
        let text = material.and_then(|m| m.child(field)).map(Node::text);
        // What is no number is a fault of its own.
        text.is_none_or(|t| t.trim().is_empty() || t.trim().parse::<f64>().is_ok_and(|v| v == 0.0))
    };
    let sizes: Vec<&str> = SIZES.into_iter().filter(|field| is_zero(field)).collect();
    if !sizes.is_empty() {
        let text = format!("0, empty or missing: {}", sizes.join(", "));
        found.add("no-size", place.clone(), text);
    }
    // No program that wants more reads trees.
    if !outline.is_matrix() {
        return;
    }
    let is_empty = |field: &'static str| {
        let text = material.and_then(|m| m.child(field)).map(Node::text);
        text.is_none_or(|text| text.trim().is_empty())
    };
    let lacking = |fields: &[&'static str]| {
        fields.iter().copied().filter(|field| is_empty(field)).collect::<Vec<_>>().join(", ")
    };
    for (code, fields) in [("no-description", &NEEDED[..]), ("no-thermal-data", &THERMAL)] {
        let fields = lacking(fields);
        if !fields.is_empty() {
            found.add(code, place.clone(), format!("empty or missing: {fields}"));
        }
    }
    if let Some(thickness) = material.and_then(|m| m.child("Thickness")) {
        let unit = thickness.attribute("unit").unwrap_or_default();
        let known = ["", "Meter", "Millimeter"].iter().any(|u| u.eq_ignore_ascii_case(&unit));
        if !known {
            let text = format!("expected Meter or Millimeter, found {unit}");
            found.add("thickness-unit", thickness.place(), text);
        }
    }
}
