//! One XML file in every encoding, declared rightly, wrongly or not at all, reads the same.

use bsdfkit::DVec3;
use bsdfkit::xml::{Limits, from_bytes};

/// A file of one tree whose names have letters outside ASCII, with this declaration.
fn text(declaration: &str) -> String {
    let path = format!("{}/../../tests/golden/xml/t4_tf.xml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let text = text.replace("<Name>n</Name>", "<Name>Verre dépoli n° 3</Name>");
    let text = text.replace("<Manufacturer>m<", "<Manufacturer>Gläser<");
    text.replacen("<?xml version=\"1.0\" encoding=\"UTF-8\"?>", declaration, 1)
}

fn latin1(text: &str) -> Vec<u8> {
    text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect()
}

fn utf16(text: &str, mark: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
    format!("{mark}{text}").encode_utf16().flat_map(bytes).collect()
}

#[test]
fn names_come_out_right_and_guesses_are_warnings() {
    let good = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>";
    let (plain, none) = from_bytes(text(good).as_bytes(), &Limits::default()).unwrap();
    assert_eq!(none, []);
    let none = "<?xml version=\"1.0\"?>";
    let declared = |name: &str| format!("<?xml version='1.0' encoding='{name}'?>");
    let guessed = "line 7: not UTF-8: taken as Windows-1252 (Latin-1)";
    for (bytes, warning) in [
        (text(none).into_bytes(), None),
        (format!("\u{feff}{}", text(good)).into_bytes(), None),
        (text(&declared("utf-16")).into_bytes(), Some("line 1: declares UTF-16LE, found UTF-8")),
        (
            text(&declared("iso-8859-1")).into_bytes(),
            Some("line 1: declares windows-1252, found UTF-8"),
        ),
        (latin1(&text(good)), Some(guessed)),
        (latin1(&text(none)), Some(guessed)),
        (latin1(&text("")), Some("line 7: not UTF-8")),
        (latin1(&text(&declared("Klingon"))), Some(guessed)),
        (latin1(&text(&declared("ISO-8859-1"))), None),
        (latin1(&text(&declared("Windows-1252"))), None),
        (latin1(&text(&declared("ISO-8859-15"))), None),
        (utf16(&text(good), "\u{feff}", u16::to_le_bytes), None),
        (utf16(&text(&declared("UTF-16")), "\u{feff}", u16::to_be_bytes), None),
        (utf16(&text(&declared("UTF-16")), "", u16::to_le_bytes), None),
        (utf16(&text(none), "", u16::to_be_bytes), None),
        (
            latin1(&text(none)).into_iter().map(|b| if b == b'\n' { b'\r' } else { b }).collect(),
            Some("not UTF-8"),
        ),
    ] {
        let (bsdf, warnings) = from_bytes(&bytes, &Limits::default()).unwrap();
        assert_eq!(bsdf.metadata().name, "Verre dépoli n° 3");
        assert_eq!(bsdf.metadata().manufacturer, "Gläser");
        let (wi, wo) = (DVec3::Z, DVec3::NEG_Z);
        assert!(bsdf.eval(wi, wo) > 0.0);
        assert_eq!(bsdf.eval(wi, wo), plain.eval(wi, wo));
        let warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        assert_eq!(warnings.len(), usize::from(warning.is_some()), "{warnings:?}");
        for (found, part) in warnings.iter().zip(warning) {
            assert!(found.contains(part), "{found}");
        }
    }
}
