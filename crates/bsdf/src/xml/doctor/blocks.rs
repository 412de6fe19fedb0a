//! `WavelengthData`: which bands and directions there are, and what their numbers are.

use std::collections::HashSet;

use super::examine::Findings;
use crate::Side;
use crate::xml::document::{Document, Node, clip};
use crate::xml::orientation;

/// The elements that matter, none of the numbers read.
pub(super) struct Outline<'d, 'a> {
    pub(super) layer: Option<Node<'d, 'a>>,
    /// `IncidentDataStructure`.
    pub(super) structure: Option<Node<'d, 'a>>,
    pub(super) blocks: Vec<OutlineBlock<'d, 'a>>,
}

/// A block of data.
pub(super) struct OutlineBlock<'d, 'a> {
    /// Its `Wavelength`.
    pub(super) wavelength: Node<'d, 'a>,
    pub(super) node: Node<'d, 'a>,
    /// `Wavelength` without blanks around it.
    pub(super) band: String,
    /// (incident, scattered), where the direction is known.
    pub(super) sides: Option<(Side, Side)>,
}

impl<'d, 'a> OutlineBlock<'d, 'a> {
    /// Whether it is the visible band or its colour.
    pub(super) fn is_seen(&self) -> bool {
        is_visible(&self.band) || is_colour(&self.band)
    }

    /// The type of its values, if they are shares of light.
    fn fractional(&self) -> Option<Node<'d, 'a>> {
        let kind = self.node.child("ScatteringDataType")?;
        let text = kind.text();
        let start = text.trim().get(.."fractional".len())?;
        start.eq_ignore_ascii_case("fractional").then_some(kind)
    }
}

pub(super) fn is_visible(band: &str) -> bool {
    ["Visible", "CIE-Y"].iter().any(|name| name.eq_ignore_ascii_case(band))
}

fn is_colour(band: &str) -> bool {
    ["CIE-X", "CIE-Z", "CIE-u", "CIE-v"].iter().any(|name| name.eq_ignore_ascii_case(band))
}

impl<'d, 'a> Outline<'d, 'a> {
    pub(super) fn of(document: &'d Document<'a>) -> Self {
        let optical = document.root().child("Optical");
        let layer = optical.and_then(|optical| optical.child("Layer"));
        let definition = layer.and_then(|layer| layer.child("DataDefinition"));
        let structure = definition.and_then(|d| d.child("IncidentDataStructure"));
        let mut blocks = Vec::new();
        for data in layer.iter().flat_map(|layer| layer.children_named("WavelengthData")) {
            let Some(wavelength) = data.child("Wavelength") else { continue };
            for node in data.children_named("WavelengthDataBlock") {
                let direction = node.child("WavelengthDataDirection").map(Node::text);
                let sides = direction.and_then(|text| orientation::sides(text.trim()));
                let band = wavelength.text().trim().to_owned();
                blocks.push(OutlineBlock { wavelength, node, band, sides });
            }
        }
        Self { layer, structure, blocks }
    }

    /// Whether its blocks are matrices.
    pub(super) fn is_matrix(&self) -> bool {
        let structure = self.structure.map(Node::text);
        structure.is_some_and(|text| {
            ["Columns", "Rows"].iter().any(|s| s.eq_ignore_ascii_case(text.trim()))
        })
    }

    /// The directions that a band has no block of.
    fn missing(&self, band: fn(&str) -> bool) -> Vec<&'static str> {
        let has = |sides: &(Side, Side)| {
            self.blocks.iter().any(|b| band(&b.band) && b.sides == Some(*sides))
        };
        let missing = orientation::ALL.into_iter().filter(|sides| !has(sides));
        missing.map(|(i, s)| orientation::direction(i, s)).collect()
    }
}

fn is_solar(band: &str) -> bool {
    band.eq_ignore_ascii_case("Solar")
}

pub(super) fn look(outline: &Outline<'_, '_>, found: &mut Findings) {
    let Some(layer) = outline.layer.filter(|_| !outline.blocks.is_empty()) else { return };
    let has = |band: fn(&str) -> bool| outline.blocks.iter().any(|b| band(&b.band));
    if !has(is_visible) {
        let mut bands: Vec<&str> = outline.blocks.iter().map(|b| b.band.as_str()).collect();
        bands.dedup();
        let text = format!("expected the band Visible, found only {}", clip(&bands.join(", ")));
        found.add("no-visible", layer.place(), text);
    }
    let types = outline.blocks.iter().filter(|b| b.sides.is_some());
    let types = types.filter_map(OutlineBlock::fractional);
    let text = |kind: Node<'_, '_>| format!("expected BTDF, found {:?}", clip(kind.text().trim()));
    found.add_first("fractional", types.map(|kind| (kind, text(kind))));
    // WINDOW and EnergyPlus read no trees, whatever bands they have.
    if outline.is_matrix() {
        bands(outline, layer, found);
    }
}

/// What WINDOW's engine wants.
fn bands(outline: &Outline<'_, '_>, layer: Node<'_, '_>, found: &mut Findings) {
    let has_solar = outline.blocks.iter().any(|b| is_solar(&b.band));
    if !has_solar {
        found.add(
            "no-solar",
            layer.place(),
            "expected the bands Visible and Solar, found no Solar",
        );
    }
    for (name, band) in [("Visible", is_visible as fn(&str) -> bool), ("Solar", is_solar)] {
        let missing = outline.missing(band);
        if (1..4).contains(&missing.len()) {
            let text = format!("{name}: expected four directions, found no {}", missing.join(", "));
            found.add("missing-directions", layer.place(), text);
        }
    }
    let further = outline.blocks.iter().filter(|b| !is_visible(&b.band) && !is_solar(&b.band));
    let text = |band: &str| format!("expected Visible or Solar, found {:?}", clip(band));
    found.add_first("further-bands", further.map(|b| (b.wavelength, text(&b.band))));
}

/// The text with the type of values in 1/sr where it says that they are shares; `None` where none are.
pub(super) fn as_values(text: &str, outline: &Outline<'_, '_>) -> Option<String> {
    let types: Vec<_> = outline.blocks.iter().filter_map(OutlineBlock::fractional).collect();
    if types.is_empty() {
        return None;
    }
    let mut edited = String::with_capacity(text.len());
    let mut end = 0;
    for kind in &types {
        let inner = kind.inner();
        edited.push_str(&text[end..inner.start]);
        edited.push_str("BTDF");
        end = inner.end;
    }
    edited.push_str(&text[end..]);
    Some(edited)
}

/// The bands, in small letters, and sides of which the last block, which counts, holds shares of light.
pub(super) fn fractional(outline: &Outline<'_, '_>) -> HashSet<(String, (Side, Side))> {
    let mut all = HashSet::new();
    for block in &outline.blocks {
        let Some(sides) = block.sides else { continue };
        let band = if block.is_seen() { "" } else { &block.band };
        let key = (band.to_ascii_lowercase(), sides);
        match block.fractional() {
            Some(_) => all.insert(key),
            None => all.remove(&key),
        };
    }
    all
}
