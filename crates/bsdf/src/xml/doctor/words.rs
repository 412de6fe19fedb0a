//! Words that programs compare letter by letter.

use super::blocks::{Outline, OutlineBlock};
use super::examine::Findings;
use crate::xml::document::{Document, Node, clip};

pub(super) fn look<'d, 'a>(
    document: &'d Document<'a>,
    outline: &Outline<'d, 'a>,
    found: &mut Findings,
) {
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
    found.add_first("padded-label", labels);
    found.add_first("padded-keyword", keywords);

    let cie_y = outline.blocks.iter().filter(|b| b.band.eq_ignore_ascii_case("CIE-Y"));
    let cie_y = cie_y.map(|b| (b.wavelength, "expected Visible, found CIE-Y".to_owned()));
    found.add_first("cie-y", cie_y);

    if let Some(node) = outline.structure
        && node.text().trim().eq_ignore_ascii_case("Rows")
    {
        found.add("rows", node.place(), "expected Columns, found Rows");
    }
    if outline.is_matrix() {
        let lossy = |b: &OutlineBlock<'d, 'a>| {
            let data = b.node.child("ScatteringData")?;
            ill_parted(&data.text())?;
            Some((data, "expected values parted by one comma each".to_owned()))
        };
        found.add_first("separators", outline.blocks.iter().filter_map(lossy));
    }
}

/// An element with white space about its text.
fn padded<'d, 'a>(node: Node<'d, 'a>) -> Option<(Node<'d, 'a>, String)> {
    let text = node.text();
    let word = text.trim();
    (word.len() != text.len() && !word.is_empty())
        .then(|| (node, format!("expected {:?} alone, found {:?}", clip(word), clip(&text))))
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
