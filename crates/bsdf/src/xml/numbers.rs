//! The text of a data block: numbers, braces, separators. 95 % of a file is this.

use super::document::clip;

/// What a data block consists of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Token {
    Number(f32),
    Open,
    Close,
    End,
}

/// A data block that is not numbers; `at` is the byte offset.
#[derive(Debug, PartialEq)]
pub(crate) struct Misfit {
    pub(crate) at: usize,
    pub(crate) text: String,
}

/// Splits text into [`Token`]s: white space is free, one comma may follow a number or a `}`.
///
/// Numbers: optional sign, digits with optional point, optional exponent; they end at white
/// space, comma or brace. Words such as `nan`, hexadecimal digits and magnitudes beyond f32 are
/// misfits.
/// Differs from: Radiance, which lets numbers touch and turns `1e400` into infinity.
pub(crate) struct Lexer<'t> {
    text: &'t str,
    at: usize,
    /// Whether a comma may come next.
    comma: bool,
}

const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

impl<'t> Lexer<'t> {
    pub(crate) fn new(text: &'t str) -> Self {
        Self { text, at: 0, comma: false }
    }

    /// Byte offset of what [`next`](Self::next) will read.
    pub(crate) fn offset(&self) -> usize {
        self.at
    }

    /// The next token; [`Token::End`] for ever at the end.
    #[inline]
    pub(crate) fn next(&mut self) -> Result<Token, Misfit> {
        let bytes = self.text.as_bytes();
        loop {
            let Some(&byte) = bytes.get(self.at) else { return Ok(Token::End) };
            match byte {
                b' ' | b'\n' | b'\t' | b'\r' => self.at += 1,
                b',' if self.comma => {
                    self.at += 1;
                    self.comma = false;
                }
                b'{' => {
                    self.at += 1;
                    self.comma = false;
                    return Ok(Token::Open);
                }
                b'}' => {
                    self.at += 1;
                    self.comma = true;
                    return Ok(Token::Close);
                }
                b',' => return Err(self.misfit("expected a number, found a second comma")),
                _ => {
                    let value = self.number()?;
                    self.comma = true;
                    return Ok(Token::Number(value));
                }
            }
        }
    }

    /// Reads a number at the cursor.
    ///
    /// Accuracy: the nearest f64 rounded to f32. Up to 15 digits and a power of ten within ±22
    /// both are exact in f64, so that one division or product is correctly rounded.
    #[inline]
    fn number(&mut self) -> Result<f32, Misfit> {
        let bytes = self.text.as_bytes();
        let negative = bytes[self.at] == b'-';
        let signed = negative || bytes[self.at] == b'+';
        let whole = self.at + usize::from(signed);
        let mut digits = 0;
        let mut at = take_digits(bytes, whole, &mut digits);
        let mut count = at - whole;
        let mut exponent = 0i32;
        if bytes.get(at) == Some(&b'.') {
            let fraction = at + 1;
            at = take_digits(bytes, fraction, &mut digits);
            count += at - fraction;
            exponent = i32::try_from(at - fraction).map_or(i32::MIN, |n| -n);
        }
        let mut valid = count > 0;
        if valid && matches!(bytes.get(at), Some(b'e' | b'E')) {
            at += 1;
            let minus = bytes.get(at) == Some(&b'-');
            if minus || bytes.get(at) == Some(&b'+') {
                at += 1;
            }
            let start = at;
            let mut power = 0i32;
            while let Some(byte) = bytes.get(at).filter(|b| b.is_ascii_digit()) {
                power = power.saturating_mul(10).saturating_add(i32::from(byte - b'0'));
                at += 1;
            }
            valid = at > start;
            exponent = exponent.saturating_add(if minus { -power } else { power });
        }
        let ended =
            matches!(bytes.get(at), None | Some(b' ' | b'\n' | b'\t' | b'\r' | b',' | b'{' | b'}'));
        if !valid || !ended {
            return Err(self.no_number());
        }
        let magnitude = if count <= 15 && exponent.unsigned_abs() <= 22 {
            let power = POWERS[exponent.unsigned_abs() as usize];
            if exponent < 0 { digits as f64 / power } else { digits as f64 * power }
        } else {
            // The grammar above is a subset of the one that `parse` reads.
            self.text[self.at..at].parse::<f64>().map_or(f64::NAN, f64::abs)
        };
        let value = if negative { -magnitude } else { magnitude } as f32;
        if !value.is_finite() {
            return Err(self.too_large(at));
        }
        self.at = at;
        Ok(value)
    }

