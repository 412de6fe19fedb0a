//! Bytes of a file → text: as its first bytes show, as it declares, else UTF-8, mended where it is not.

use std::borrow::Cow;

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE};

use super::report::Report;
use crate::encoding::{MENDED, mend, wide};
use crate::{Error, Result};

/// Decodes a file; the byte order mark is dropped.
///
/// What is valid UTF-8 is UTF-8, whatever it declares: declarations are copied more often than obeyed. Bytes that are
/// not are what the declaration says, or Windows-1252; each guess is a warning.
/// Errors: format: bytes that are no text in the encoding, with the first offset.
pub(crate) fn decode<'b>(bytes: &'b [u8], report: &mut Report) -> Result<Cow<'b, str>> {
    if let Some((utf16, mark)) = wide(bytes) {
        return utf16
            .decode_without_bom_handling_and_without_replacement(&bytes[mark..])
            .ok_or_else(|| Error::format("expected text, found bytes that are not valid UTF-16"));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let declared = declared(bytes);
    let at = match std::str::from_utf8(bytes) {
        Ok(text) => {
            let ascii = |e: &'static Encoding| bytes.is_ascii() && e.is_ascii_compatible();
            if let Some(other) = declared.filter(|e| *e != UTF_8 && !ascii(e)) {
                let text = format!("declares {}, found UTF-8: taken as UTF-8", other.name());
                report.warn("encoding", "line 1".to_owned(), text);
            }
            return Ok(Cow::Borrowed(text));
        }
        Err(e) => e.valid_up_to(),
    };
    let declared = declared.filter(|e| ![UTF_8, UTF_16BE, UTF_16LE].contains(e));
    if let Some(encoding) = declared {
        return encoding.decode_without_bom_handling_and_without_replacement(bytes).ok_or_else(
            || {
                let name = encoding.name();
                Error::format(format!(
                    "expected text in {name} as the file declares, found other bytes"
                ))
            },
        );
    }
    let text = mend(bytes).map_err(|at| {
        let byte = bytes[at];
        Error::format(format!(
            "expected UTF-8 text, found binary data: byte {byte:#04x} at offset {at}"
        ))
    })?;
    let line = 1 + bytes[..at].iter().filter(|&&b| b == b'\n').count();
    report.warn("encoding", format!("line {line}"), MENDED);
    Ok(Cow::Owned(text))
}

/// The encoding that the XML declaration names, if it is one of those of the web.
fn declared(bytes: &[u8]) -> Option<&'static Encoding> {
    let head = bytes[..bytes.len().min(512)].to_ascii_lowercase();
    let head = String::from_utf8_lossy(&head);
    let declaration = head.split_once("<?xml")?.1.split_once("?>")?.0;
    let value = declaration.split_once("encoding")?.1.trim_start().strip_prefix('=')?.trim_start();
    let label = value.get(1..)?.split(['"', '\'']).next()?;
    Encoding::for_label(label.trim().as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8]) -> (String, Vec<String>) {
        let mut report = Report::new(9);
        let text = decode(bytes, &mut report).unwrap().into_owned();
        (text, report.finish().unwrap().iter().map(ToString::to_string).collect())
    }

    fn refused(bytes: &[u8]) -> String {
        decode(bytes, &mut Report::new(9)).unwrap_err().to_string()
    }

    #[test]
    fn marks_decide() {
        for bytes in [
            &b"\xef\xbb\xbf<a/>"[..],
            b"\xff\xfe<\0a\0/\0>\0",
            b"\xfe\xff\0<\0a\0/\0>",
            b"<\0a\0/\0>\0",
        ] {
            assert_eq!(text(bytes), ("<a/>".to_owned(), vec![]));
        }
        assert!(refused(b"\xff\xfe<\0a").contains("UTF-16"));
        assert!(refused(b"\xff\xfe\0\xd8<\0").contains("UTF-16"));
    }

    #[test]
    fn declarations_are_obeyed_where_the_bytes_are_not_utf8() {
        for (label, byte, character) in [
            ("ISO-8859-1", 0xe4, 'ä'),
            ("latin1", 0xe4, 'ä'),
            ("windows-1252", 0x80, '€'),
            ("ISO-8859-15", 0xa4, '€'),
            ("windows-1251", 0xcf, 'П'),
        ] {
            for quote in ['"', '\''] {
                let mut bytes =
                    format!("<?xml version='1.0' encoding = {quote}{label}{quote}?>").into_bytes();
                bytes.push(byte);
                let (text, warnings) = text(&bytes);
                assert_eq!((text.chars().last(), warnings), (Some(character), vec![]), "{label}");
            }
        }
        assert!(
            refused(b"<?xml encoding='Shift_JIS'?>\x81").contains("Shift_JIS as the file declares")
        );
    }

    #[test]
    fn undeclared_and_wrongly_declared_bytes_are_windows_1252_and_told() {
        for head in [
            "",
            "<?xml version='1.0'?>",
            "<?xml encoding='UTF-8'?>",
            "<?xml encoding='utf-16'?>",
            "<?xml encoding='x'?>",
        ] {
            let mut bytes = format!("{head}\n<a>\nVerre d").into_bytes();
            bytes.extend(b"\xe9poli</a>");
            let (text, warnings) = text(&bytes);
            assert!(text.ends_with("Verre dépoli</a>"), "{text}");
            assert_eq!(warnings, ["line 3: not UTF-8: taken as Windows-1252 (Latin-1)"]);
        }
    }

    #[test]
    fn utf8_is_utf8_whatever_it_declares() {
        let (read, warnings) = text("<?xml encoding='ISO-8859-1'?>é".as_bytes());
        assert!(read.ends_with('é'));
        assert_eq!(warnings, ["line 1: declares windows-1252, found UTF-8: taken as UTF-8"]);
        assert_eq!(text(b"<?xml encoding='ISO-8859-1'?>e").1.len(), 0);
        assert_eq!(text(b"<?xml encoding='utf-16'?>e").1.len(), 1);
    }

    #[test]
    fn binary_data_are_no_text() {
        assert_eq!(
            refused(b"ab\x07\x9f"),
            "expected UTF-8 text, found binary data: byte 0x07 at offset 2"
        );
    }
}
