//! What a file holds and nothing here reads: kept as it was written, as long as it stays true.

use super::document::{Document, Node};
use super::limits::Limits;
use super::report::Report;
use crate::Metadata;

/// Where such elements may stand: the parents that a writer knows.
pub(super) const ROOT: &str = "";
pub(super) const OPTICAL: &str = "Optical";
pub(super) const LAYER: &str = "Optical/Layer";
pub(super) const MATERIAL: &str = "Optical/Layer/Material";
pub(super) const GEOMETRY: &str = "Optical/Layer/Geometry";
/// Angle bases and what else explains the numbers.
pub(super) const DEFINITION: &str = "Optical/Layer/DataDefinition";
/// Whole blocks of data, `WavelengthData` and all.
pub(super) const BLOCKS: &str = "Optical/Layer/WavelengthData";

/// Keeps an element as it was written, below `parent`.
pub(super) fn keep(metadata: &mut Metadata, parent: &str, verbatim: &str) {
    match metadata.unread.iter_mut().find(|(place, _)| place == parent) {
        Some((_, text)) => {
            text.push('\n');
            text.push_str(verbatim);
        }
        None => metadata.unread.push((parent.to_owned(), verbatim.to_owned())),
    }
}

/// Keeps one block of a `WavelengthData`, with the header that it stands under.
pub(super) fn keep_block(metadata: &mut Metadata, data: Node<'_, '_>, block: Node<'_, '_>) {
    let others = data.children().filter(|c| c.name() != "WavelengthDataBlock");
    let header: Vec<&str> = others.map(Node::verbatim).collect();
    let (header, block) = (header.join("\n"), block.verbatim());
    keep(metadata, BLOCKS, &format!("<WavelengthData>\n{header}\n{block}\n</WavelengthData>"));
}

impl Metadata {
    /// Blocks of data and angle bases that nothing read: they hold only in the structure and the
    /// bases that the file had. In words: "Visible Absorbed Front".
    pub fn bound(&self) -> Vec<String> {
        let bound = self.unread.iter().filter(|(place, _)| is_bound(place));
        bound.flat_map(|(_, text)| names(text)).collect()
    }

    /// The same without them, for values that get another structure.
    #[must_use]
    pub fn unbound(mut self) -> Self {
        self.unread.retain(|(place, _)| !is_bound(place));
        self
    }
}

fn is_bound(place: &str) -> bool {
    [BLOCKS, DEFINITION].contains(&place)
}

/// What elements kept as they were written are called.
fn names(verbatim: &str) -> Vec<String> {
    let text = format!("<kept>{verbatim}</kept>");
    let mut report = Report::without_warnings(1);
    let Some(document) = Document::parse(&text, &Limits::default(), &mut report) else {
        return vec!["data".to_owned()];
    };
    let inside = |node: Node<'_, '_>, name| {
        let text = node.child(name).map(Node::text).unwrap_or_default();
        text.trim().chars().take(60).collect::<String>()
    };
    let name = |node: Node<'_, '_>| match node.name() {
        "WavelengthData" => {
            let blocks = node.children_named("WavelengthDataBlock");
            let mut words = vec![inside(node, "Wavelength")];
            words.extend(blocks.map(|b| inside(b, "WavelengthDataDirection")));
            words.retain(|w| !w.is_empty());
            words.join(" ")
        }
        "AngleBasis" => inside(node, "AngleBasisName"),
        other => other.to_owned(),
    };
    document.root().children().map(name).collect()
}
