//! What kind of file this is, from its first lines and never from its suffix.

use std::path::Path;

use bsdfkit::Result;

use super::line::{Lines, quoted};
use super::table;

/// What a file seems to be.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Content {
    /// pab-opto Mountain text.
    Mountain,
    /// A table with named columns.
    Table,
    /// Text that is no measurement; what it begins with.
    Foreign(String),
}

/// Looks at the lines up to the first that is no comment.
///
/// Errors: class format for what can only be a damaged or mistaken measurement: an empty file, binary data, HTML.
pub(super) fn sniff(path: &Path) -> Result<Content> {
    let mut lines = Lines::open(path)?;
    let mut comments = false;
    loop {
        let Some(line) = lines.next_line()? else {
            if comments {
                return Ok(Content::Mountain);
            }
            return Err(lines.error("expected a measurement, found an empty file"));
        };
        let line = line.trim();
        if line.is_empty() {
            continue;
        }
        if line.starts_with('#') {
            comments = true;
            continue;
        }
        if line.starts_with('<') {
            let found = format!("expected a measurement, found HTML or XML: {}", quoted(line));
            return Err(lines.error(found));
        }
        if table::names_columns(line) {
            return Ok(Content::Table);
        }
        let first = line.split([' ', '\t', ',', ';']).next().unwrap_or("");
        let data = comments || first.parse::<f64>().is_ok();
        return Ok(if data { Content::Mountain } else { Content::Foreign(quoted(line)) });
    }
}
