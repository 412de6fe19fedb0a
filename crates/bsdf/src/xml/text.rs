//! Numbers and trees as compact text.

use std::io::Write;

use crate::tree::TreeVisitor;
use crate::{Error, Result};

/// Writes numbers of so many significant digits, as short as they get, separated by blanks.
pub(crate) struct Numbers<W> {
    out: W,
    digits: usize,
    /// Whether a blank must come before the next number.
    blank: bool,
    buffer: Vec<u8>,
}

impl<W: Write> Numbers<W> {
    pub(crate) fn new(out: W, digits: usize) -> Self {
        Self { out, digits, blank: false, buffer: Vec::with_capacity(32) }
    }

    /// Bytes as they are; no blank is needed after them.
    pub(crate) fn raw(&mut self, bytes: &[u8]) -> Result<()> {
        self.blank = false;
        self.out.write_all(bytes).map_err(|e| Error::io("cannot write", &e))
    }

    /// A finite number ≥ 0 in decimal or exponent form, whichever is shorter.
    pub(crate) fn number(&mut self, value: f64) -> Result<()> {
        self.buffer.clear();
        if self.blank {
            self.buffer.push(b' ');
        }
        self.blank = true;
        shortest(value, self.digits, &mut self.buffer);
        self.out.write_all(&self.buffer).map_err(|e| Error::io("cannot write", &e))
    }
}

/// Appends `value` rounded to `digits` significant digits.
fn shortest(value: f64, digits: usize, out: &mut Vec<u8>) {
    // d.ddde±x, the digits correctly rounded.
    let text = format!("{value:.*e}", digits - 1);
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let significant: Vec<u8> = mantissa.bytes().filter(u8::is_ascii_digit).collect();
    let length = significant.iter().rposition(|&d| d != b'0').map_or(0, |last| last + 1);
    let significant = &significant[..length];
    if length == 0 {
        out.push(b'0');
        return;
    }
    // The number is 0.ddd × 10^point, or the integer ddd × 10^(point − length).
    let point = exponent + 1;
    let integer_power = point - length as i32;
    let power = integer_power.to_string();
    let decimal_length = if integer_power >= 0 {
        point as usize
    } else if point > 0 {
        length + 1
    } else {
        length + 1 + point.unsigned_abs() as usize
    };
    if integer_power != 0 && length + 1 + power.len() < decimal_length {
        out.extend_from_slice(significant);
        out.push(b'e');
        out.extend_from_slice(power.as_bytes());
    } else if integer_power >= 0 {
        out.extend_from_slice(significant);
        out.extend(std::iter::repeat_n(b'0', integer_power as usize));
    } else if point > 0 {
        let (whole, fraction) = significant.split_at(point as usize);
        out.extend_from_slice(whole);
        out.push(b'.');
        out.extend_from_slice(fraction);
    } else {
        out.push(b'.');
        out.extend(std::iter::repeat_n(b'0', point.unsigned_abs() as usize));
        out.extend_from_slice(significant);
    }
}

/// Writes a tree in braces, one line a group of finest cells.
pub(crate) struct TreeText<W> {
    numbers: Numbers<W>,
    /// Added to every value.
    constant: f64,
}

impl<W: Write> TreeText<W> {
    pub(crate) fn new(numbers: Numbers<W>, constant: f64) -> Self {
        Self { numbers, constant }
    }
}

impl<W: Write> TreeVisitor for TreeText<W> {
    fn open_branch(&mut self) -> Result<()> {
        self.numbers.raw(b"{")
    }

    fn leaf(&mut self, value: f32) -> Result<()> {
        self.grid(0, &[value])
    }

    fn grid(&mut self, _log2: u32, values: &[f32]) -> Result<()> {
        self.numbers.raw(b"{")?;
        for &value in values {
            self.numbers.number(f64::from(value) + self.constant)?;
        }
        self.numbers.raw(if values.len() > 1 { b"}\n" } else { b"}" })
    }

    fn close_branch(&mut self) -> Result<()> {
        self.numbers.raw(b"}\n")
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn text(value: f64, digits: usize) -> String {
        let mut out = Vec::new();
        shortest(value, digits, &mut out);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn shortest_forms() {
        for (value, expected) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.5, ".5"),
            (0.123456, ".12346"),
            (12.3456, "12.346"),
            (123_456.0, "123460"),
            (1e9, "1e9"),
            (1.5e-7, "15e-8"),
            (0.001, ".001"),
            (0.000_1, "1e-4"),
            (0.999_999, "1"),
            (1e-44, "1e-44"),
        ] {
            assert_eq!(text(value, 5), expected);
        }
    }

    proptest! {
        #[test]
        fn numbers_come_back(value in 0.0f32..3.4e38, tiny in 0.0f64..1.0) {
            prop_assert_eq!(text(f64::from(value), 9).parse::<f32>().unwrap(), value);
            let back: f64 = text(tiny, 5).parse().unwrap();
            prop_assert!((back - tiny).abs() <= 5e-5 * tiny);
        }
    }
}
