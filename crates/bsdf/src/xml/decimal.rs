//! Numbers of at most eight digits, eight bytes at a time.

/// Bytes looked at: the longest number read here, and what ends it.
pub(crate) const WINDOW: usize = 16;

/// Powers of ten that are exact in f64.
pub(crate) const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// What a byte is to numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Class {
    Blank,
    Comma,
    Brace,
    Other,
}

impl Class {
    #[inline(always)]
    pub(crate) fn of(byte: u8) -> Self {
        const CLASSES: [Class; 256] = {
            let mut classes = [Class::Other; 256];
            classes[b' ' as usize] = Class::Blank;
            classes[b'\n' as usize] = Class::Blank;
            classes[b'\t' as usize] = Class::Blank;
            classes[b'\r' as usize] = Class::Blank;
            classes[b',' as usize] = Class::Comma;
            classes[b'{' as usize] = Class::Brace;
            classes[b'}' as usize] = Class::Brace;
            classes
        };
        CLASSES[usize::from(byte)]
    }
}

/// digits · 10^exponent.
///
/// Accuracy: the nearest f64 for at most 15 digits and a power within ±22: both are exact, so that
/// one quotient or product is correctly rounded.
#[inline(always)]
pub(crate) fn scaled(digits: u64, exponent: i32) -> f64 {
    let power = POWERS[exponent.unsigned_abs() as usize];
    if exponent < 0 { digits as f64 / power } else { digits as f64 * power }
}

/// A number with fewer characters than this is small: often a zero, and among its like.
pub(crate) const SMALL: usize = 5;

/// A blank, then a number of one to four digits without point or exponent, then a blank: the number, and how
/// many bytes come before the last blank.
///
/// Cost: 1.5 ns where lengths come in rows: the processor guesses them, and does not wait to know where the
/// next number starts. (Without branches 4 ns.)
#[inline(always)]
pub(crate) fn blank_and_integer(bytes: &[u8; 8]) -> Option<(f32, usize)> {
    let blank = |at: usize| Class::of(bytes[at]) == Class::Blank;
    let digit = |at: usize| Some(u32::from(bytes[at].wrapping_sub(b'0'))).filter(|d| *d < 10);
    if !blank(0) {
        return None;
    }
    let mut value = digit(1)?;
    for end in 2..=SMALL {
        if blank(end) {
            return Some((value as f32, end));
        }
        value = 10 * value + digit(end)?;
    }
    None
}

/// A blank, a point, one to seven digits and what ends a number: the number, and how many bytes come before
/// what ends it.
///
/// Accuracy: the nearest f64 rounded to f32.
/// Cost: 6 ns; by [`short_decimal`], which has more to decide, 10.
#[inline(always)]
pub(crate) fn blank_and_fraction(bytes: &[u8; WINDOW]) -> Option<(f32, usize)> {
    let digits = word(bytes, 2);
    let places = leading_digits(digits);
    let usual = Class::of(bytes[0]) == Class::Blank && bytes[1] == b'.' && (1..8).contains(&places);
    if !usual || Class::of(bytes[2 + places]) == Class::Other {
        return None;
    }
    let value = eight_digits((digits ^ repeat(b'0')) << (64 - 8 * places))?;
    Some((scaled(value, -(places as i32)) as f32, 2 + places))
}

/// The number that the bytes start with, and its length; `None` for what is not the usual form:
/// no sign, one to eight digits with optional point, an exponent of one or two digits, then what
/// ends a number.
///
/// Accuracy: the nearest f64 rounded to f32.
/// Cost: 5 ns; byte by byte 15 (five digits each, the processor guessing most lengths right).
#[inline(always)]
pub(crate) fn short_decimal(window: &[u8; WINDOW]) -> Option<(f32, usize)> {
    // The commonest forms by themselves, so that the processor guesses where the point is.
    if window[0] == b'.' {
        with_fraction(window, 0)
    } else if window[1] == b'.' {
        with_fraction(window, 1)
    } else {
        let digits = word(window, 0);
        let whole = leading_digits(digits);
        if whole < 8 && window[whole] == b'.' {
            with_fraction(window, whole)
        } else {
            finish(window, digits, whole, 0, whole)
        }
    }
}

