//! How the numbers of a file are written: what parts them, and their decimal mark.

use std::str::{Split, SplitAsciiWhitespace};

use bsdfkit::limits::{MAGNITUDE, is_plausible};

use super::line::quoted;

/// What parts the columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Separator {
    /// Blanks and tabs, any number of them.
    Blanks,
    /// One comma or semicolon; one more may end the row.
    Mark(char),
    /// The same, with quotes around some columns, in which it does not count.
    Quoted(char),
}

impl Separator {
    /// What parts `row` into `columns`: semicolons if there are any, else commas if they part it into as many single
    /// words, else blanks if there are any. So commas are decimal marks wherever something else parts the columns.
    pub(super) fn of(row: &str, columns: usize) -> Self {
        let mark = |mark| if row.contains('"') { Self::Quoted(mark) } else { Self::Mark(mark) };
        if row.contains(';') {
            return mark(';');
        }
        let words = || mark(',').fields(row);
        let by_commas = words().count() == columns && words().all(|w| !w.contains([' ', '\t']));
        let blanks = row.trim().contains([' ', '\t']) || !row.contains(',');
        if by_commas || !blanks { mark(',') } else { Self::Blanks }
    }

    /// What parts the names of columns in `line`, which may hold blanks themselves.
    pub(super) fn of_names(line: &str) -> Self {
        let mark = ['\t', ';', ','].into_iter().find(|&mark| line.contains(mark));
        mark.map_or(
            Self::Blanks,
            |m| if line.contains('"') { Self::Quoted(m) } else { Self::Mark(m) },
        )
    }

    /// The message for a row that has another number of columns than `wanted`.
    pub(super) fn miscounted(self, wanted: usize, row: &str) -> String {
        let found = self.fields(row).count();
        let decimal = self == Self::Mark(',') && found > wanted;
        let why = if decimal {
            "; where commas are decimal marks, semicolons, tabs or blanks must part the columns"
        } else {
            ""
        };
        format!("expected {wanted} columns, found {found} in {}{why}", quoted(row))
    }

    /// The columns of `line`, blanks around them taken off.
    pub(super) fn fields(self, line: &str) -> Fields<'_> {
        let closed = |mark: char| {
            let line = line.trim_end();
            line.strip_suffix(mark).unwrap_or(line)
        };
        match self {
            Self::Blanks => Fields::Words(line.split_ascii_whitespace()),
            Self::Mark(mark) => Fields::Parts(closed(mark).split(mark)),
            Self::Quoted(mark) => Fields::Quoted(Some(closed(mark)), mark),
        }
    }
}

/// The columns of a line.
pub(super) enum Fields<'l> {
    Words(SplitAsciiWhitespace<'l>),
    Parts(Split<'l, char>),
    Quoted(Option<&'l str>, char),
}

impl<'l> Iterator for Fields<'l> {
    type Item = &'l str;

    fn next(&mut self) -> Option<&'l str> {
        match self {
            Self::Words(words) => words.next(),
            Self::Parts(parts) => parts.next().map(str::trim),
            Self::Quoted(rest, mark) => {
                let line = rest.take()?.trim_start();
                let mut within = false;
                let end = line.find(|c: char| {
                    within ^= c == '"';
                    c == *mark && !within
                });
                let (field, after) = match end {
                    Some(at) => (&line[..at], Some(&line[at + mark.len_utf8()..])),
                    None => (line, None),
                };
                *rest = after;
                Some(field.trim().trim_matches('"').trim())
            }
        }
    }
}

/// How a file writes numbers: known from the first that has a mark in it, and held to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Decimal {
    /// Whole numbers so far.
    #[default]
    Unknown,
    /// 0.5
    Point,
    /// 0,5
    Comma,
}

