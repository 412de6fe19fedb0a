//! Lines of a text file one at a time, in bounded memory.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use bsdfkit::{Error, Result};

/// No measurement file has longer lines; a binary file without a newline must not fill memory.
const MAX_LINE: usize = 1 << 16;

/// Reads a file line by line, and names the line in errors.
pub(super) struct Lines<'a> {
    path: &'a Path,
    reader: BufReader<File>,
    buffer: Vec<u8>,
    number: u64,
}

impl<'a> Lines<'a> {
    /// Opens `path`.
    pub(super) fn open(path: &'a Path) -> Result<Self> {
        let file = File::open(path).map_err(|e| Error::io(path.display(), &e))?;
        Ok(Self {
            path,
            reader: BufReader::with_capacity(1 << 18, file),
            buffer: Vec::new(),
            number: 0,
        })
    }

    /// The next line without its end, or `None` at the end of the file.
    pub(super) fn next_line(&mut self) -> Result<Option<&str>> {
        self.buffer.clear();
        let read = (&mut self.reader)
            .take(MAX_LINE as u64 + 1)
            .read_until(b'\n', &mut self.buffer)
            .map_err(|e| Error::io(self.path.display(), &e))?;
        if read == 0 {
            return Ok(None);
        }
        self.number += 1;
        if read > MAX_LINE {
            return Err(self.error(format!(
                "expected a line of text, found more than {MAX_LINE} bytes without a line end"
            )));
        }
        if self.number == 1 && self.buffer.starts_with(b"\xef\xbb\xbf") {
            self.buffer.drain(..3);
        }
        if self.buffer.contains(&0) {
            return Err(self.error("expected text, found binary data"));
        }
        match std::str::from_utf8(&self.buffer) {
            Ok(text) => Ok(Some(text.trim_end_matches(['\n', '\r']))),
            Err(_) => Err(self.error("expected text, found bytes that are not UTF-8")),
        }
    }

    /// A format error at the current line.
    pub(super) fn error(&self, message: impl Into<String>) -> Error {
        Error::format(message).context(format_args!("{}:{}", self.path.display(), self.number))
    }
}

/// A word as a finite number.
pub(super) fn number(word: &str, what: &str) -> std::result::Result<f64, String> {
    match word.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(x) => Err(format!("{what}: expected a finite number, found {x}")),
        Err(_) => Err(format!("{what}: expected a number, found {}", quoted(word))),
    }
}

/// A word as an angle in degrees, within two turns: further out it is another column or damage.
pub(super) fn degrees(word: &str, what: &str) -> std::result::Result<f64, String> {
    let angle = number(word, what)?;
    if angle.abs() > 720.0 {
        return Err(format!("{what}: expected degrees from -720 to 720, found {angle}"));
    }
    Ok(angle)
}

/// `text` between quotes, cut to what a message can bear.
pub(super) fn quoted(text: &str) -> String {
    const MOST: usize = 40;
    let cut: String = text.chars().take(MOST).flat_map(char::escape_debug).collect();
    let more = if text.chars().nth(MOST).is_some() { "…" } else { "" };
    format!("\"{cut}{more}\"")
}