/// With a point after `whole` bytes, at most 7.
#[inline(always)]
fn with_fraction(window: &[u8; WINDOW], whole: usize) -> Option<(f32, usize)> {
    let fraction = word(window, whole + 1);
    let places = leading_digits(fraction);
    // The digits without the point between them.
    let integer = word(window, 0) & ((1 << (8 * whole)) - 1);
    let digits = integer | fraction << (8 * whole);
    finish(window, digits, whole + places, places, whole + 1 + places)
}

/// The number of the `count` lowest bytes of `digits`, if digits they are, `places` of them after
/// the point; `end` is where the exponent or the number's end should be.
#[inline(always)]
fn finish(
    window: &[u8; WINDOW],
    digits: u64,
    count: usize,
    places: usize,
    end: usize,
) -> Option<(f32, usize)> {
    if !(1..=8).contains(&count) {
        return None;
    }
    let digits = eight_digits((digits ^ repeat(b'0')) << (64 - 8 * count))?;
    if Class::of(window[end]) == Class::Other {
        return with_exponent(window, digits, places, end);
    }
    Some((scaled(digits, -(places as i32)) as f32, end))
}

fn with_exponent(
    window: &[u8; WINDOW],
    digits: u64,
    places: usize,
    mut end: usize,
) -> Option<(f32, usize)> {
    if window[end] | 0x20 != b'e' {
        return None;
    }
    let minus = window[end + 1] == b'-';
    end += 1 + usize::from(minus || window[end + 1] == b'+');
    let digit =
        |at: usize| Some(i32::from(window[at]) - i32::from(b'0')).filter(|d| (0..=9).contains(d));
    let mut power = digit(end)?;
    end += 1;
    if let Some(digit) = digit(end) {
        power = 10 * power + digit;
        end += 1;
    }
    let exponent = if minus { -power } else { power } - places as i32;
    let usual =
        Class::of(window[end]) != Class::Other && exponent.unsigned_abs() < POWERS.len() as u32;
    usual.then(|| (scaled(digits, exponent) as f32, end))
}

#[inline(always)]
fn word(window: &[u8; WINDOW], at: usize) -> u64 {
    let bytes = window[at..].first_chunk().copied();
    u64::from_le_bytes(bytes.unwrap_or_default())
}

const fn repeat(byte: u8) -> u64 {
    u64::from_le_bytes([byte; 8])
}

/// How many of the eight bytes come before the first that cannot be a digit; `:;<=>?` can.
///
/// Where the next number starts hangs on this: what is longer here, every number waits for.
#[inline(always)]
fn leading_digits(word: u64) -> usize {
    let other = (word ^ repeat(b'0')) & repeat(0xf0);
    (other.trailing_zeros() / 8) as usize
}