impl Decimal {
    /// A word as a finite number.
    pub(super) fn number(&mut self, word: &str, what: &str) -> Result<f64, String> {
        if *self == Self::Unknown {
            *self = match word.find(['.', ',']) {
                Some(at) if word.as_bytes()[at] == b',' => Self::Comma,
                Some(_) => Self::Point,
                None => Self::Unknown,
            };
        }
        let parsed = match self {
            Self::Comma if word.contains('.') => {
                return Err(format!(
                    "{what}: expected a number with a decimal comma, found {}",
                    quoted(word)
                ));
            }
            Self::Comma => word.replacen(',', ".", 1).parse::<f64>(),
            _ => word.parse::<f64>(),
        };
        match parsed {
            Ok(x) if x.is_finite() => Ok(x),
            Ok(x) => Err(format!("{what}: expected a finite number, found {x}")),
            Err(_) if *self == Self::Point && word.contains(',') => Err(format!(
                "{what}: expected a number with a decimal point, found {}",
                quoted(word)
            )),
            Err(_) => Err(format!("{what}: expected a number, found {}", quoted(word))),
        }
    }

    /// A word as f, once it is divided by `divisor`.
    pub(super) fn value(&mut self, word: &str, divisor: f64) -> Result<f32, String> {
        let value = self.number(word, "value")? / divisor;
        if is_plausible(value) {
            return Ok(value as f32);
        }
        Err(format!("value: expected f of at most {MAGNITUDE:e} per steradian, found {value:e}"))
    }

    /// A word as an angle, `factor` times which is degrees within two turns: further out it is another column or
    /// damage.
    pub(super) fn degrees(&mut self, word: &str, factor: f64, what: &str) -> Result<f64, String> {
        let angle = factor * self.number(word, what)?;
        if angle.abs() > 720.0 {
            return Err(format!("{what}: expected degrees from -720 to 720, found {angle}"));
        }
        Ok(angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_part_columns_only_where_they_part_as_many_as_there_are() {
        for (row, separator, fields) in [
            ("20 10 0.5", Separator::Blanks, vec!["20", "10", "0.5"]),
            ("20\t\t10 \t 0,5", Separator::Blanks, vec!["20", "10", "0,5"]),
            ("20,10,0.5", Separator::Mark(','), vec!["20", "10", "0.5"]),
            ("20, 10,\t0.5", Separator::Mark(','), vec!["20", "10", "0.5"]),
            ("20,10,0.5,", Separator::Mark(','), vec!["20", "10", "0.5"]),
            ("20,5 10,5 0,5", Separator::Blanks, vec!["20,5", "10,5", "0,5"]),
            ("20,5 10 0,5", Separator::Blanks, vec!["20,5", "10", "0,5"]),
            ("20,5;10;0,5;", Separator::Mark(';'), vec!["20,5", "10", "0,5"]),
            ("\"20,5\",\"10\",\"0,5\"", Separator::Quoted(','), vec!["20,5", "10", "0,5"]),
        ] {
            assert_eq!(Separator::of(row, 3), separator, "{row}");
            assert_eq!(separator.fields(row).collect::<Vec<_>>(), fields, "{row}");
        }
    }

    #[test]
    fn one_file_has_one_decimal_mark() {
        let mut decimal = Decimal::default();
        assert_eq!(decimal.number("3", "x"), Ok(3.0));
        assert_eq!((decimal.number("0,5", "x"), decimal), (Ok(0.5), Decimal::Comma));
        assert_eq!(decimal.number("-1,5E-3", "x"), Ok(-0.0015));
        assert!(decimal.number("0.5", "x").unwrap_err().contains("a decimal comma"));
        assert!(decimal.number("1,234,5", "x").unwrap_err().contains("expected a number"));
        let mut decimal = Decimal::default();
        assert_eq!((decimal.number("0.5", "x"), decimal), (Ok(0.5), Decimal::Point));
        assert!(decimal.number("0,5", "x").unwrap_err().contains("a decimal point"));
        assert!(Decimal::default().number("1,234.5", "x").unwrap_err().contains("decimal comma"));
    }
}
