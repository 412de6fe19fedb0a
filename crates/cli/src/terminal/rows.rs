//! Rows of numbers on standard input.

use std::io::Read;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

use bsdfkit::{Error, Result};

/// Bytes of rows answered at once when more than that is waiting.
const BLOCK: usize = 1 << 22;
/// Bytes read at once; also the longest row.
const READ: usize = 1 << 16;

/// Rows of up to `N` numbers, in blocks: whatever has arrived is handed out, so that a partner on a
/// pipe gets its answers before it asks on.
pub(crate) struct Rows<const N: usize> {
    arrived: Receiver<std::io::Result<Vec<u8>>>,
    /// Numbers in a row.
    width: usize,
    /// What follows the last complete row.
    rest: Vec<u8>,
    line: usize,
    ended: bool,
}

impl<const N: usize> Rows<N> {
    /// Rows of `width` numbers, at most `N`, read from `input` by a thread of their own.
    pub(crate) fn new(mut input: impl Read + Send + 'static, width: usize) -> Self {
        let (sender, arrived) = sync_channel(2 * BLOCK / READ);
        thread::spawn(move || {
            loop {
                let mut bytes = vec![0; READ];
                let message = match input.read(&mut bytes) {
                    Ok(0) => break,
                    Err(e) if e.kind() == std::io::ErrorKind::Interrupted => continue,
                    result => result.map(|count| {
                        bytes.truncate(count);
                        bytes
                    }),
                };
                let failed = message.is_err();
                if sender.send(message).is_err() || failed {
                    break;
                }
            }
        });
        Self { arrived, width, rest: Vec::new(), line: 0, ended: false }
    }

    /// The next rows with their line numbers, filled up with zeros; empty only at the end.
    ///
    /// Errors: io; format with the line, expected and found. Blank lines and lines that begin with
    /// `#` are passed over.
    pub(crate) fn block(&mut self) -> Result<Vec<(usize, [f64; N])>> {
        let mut rows = Vec::new();
        while rows.is_empty() && !self.ended {
            let bytes = self.complete_lines()?;
            for line in bytes.split_inclusive(|&b| b == b'\n') {
                self.line += 1;
                if let Some(row) = parse(line, self.width).map_err(|e| e.context(self.place()))? {
                    rows.push((self.line, row));
                }
            }
        }
        Ok(rows)
    }

    /// All complete lines that have arrived; waits for one.
    fn complete_lines(&mut self) -> Result<Vec<u8>> {
        let mut bytes = std::mem::take(&mut self.rest);
        let mut end = 0;
        while bytes.len() < BLOCK {
            let next = match self.arrived.try_recv() {
                Ok(next) => Some(next),
                Err(_) if end > 0 => break,
                Err(_) => self.arrived.recv().ok(),
            };
            let Some(next) = next else {
                self.ended = true;
                end = bytes.len();
                break;
            };
            let next = next.map_err(|e| Error::io("standard input", &e))?;
            if let Some(last) = next.iter().rposition(|&b| b == b'\n') {
                end = bytes.len() + last + 1;
            }
            bytes.extend_from_slice(&next);
            if bytes.len() - end > READ {
                self.line += 1 + bytes[..end].iter().filter(|&&b| b == b'\n').count();
                let text = format!(
                    "expected a row of {} numbers, found more than {READ} bytes",
                    self.width
                );
                return Err(Error::format(text).context(self.place()));
            }
        }
        self.rest = bytes.split_off(end);
        Ok(bytes)
    }

    fn place(&self) -> String {
        format!("standard input: line {}", self.line)
    }
}

/// The numbers of a line; `None` for a blank line or a comment.
fn parse<const N: usize>(line: &[u8], width: usize) -> Result<Option<[f64; N]>> {
    let Ok(text) = str::from_utf8(line) else {
        return Err(Error::format(format!(
            "expected {width} numbers, found bytes that are no text"
        )));
    };
    let text = text.trim();
    if text.is_empty() || text.starts_with('#') {
        return Ok(None);
    }
    let mut row = [0.0; N];
    let mut count = 0;
    for word in text.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty()) {
        let value: f64 = match word.parse() {
            Ok(value) if f64::is_finite(value) => value,
            _ => {
                let word: String = word.chars().take(40).collect();
                return Err(Error::format(format!("expected a finite number, found {word:?}")));
            }
        };
        if let Some(place) = row.get_mut(count) {
            *place = value;
        }
        count += 1;
    }
    if count != width {
        return Err(Error::format(format!("expected {width} numbers, found {count}")));
    }
    Ok(Some(row))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &'static str) -> Result<Vec<(usize, [f64; 2])>> {
        let mut rows = Rows::<2>::new(text.as_bytes(), 2);
        let mut all = Vec::new();
        loop {
            let block = rows.block()?;
            if block.is_empty() {
                return Ok(all);
            }
            all.extend(block);
        }
    }

    #[test]
    fn rows_keep_their_line_numbers() {
        let rows = all("# head\n1 2\n\n 3,\t4\r\n5e0 -6").unwrap();
        assert_eq!(rows, [(2, [1.0, 2.0]), (4, [3.0, 4.0]), (5, [5.0, -6.0])]);
        assert!(all("").unwrap().is_empty());
    }

    #[test]
    fn a_bad_row_is_named() {
        let message = |text| all(text).unwrap_err().to_string();
        assert_eq!(message("1 2\n3\n"), "standard input: line 2: expected 2 numbers, found 1");
        assert_eq!(message("1 2 3"), "standard input: line 1: expected 2 numbers, found 3");
        assert!(message("1 x").ends_with("found \"x\""));
        assert!(message("1 nan").contains("finite"));
    }

    #[test]
    fn an_endless_row_is_refused() {
        let mut rows = Rows::<2>::new(std::io::repeat(b'1'), 2);
        let message = rows.block().unwrap_err().to_string();
        assert!(message.contains("line 1: expected a row of 2 numbers"), "{message}");
    }
}
