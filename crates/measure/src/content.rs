//! What kind of file this is, from its first lines and never from its suffix.

use std::io::Read;
use std::path::Path;

use bsdfkit::foreign::{self, Foreign};
use bsdfkit::limits::open_file;
use bsdfkit::{Error, Result};

use super::formats::Format;
use super::line::{Lines, quoted};
use super::table;

/// What a file seems to be.
#[derive(Debug)]
pub(super) enum Content {
    /// pab-opto Mountain text.
    Mountain,
    /// A table with named columns.
    Table,
    /// A format of others.
    Format(&'static Format),
    /// A known format that is not read.
    Foreign(&'static Foreign),
    /// Text that is no measurement; what it begins with.
    Unknown(String),
}

/// Looks at the lines up to the first that is no comment.
///
/// Errors: class format for what can only be a damaged or mistaken measurement: an empty file, binary data, markup.
pub(super) fn sniff(path: &Path) -> Result<Content> {
    let mut head = Vec::new();
    let file = open_file(path)?;
    file.take(foreign::HEAD).read_to_end(&mut head).map_err(|e| Error::io(path.display(), &e))?;
    if let Some(found) = foreign::recognise(&head) {
        let format = found.measured().map(Format::of);
        return Ok(format.map_or(Content::Foreign(found), Content::Format));
    }
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
        if let Some(comment) = line.strip_prefix('#') {
            if table::names_all_columns(comment) {
                return Ok(Content::Table);
            }
            comments = true;
        }
        if !table::is_data(line) {
            continue;
        }
        if line.starts_with('<') {
            let found = format!("expected a measurement, found XML: {}", quoted(line));
            return Err(lines.error(found));
        }
        if table::names_columns(line) {
            return Ok(Content::Table);
        }
        let first = line.split([' ', '\t', ',', ';']).next().unwrap_or("");
        let data = comments || first.parse::<f64>().is_ok();
        return Ok(if data { Content::Mountain } else { Content::Unknown(quoted(line)) });
    }
}