/// The number of eight decimal places, the highest in the lowest byte; `None` if one exceeds 9.
#[inline(always)]
fn eight_digits(ones: u64) -> Option<u64> {
    let from_10 = (ones & repeat(0x0f)) + repeat(6);
    if (ones | from_10) & repeat(0xf0) != 0 {
        return None;
    }
    let pairs = (ones * 10 + (ones >> 8)) & 0x00ff_00ff_00ff_00ff;
    let fours = (pairs * 100 + (pairs >> 16)) & 0x0000_ffff_0000_ffff;
    Some((fours * 10_000 + (fours >> 32)) & 0xffff_ffff)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Option<(f32, usize)> {
        let mut window = [b'\n'; WINDOW];
        window[..text.len()].copy_from_slice(text.as_bytes());
        short_decimal(&window)
    }

    #[test]
    fn usual_forms() {
        for text in [
            "0",
            "7",
            "12345678",
            "0.5",
            ".5",
            "3.",
            "12.5",
            ".01234567",
            "1234.5678",
            "1234567.8",
            "1e5",
            "1.234e-05",
            "1.e+2",
            ".5E9",
            "12345678e22",
            "00000000",
            "9.999999",
            "1e-22",
        ] {
            let value = text.parse::<f64>().unwrap() as f32;
            assert_eq!(read(text), Some((value, text.len())), "{text}");
            for after in [" 1", ",", "}", "{", "\t", "\r"] {
                assert_eq!(
                    read(&format!("{text}{after}")),
                    Some((value, text.len())),
                    "{text}{after}"
                );
            }
        }
    }

    #[test]
    fn small_integers_between_blanks() {
        for n in 0..20_000_u32 {
            let text =
                format!("{}{n}{} ", [' ', '\n'][n as usize % 2], ['\t', ' '][n as usize % 3 / 2]);
            let bytes = format!("{text:8}").into_bytes();
            let expected = (n < 10_000).then_some((n as f32, text.len() - 2));
            assert_eq!(blank_and_integer(bytes.first_chunk().unwrap()), expected, "{n}");
        }
        for text in [
            "0 1     ", " .5     ", " 1.5    ", " 12,    ", " 1}     ", " 1:     ", "  1     ",
            " -1     ",
        ] {
            assert_eq!(blank_and_integer(text.as_bytes().first_chunk().unwrap()), None, "{text}");
        }
    }

    #[test]
    fn fractions_behind_a_blank() {
        let read = |text: &str| {
            let mut bytes = [b'\n'; WINDOW];
            bytes[..text.len()].copy_from_slice(text.as_bytes());
            blank_and_fraction(&bytes)
        };
        for digits in ["5", "01", "123", "0000", "98765", "123456", "9999999"] {
            let value = format!(".{digits}").parse::<f64>().unwrap() as f32;
            for (before, after) in [(' ', " .5"), ('\n', "}"), ('\t', ","), ('\r', "\n")] {
                let text = format!("{before}.{digits}{after}");
                assert_eq!(read(&text), Some((value, 2 + digits.len())), "{text:?}");
            }
        }
        for text in
            [" .", " . 5", " .12345678", " .5e1", " 1.5", "..5", " .5.", " .5:", " .:5", ",.5"]
        {
            assert_eq!(read(text), None, "{text}");
        }
    }

    #[test]
    fn other_forms_are_left_alone() {
        for text in [
            "",
            ".",
            "-1",
            "+1",
            "e5",
            ".e5",
            "1e",
            "1e+",
            "1e-x",
            "1e100",
            "1e023",
            "1e23",
            ".1e-22",
            "123456789",
            "1.23456789",
            ".123456789",
            "12345678.9",
            "1x",
            "1.2.3",
            "1-2",
            "0x1",
            "1e5e",
            "nan",
            "\u{661}",
            "/5",
            ":",
            "1/",
            "1:",
            "/.5",
            ":.5",
            "{",
            "12345678.",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
    }

    #[test]
    fn every_byte_in_every_place() {
        for text in ["12345.67", "1.234567", "12.5e-7"] {
            let mut window = [b'\n'; WINDOW];
            window[..text.len()].copy_from_slice(text.as_bytes());
            for place in 0..text.len() {
                let kept = window[place];
                for byte in 0..=u8::MAX {
                    window[place] = byte;
                    let end = window.iter().position(|b| Class::of(*b) != Class::Other).unwrap();
                    let spelt = std::str::from_utf8(&window[..end]).ok();
                    let unsigned = spelt.filter(|t| !t.starts_with(['+', '-']));
                    let value = unsigned.and_then(|t| t.parse::<f64>().ok());
                    // Two digits of exponent can be too much.
                    let expected = value.filter(|v| *v < 1e22).map(|v| (v as f32, end));
                    assert_eq!(short_decimal(&window), expected, "{byte:#x} at {place} of {text}");
                }
                window[place] = kept;
            }
        }
    }
}
