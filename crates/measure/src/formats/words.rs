//! Words of a text, one after the other, whatever the lines: files of keywords, counts and lists.

use bsdfkit::{Error, Result};

use super::Whole;
use crate::block::Remark;
use crate::form::Decimal;
use crate::line::{Lines, quoted};

/// Such a text. Lines that begin with # are passed over; blanks, tabs and commas part words.
pub(super) struct Words<'a> {
    lines: Lines<'a>,
    /// Words that the text can have at most: one for two bytes.
    most: usize,
    line: String,
    at: usize,
    decimal: Decimal,
}

impl<'a> Words<'a> {
    pub(super) fn of(whole: &Whole<'a>) -> Self {
        let most = whole.bytes.len().div_ceil(2);
        let (lines, decimal) = (whole.lines(), Decimal::default());
        Self { lines, most, line: String::new(), at: 0, decimal }
    }

    /// The next word; `None` at the end of the text.
    pub(super) fn next(&mut self) -> Result<Option<&str>> {
        let part = |c: char| c.is_whitespace() || c == ',';
        loop {
            let rest = &self.line[self.at..];
            if let Some(start) = rest.find(|c| !part(c)) {
                let rest = &rest[start..];
                let end = rest.find(part).unwrap_or(rest.len());
                let start = self.at + start;
                self.at = start + end;
                return Ok(Some(&self.line[start..start + end]));
            }
            let Some(line) = self.lines.next_line()? else { return Ok(None) };
            self.line.clear();
            self.at = 0;
            if !line.trim_start().starts_with('#') {
                self.line.push_str(line);
            }
        }
    }

    /// The next word.
    pub(super) fn word(&mut self, what: &str) -> Result<String> {
        match self.next()? {
            Some(word) => Ok(word.to_owned()),
            None => Err(self.error(format!("{what}: expected a word, found the end of the file"))),
        }
    }

    /// The next word as a finite number.
    pub(super) fn number(&mut self, what: &str) -> Result<f64> {
        let word = self.word(what)?;
        let number = self.decimal.number(&word, what);
        number.map_err(|m| self.error(m))
    }

    /// The next word as a value of f.
    pub(super) fn value(&mut self) -> Result<f32> {
        let word = self.word("value")?;
        let value = self.decimal.value(&word, 1.0);
        value.map_err(|m| self.error(m))
    }

    /// A count, and as many rising angles in degrees from `least` to `most`.
    pub(super) fn angles(&mut self, what: &str, least: f64, most: f64) -> Result<Vec<f64>> {
        let count = self.number(what)?;
        if count.fract() != 0.0 || !(1.0..=self.most as f64).contains(&count) {
            let text = format!("{what}: expected a count of at least 1, found {count}");
            return Err(self.error(text));
        }
        let mut angles: Vec<f64> = Vec::new();
        for _ in 0..count as usize {
            let angle = self.number(what)?;
            if !(least..=most).contains(&angle) {
                let text =
                    format!("{what}: expected degrees from {least} to {most}, found {angle}");
                return Err(self.error(text));
            }
            if angles.last().is_some_and(|last| *last >= angle) {
                let last = angles[angles.len() - 1];
                let text = format!("{what}: expected rising angles, found {angle} after {last}");
                return Err(self.error(text));
            }
            angles.push(angle);
        }
        Ok(angles)
    }

    /// Refuses more values than the text can hold, before there is memory for them.
    pub(super) fn expect_room(&self, counts: &[usize], what: &str) -> Result<usize> {
        let count = counts.iter().try_fold(1_usize, |product, n| product.checked_mul(*n));
        count.filter(|n| *n <= self.most).ok_or_else(|| {
            let most = self.most;
            self.error(format!(
                "{what}: expected {counts:?} values, found a file of at most {most} words"
            ))
        })
    }

    /// A format error at the line of the last word.
    pub(super) fn error(&self, message: impl Into<String>) -> Error {
        self.lines.error(message)
    }

    /// That of an unknown word.
    pub(super) fn unknown(&self, what: &str, expected: &str, found: &str) -> Error {
        self.error(format!("{what}: expected {expected}, found {}", quoted(found)))
    }

    /// What was guessed of the encoding.
    pub(super) fn remark(&self) -> Option<Remark> {
        self.lines.remark()
    }
}
