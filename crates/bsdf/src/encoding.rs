//! Which characters the bytes of a text file mean.
//!
//! A file is UTF-8 unless something says otherwise: the mark or the zeros of UTF-16 at its start, or bytes that no UTF-8
//! has. These are taken as Windows-1252, the superset of Latin-1 in which programs of instruments write names.

use encoding_rs::{Encoding, UTF_16BE, UTF_16LE, WINDOWS_1252};

/// What [`mend`] does, for remarks.
pub const MENDED: &str = "not UTF-8: taken as Windows-1252 (Latin-1)";

/// UTF-16 that starts with `head`, with the length of its mark (0 or 2); `None` for text of one byte a character.
///
/// Without a mark: two ASCII characters with their zeros.
pub fn wide(head: &[u8]) -> Option<(&'static Encoding, usize)> {
    let ascii = |b: u8| b.is_ascii_graphic() || b.is_ascii_whitespace();
    match *head {
        [0xff, 0xfe, ..] => Some((UTF_16LE, 2)),
        [0xfe, 0xff, ..] => Some((UTF_16BE, 2)),
        [a, 0, b, 0, ..] if ascii(a) && ascii(b) => Some((UTF_16LE, 0)),
        [0, a, 0, b, ..] if ascii(a) && ascii(b) => Some((UTF_16BE, 0)),
        _ => None,
    }
}

/// The text of bytes that are not all UTF-8: what is not is taken as Windows-1252.
///
/// Errors: the offset of the first control character: no text, but binary data.
pub fn mend(bytes: &[u8]) -> Result<String, usize> {
    let control = |b: &u8| *b < b' ' && !matches!(b, b'\t'..=b'\r' | 0x1a);
    if let Some(at) = bytes.iter().position(control) {
        return Err(at);
    }
    let mut text = String::with_capacity(bytes.len() + bytes.len() / 8);
    for chunk in bytes.utf8_chunks() {
        text += chunk.valid();
        text += &WINDOWS_1252.decode_without_bom_handling(chunk.invalid()).0;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn utf16_with_and_without_mark() {
        assert_eq!(wide(b"\xff\xfe<\0"), Some((UTF_16LE, 2)));
        assert_eq!(wide(b"\xfe\xff\0<"), Some((UTF_16BE, 2)));
        assert_eq!(wide(b"#\0i\0"), Some((UTF_16LE, 0)));
        assert_eq!(wide(b"\0#\0i"), Some((UTF_16BE, 0)));
        for narrow in [&b"#int"[..], b"", b"\xff", b"Z\0\0\0", b"\0\0\0\0", b"\xef\xbb\xbf#"] {
            assert_eq!(wide(narrow), None, "{narrow:?}");
        }
    }

    #[test]
    fn lines_of_two_encodings_are_both_right() {
        assert_eq!(
            mend(b"Verre d\xe9poli\nverre d\xc3\xa9poli\n").unwrap(),
            "Verre dépoli\nverre dépoli\n"
        );
        assert_eq!(mend(b"\x80 5 \x96 10\xb0").unwrap(), "€ 5 – 10°");
        assert_eq!(mend(b"ab\x07\x9f"), Err(2));
    }
}
