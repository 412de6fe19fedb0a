//! The file as a text: what stands outside the document, its encoding, its lines.

use super::examine::Findings;
use crate::encoding::wide;
use crate::xml::document::{clip, line_of};

/// Lines in which honeybee looks for the structure.
const LINES: usize = 2000;

pub(super) fn look(text: &str, bytes: &[u8], found: &mut Findings) {
    let before = &text[..text.find('<').unwrap_or(0)];
    if !before.trim().is_empty() {
        let what = clip(before.trim());
        found.add("before-declaration", "line 1", format!("expected <, found {what:?}"));
    }
    if let Some((encoding, _)) = wide(bytes) {
        found.add("encoding", "", format!("expected UTF-8, found {}", encoding.name()));
    }
    lines(text, found);
}

/// Whether the document is not the first thing in the file.
pub(super) fn has_text_before(text: &str) -> bool {
    text.find('<').is_some_and(|at| !text[..at].trim().is_empty())
}

/// honeybee takes a line that begins with the tag, and what else is on that line.
fn lines(text: &str, found: &mut Findings) {
    for tag in ["<IncidentDataStructure>", "<AngleBasisName>"] {
        let Some(at) = text.find(tag) else {
            // Trees have no basis of a name; a file without structure cannot be read at all.
            if tag == "<AngleBasisName>" && text.contains("Basis>LBNL/Klems") {
                found.add(
                    "line-breaks",
                    "",
                    format!("expected {tag} at the start of a line, found none"),
                );
            }
            continue;
        };
        let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
        let line = line_of(text, at);
        if !text[start..at].trim().is_empty() {
            let place = format!("line {line}");
            found.add("line-breaks", place, format!("expected {tag} at the start of a line"));
        } else if line > LINES {
            found.add("late-structure", format!("line {line}"), format!("{tag} first stands here"));
        } else {
            continue;
        }
        return;
    }
}
