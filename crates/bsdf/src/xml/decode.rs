//! Bytes of a file → text: UTF-8, UTF-16 with byte order mark, Latin-1 when declared.

use std::borrow::Cow;

use crate::{Error, Result};

/// Decodes a file; the byte order mark is dropped.
///
/// Errors: format: bytes that are none of the three encodings, with the first offset.
pub(crate) fn decode(bytes: &[u8]) -> Result<Cow<'_, str>> {
    let wide = |unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|b| unit([b[0], b[1]])).collect();
        String::from_utf16(&units).map(Cow::Owned).ok().filter(|_| bytes.len().is_multiple_of(2))
    };
    match bytes {
        [0xff, 0xfe, ..] => {
            return wide(u16::from_le_bytes).ok_or_else(|| Error::format("not valid UTF-16"));
        }
        [0xfe, 0xff, ..] => {
            return wide(u16::from_be_bytes).ok_or_else(|| Error::format("not valid UTF-16"));
        }
        _ => {}
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => Ok(Cow::Borrowed(text)),
        Err(_) if declares_latin1(bytes) => {
            Ok(Cow::Owned(bytes.iter().map(|&b| char::from(b)).collect()))
        }
        Err(e) => {
            let at = e.valid_up_to();
            Err(Error::format(format!("not UTF-8 text: byte {:#04x} at offset {at}", bytes[at])))
        }
    }
}

/// Whether the XML declaration names ISO-8859-1, or its superset windows-1252.
fn declares_latin1(bytes: &[u8]) -> bool {
    let head = bytes[..bytes.len().min(200)].to_ascii_lowercase();
    let head = String::from_utf8_lossy(&head);
    let declaration = head.split("?>").next().unwrap_or_default();
    ["iso-8859-1", "latin1", "latin-1", "windows-1252"].iter().any(|n| declaration.contains(n))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings() {
        assert_eq!(decode(b"\xef\xbb\xbf<a/>").unwrap(), "<a/>");
        assert_eq!(decode(b"\xff\xfe<\0a\0").unwrap(), "<a");
        assert_eq!(decode(b"\xfe\xff\0<\0a").unwrap(), "<a");
        assert!(decode(b"\xff\xfe<\0a").is_err());
        assert_eq!(decode(b"<?xml encoding='ISO-8859-1'?>\xe4").unwrap().chars().last(), Some('ä'));
        let message = decode(b"abc\x80").unwrap_err().to_string();
        assert_eq!(message, "not UTF-8 text: byte 0x80 at offset 3");
    }
}