    #[cold]
    fn no_number(&self) -> Misfit {
        let rest = &self.text[self.at..];
        let end = rest.find(|c: char| c.is_whitespace() || ",{}".contains(c)).unwrap_or(rest.len());
        self.misfit(format!("expected a number, found {:?}", clip(&rest[..end])))
    }

    #[cold]
    fn too_large(&self, end: usize) -> Misfit {
        let text = clip(&self.text[self.at..end]);
        self.misfit(format!("expected a number below 3.4e38, found {text}"))
    }

    fn misfit(&self, text: impl Into<String>) -> Misfit {
        Misfit { at: self.at, text: text.into() }
    }
}

/// Appends the decimal digits from `at` to `value` (wrapping) and returns where they end.
#[inline(always)]
fn take_digits(bytes: &[u8], mut at: usize, value: &mut u64) -> usize {
    while let Some(digit) = bytes.get(at).map(|b| b.wrapping_sub(b'0')).filter(|d| *d < 10) {
        *value = value.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    at
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn tokens(text: &str) -> Result<Vec<Token>, Misfit> {
        let mut lexer = Lexer::new(text);
        let mut tokens = Vec::new();
        loop {
            match lexer.next()? {
                Token::End => return Ok(tokens),
                token => tokens.push(token),
            }
        }
    }

    #[test]
    fn separators_and_braces() {
        use Token::{Close, Number, Open};
        let expected = vec![Open, Number(1.0), Number(-0.25), Close, Number(3e-5)];
        assert_eq!(tokens("{1 , -.25},\r\n\t3.E-05,").unwrap(), expected);
        assert_eq!(tokens(" ").unwrap(), []);
    }

    #[test]
    fn misfits_are_named_and_placed() {
        for (text, at, part) in [
            ("1 nan", 2, "\"nan\""),
            ("0.1-0.2", 0, "\"0.1-0.2\""),
            ("1,,2", 2, "second comma"),
            (",1", 0, "comma"),
            ("{,1}", 1, "comma"),
            ("1e", 0, "\"1e\""),
            ("1e+ 4", 0, "\"1e+\""),
            (".", 0, "\".\""),
            ("-", 0, "\"-\""),
            ("0x10", 0, "\"0x10\""),
            ("1.2.3", 0, "\"1.2.3\""),
            ("1e400", 0, "3.4e38"),
            ("-1e39", 0, "3.4e38"),
            ("1 \u{e4}", 2, "\"ä\""),
        ] {
            let misfit = tokens(text).unwrap_err();
            assert_eq!(misfit.at, at, "{text}");
            assert!(misfit.text.contains(part), "{text}: {}", misfit.text);
        }
    }

    proptest! {
        #[test]
        fn numbers_equal_the_standard_library(value: f32, digits in 0usize..20) {
            prop_assume!(value.is_finite());
            for text in [format!("{value}"), format!("{value:e}"), format!("{value:.digits$e}")] {
                let expected = text.parse::<f64>().unwrap() as f32;
                if expected.is_finite() {
                    prop_assert_eq!(tokens(&text).unwrap(), vec![Token::Number(expected)]);
                }
            }
        }

        #[test]
        fn no_text_panics(text in "\\PC*", braces in "[0-9.,eE+{} -]*") {
            let _ = tokens(&text);
            let _ = tokens(&braces);
        }
    }
}
