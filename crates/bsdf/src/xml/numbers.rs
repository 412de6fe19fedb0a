//! The text of a data block: numbers, braces, separators. 95 % of a file is this.

use super::decimal::{
    Class, POWERS, SMALL, WINDOW, blank_and_fraction, blank_and_integer, scaled, short_decimal,
};
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

    /// Appends the numbers of the usual, short form that come next, up to `most` values in all.
    ///
    /// Stops behind the last of them: what follows is for [`next`](Self::next).
    #[inline]
    pub(crate) fn short_numbers(&mut self, values: &mut Vec<f32>, most: usize) {
        let bytes = self.text.as_bytes();
        let mut at = self.at;
        while values.len() < most {
            let mut comma = self.comma;
            while let Some(&byte) = bytes.get(at) {
                match Class::of(byte) {
                    Class::Blank => {}
                    Class::Comma if comma => comma = false,
                    _ => break,
                }
                at += 1;
            }
            let window = bytes.get(at..).and_then(|rest| rest.first_chunk::<WINDOW>());
            let Some((value, length)) = window.and_then(short_decimal) else { return };
            values.push(value);
            at += length;
            self.at = at;
            self.comma = true;
            // Like numbers mostly come in rows.
            if length < SMALL {
                self.rows(values, most, blank_and_integer);
            } else {
                self.rows(values, most, blank_and_fraction);
            }
            at = self.at;
        }
    }

    /// Appends the numbers that follow a number as long as `read` can tell them.
    #[inline(always)]
    fn rows<const N: usize>(
        &mut self,
        values: &mut Vec<f32>,
        most: usize,
        read: impl Fn(&[u8; N]) -> Option<(f32, usize)>,
    ) {
        let bytes = self.text.as_bytes();
        let mut at = self.at;
        while values.len() < most {
            let next = bytes.get(at..).and_then(|rest| rest.first_chunk());
            let Some((value, length)) = next.and_then(&read) else { break };
            values.push(value);
            at += length;
        }
        self.at = at;
    }

    /// Reads a number at the cursor.
    ///
    /// Accuracy: the nearest f64 rounded to f32.
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
        let ended = bytes.get(at).is_none_or(|&byte| Class::of(byte) != Class::Other);
        if !valid || !ended {
            return Err(self.no_number());
        }
        let magnitude = if count <= 15 && exponent.unsigned_abs() < POWERS.len() as u32 {
            scaled(digits, exponent)
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

    /// Token by token; where short numbers may come, they are read as such if asked for.
    fn tokens_read(text: &str, short: bool) -> Result<Vec<Token>, Misfit> {
        let mut lexer = Lexer::new(text);
        let mut tokens = Vec::new();
        let mut values = Vec::new();
        loop {
            if short {
                // Never too many at once.
                lexer.short_numbers(&mut values, 3);
                tokens.extend(values.drain(..).map(Token::Number));
            }
            match lexer.next()? {
                Token::End => return Ok(tokens),
                token => tokens.push(token),
            }
        }
    }

    /// Both ways, which must agree.
    fn tokens(text: &str) -> Result<Vec<Token>, Misfit> {
        // Short numbers are only looked for where enough text follows.
        for text in [text, &format!("{text}{:16}", "")] {
            assert_eq!(tokens_read(text, true), tokens_read(text, false), "{text:?}");
        }
        tokens_read(text, true)
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

    /// A number in one of the ways that programs write numbers.
    fn spelt() -> impl Strategy<Value = (String, f32)> {
        let value = prop_oneof![
            any::<f32>().prop_filter("finite", |v| v.is_finite()),
            0.0f32..2.0,
            (0u32..1 << 25).prop_map(|n| n as f32),
        ];
        let text = (value, 0usize..20, 0..5).prop_map(|(value, digits, form)| match form {
            0 => format!("{value}"),
            1 => format!("{value:e}"),
            2 => format!("{value:.digits$e}"),
            3 => format!("{value:.digits$}"),
            // As C writes it: two digits of exponent at least, no zero before the point.
            _ => {
                let text = format!("{value:.digits$e}").replace('e', "e+").replace("e+-", "e-");
                let (mantissa, power) = text.split_at(text.len() - 1);
                let zero = if mantissa.ends_with(['+', '-']) { "0" } else { "" };
                format!("{mantissa}{zero}{power}").trim_start_matches('0').to_owned()
            }
        });
        text.prop_filter_map("a number that f32 holds", |text| {
            let value = text.parse::<f64>().ok()? as f32;
            value.is_finite().then_some((text, value))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn numbers_equal_the_standard_library(
            numbers in prop::collection::vec((spelt(), "[ \t\r\n]{1,2}|,[ \n]{0,2}| ,"), 1..12),
        ) {
            let text: String = numbers.iter().map(|((t, _), gap)| format!("{t}{gap}")).collect();
            let expected: Vec<_> = numbers.iter().map(|((_, v), _)| Token::Number(*v)).collect();
            prop_assert_eq!(tokens(&text), Ok(expected));
        }

        #[test]
        fn no_text_panics(text in "\\PC*", braces in "[0-9.,eE+{} -]*") {
            let _ = tokens(&text);
            let _ = tokens(&braces);
        }
    }
}
