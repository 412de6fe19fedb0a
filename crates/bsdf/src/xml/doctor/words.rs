//! Words that programs compare letter by letter.

use super::blocks::Outline;
use super::examine::Findings;
use crate::xml::document::{Document, Node, clip};

pub(super) fn look(document: &Document<'_>, outline: &Outline<'_, '_>, found: &mut Findings) {
    let mut labels = Vec::new();
    let mut keywords = Vec::new();
    keywords.extend(document.root().child("FileType").and_then(padded));
    keywords.extend(outline.structure.and_then(padded));
    for block in outline.blocks.iter().filter(|b| b.is_seen() && b.sides.is_some()) {
        labels.extend(padded(block.wavelength));
        labels.extend(block.node.child("WavelengthDataDirection").and_then(padded));
        for name in ["ColumnAngleBasis", "RowAngleBasis", "AngleBasis"] {
            keywords.extend(block.node.child(name).and_then(padded));
        }
    }
    labels.dedup();
    found.add_places("padded-label", &labels);
    found.add_places("padded-keyword", &keywords);

    let cie_y = outline.blocks.iter().filter(|b| b.band.eq_ignore_ascii_case("CIE-Y"));
    let mut places: Vec<_> =
        cie_y.map(|b| (b.wavelength.place(), "expected Visible, found CIE-Y".to_owned())).collect();
    places.dedup();
    found.add_places("cie-y", &places);

    if let Some(node) = outline.structure
        && node.text().trim().eq_ignore_ascii_case("Rows")
    {
        found.add("rows", node.place(), "expected Columns, found Rows");
    }
    if outline.is_matrix() {
        let parted = |b: &super::blocks::OutlineBlock<'_, '_>| {
            let data = b.node.child("ScatteringData")?;
            let at = ill_parted(&data.text())?;
            let text = "expected values parted by one comma each".to_owned();
            Some((data.place_in_text(at), text))
        };
        let places: Vec<_> = outline.blocks.iter().filter_map(parted).collect();
        found.add_places("separators", &places);
    }
}

/// The place of an element with white space about its text.
fn padded(node: Node<'_, '_>) -> Option<(String, String)> {
    let text = node.text();
    let word = text.trim();
    (word.len() != text.len() && !word.is_empty()).then(|| {
        let text = format!("expected {word:?} alone, found {:?}", clip(&text));
        (node.place(), text)
    })
}

/// Where WINDOW's engine would lose a value: it splits at every comma, or without one at every blank, and
/// reads one number of each part.
fn ill_parted(text: &str) -> Option<usize> {
    let by = if text.contains(',') { b',' } else { b' ' };
    let blank = |b: u8| b == b',' || b.is_ascii_whitespace();
    // Between two numbers, those of the separators that count.
    let (mut separators, mut numbers) = (1, 0);
    let mut before = b' ';
    for (at, &byte) in text.as_bytes().iter().enumerate() {
        if blank(byte) {
            separators += usize::from(byte == by);
        } else if blank(before) || at == 0 {
            if numbers > 0 && separators != 1 {
                return Some(at);
            }
            (numbers, separators) = (numbers + 1, 0);
        }
        before = byte;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::ill_parted;

    /// What pywincalc 3.3.1 reads of each, with the values of a whole matrix.
    #[test]
    fn values_are_parted_as_the_engine_does() {
        for sound in
            ["1,2,\n3,4,\n", "1, 2,\n3, 4", "1,2,\r\n3,4", "1 2 3 4", "1 2 \n3 4 \n", "", "\n1"]
        {
            assert_eq!(ill_parted(sound), None, "{sound:?}");
        }
        for (lossy, at) in [("1 2\n3 4", 4), ("1\n2", 2), ("1\t2", 2), ("1  2", 3), ("1,2\n3,4", 4)]
        {
            assert_eq!(ill_parted(lossy), Some(at), "{lossy:?}");
        }
    }
}
