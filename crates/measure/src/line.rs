//! Lines of a text file one at a time, in bounded memory, whatever its encoding and line ends.

use std::io::{BufRead, BufReader, Read, Seek};
use std::path::Path;

use bsdfkit::encoding::{MENDED, mend, wide};
use bsdfkit::limits::{LINE_BYTES, open_file};
use bsdfkit::{Error, Result};
use encoding_rs_io::{DecodeReaderBytes, DecodeReaderBytesBuilder};

use super::block::Remark;

/// Reads a file line by line, and names the line in errors.
///
/// Lines end in LF, CR LF or CR. UTF-16 is known by its mark or its zeros; of other lines, what is
/// not UTF-8 is taken as Windows-1252, and told ([`Lines::remark`]).
pub(super) struct Lines<'a> {
    path: &'a Path,
    reader: BufReader<DecodeReaderBytes<Box<dyn Read + 'a>, Vec<u8>>>,
    buffer: Vec<u8>,
    /// The line under way where `buffer` is not UTF-8.
    mended: String,
    first_mended: Option<u64>,
    utf16: bool,
    /// The line before ended in CR: an LF at once belongs to it.
    after_cr: bool,
    number: u64,
}

impl<'a> Lines<'a> {
    /// Opens `path`.
    pub(super) fn open(path: &'a Path) -> Result<Self> {
        let io = |e: std::io::Error| Error::io(path.display(), &e);
        let mut file = open_file(path)?;
        let mut head = Vec::new();
        (&mut file).take(4).read_to_end(&mut head).map_err(io)?;
        file.rewind().map_err(io)?;
        Ok(Self::new(path, &head, Box::new(file)))
    }

    /// The lines of `bytes`, which are the file at `path`.
    pub(super) fn of(path: &'a Path, bytes: &'a [u8]) -> Self {
        Self::new(path, bytes, Box::new(bytes))
    }

    /// The lines of a file that starts with `head`.
    fn new(path: &'a Path, head: &[u8], file: Box<dyn Read + 'a>) -> Self {
        let wide = wide(head);
        let decoder = DecodeReaderBytesBuilder::new()
            .encoding(wide.map(|(encoding, _)| encoding))
            .utf8_passthru(true)
            .strip_bom(true)
            .build(file);
        Self {
            path,
            reader: BufReader::with_capacity(1 << 18, decoder),
            buffer: Vec::new(),
            mended: String::new(),
            first_mended: None,
            utf16: wide.is_some(),
            after_cr: false,
            number: 0,
        }
    }

    /// The next line without its end, or `None` at the end of the file.
    pub(super) fn next_line(&mut self) -> Result<Option<&str>> {
        // the control Z ends files of DOS
        if !self.fill()? || self.buffer == [0x1a] {
            return Ok(None);
        }
        if memchr::memchr(0, &self.buffer).is_some() {
            return Err(self.error("expected text, found binary data"));
        }
        match std::str::from_utf8(&self.buffer) {
            Ok(text) if self.utf16 && text.contains(char::REPLACEMENT_CHARACTER) => {
                Err(self.error("expected text, found bytes that are not valid UTF-16"))
            }
            Ok(text) => Ok(Some(text)),
            Err(_) => {
                self.mended = mend(&self.buffer).map_err(|at| {
                    let byte = self.buffer[at];
                    self.error(format!("expected text, found binary data: byte {byte:#04x}"))
                })?;
                self.first_mended.get_or_insert(self.number);
                Ok(Some(&self.mended))
            }
        }
    }

    /// Reads up to the next line end; whether there was anything.
    fn fill(&mut self) -> Result<bool> {
        self.buffer.clear();
        self.number += 1;
        let mut found = false;
        loop {
            let ahead = match self.reader.fill_buf() {
                Ok(ahead) => ahead,
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => continue,
                Err(e) => return Err(Error::io(self.path.display(), &e)),
            };
            if ahead.is_empty() {
                self.number -= u64::from(!found);
                return Ok(found);
            }
            if std::mem::take(&mut self.after_cr) && ahead[0] == b'\n' {
                self.reader.consume(1);
                continue;
            }
            found = true;
            let end = memchr::memchr2(b'\n', b'\r', ahead);
            let part = end.unwrap_or(ahead.len());
            self.buffer.extend_from_slice(&ahead[..part]);
            self.after_cr = end.is_some_and(|at| ahead[at] == b'\r');
            self.reader.consume(part + usize::from(end.is_some()));
            if self.buffer.len() > LINE_BYTES {
                return Err(self.error(format!(
                    "expected a line of text, found more than {LINE_BYTES} bytes without a line end"
                )));
            }
            if end.is_some() {
                return Ok(true);
            }
        }
    }

    /// The line whose encoding had to be guessed, if there was one, and what it was taken for.
    pub(super) fn remark(&self) -> Option<Remark> {
        self.first_mended.map(|line| Remark { line: Some(line), text: MENDED.to_owned() })
    }

    /// The number of the current line, from 1.
    pub(super) fn number(&self) -> u64 {
        self.number
    }

    /// A format error at the current line.
    pub(super) fn error(&self, message: impl Into<String>) -> Error {
        Error::format(message).context(format_args!("{}:{}", self.path.display(), self.number))
    }
}

/// `text` between quotes, cut to what a message can bear.
pub(super) fn quoted(text: &str) -> String {
    const MOST: usize = 40;
    let cut: String = text.chars().take(MOST).flat_map(char::escape_debug).collect();
    let more = if text.chars().nth(MOST).is_some() { "…" } else { "" };
    format!("\"{cut}{more}\"")
}
