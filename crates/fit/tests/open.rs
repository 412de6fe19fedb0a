//! Files are told apart by their content, whatever their names; each reader complains of its own.

use std::fs;
use std::path::{Path, PathBuf};

use bsdfkit::{DVec3, ErrorClass, container, xml};
use bsdfkit_fit::interpolant::{Encoding, Interpolant};
use bsdfkit_fit::open::{Access, Content, Opened, open};
use bsdfkit_measure::ReadOptions;

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden").join(name)
}

/// A Mountain file: one incidence, a few points.
const POINTS: &str = "#format: theta phi BSDF\n#intheta 20\n#inphi 0\n\
    10 0 0.5\n20 90 0.4\n30 180 0.3\n40 270 0.2\n50 45 0.1\n60 135 0.1\n";

fn file(folder: &Path, name: &str, content: &[u8]) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, content).unwrap();
    path
}

/// One file of each kind under a name that says nothing, and under one that misleads.
#[test]
fn content_decides() {
    let folder = tempfile::tempdir().unwrap();
    let sir = fs::read_dir(golden("sir")).unwrap().map(|entry| entry.unwrap().path());
    let sir = sir.filter(|p| p.extension().is_some_and(|s| s == "sir")).min().unwrap();
    let tree = fs::read(golden("xml/t4_tf.xml")).unwrap();
    let text = String::from_utf8(tree.clone()).unwrap();
    let wide: Vec<u8> =
        [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let compiled = container::to_bytes(&xml::read(golden("xml/t4_tf.xml")).unwrap()).unwrap();
    let interpolant = Interpolant { name: Some("nothing".to_owned()), ..Interpolant::default() };
    let interpolant = interpolant.to_bytes(Encoding::default()).unwrap();
    let blank = [b"\n".repeat(400), tree.clone()].concat();
    for (content, bytes) in [
        (Content::Xml, &tree),
        (Content::Xml, &wide),
        (Content::Xml, &blank),
        (Content::Compiled, &compiled),
        (Content::Interpolant, &interpolant),
        (Content::Sir, &fs::read(sir).unwrap()),
        (Content::Measurement, &POINTS.as_bytes().to_vec()),
    ] {
        for name in ["file", "file.xml", "file.safetensors", "file.sir", "file.txt"] {
            // What has no mark of its own is what its name says.
            if content == Content::Measurement && name != "file" && name != "file.txt" {
                continue;
            }
            let path = file(folder.path(), name, bytes);
            assert_eq!(Content::of(&path).unwrap(), content, "{name}");
            for access in [Access::Checked, Access::InPlace] {
                match open(&path, access) {
                    Ok((found, Opened::Bsdf(bsdf, _))) => {
                        assert_eq!(found, content);
                        assert!(matches!(content, Content::Xml | Content::Compiled), "{content:?}");
                        assert!(bsdf.eval(DVec3::Z, DVec3::NEG_Z) > 0.0);
                    }
                    Ok((found, Opened::Interpolant(_))) => {
                        assert_eq!(found, content);
                        assert!(matches!(content, Content::Interpolant | Content::Sir));
                    }
                    Err(error) => {
                        assert_eq!(content, Content::Measurement, "{error}");
                        assert_eq!(error.class(), ErrorClass::Argument);
                        assert!(error.to_string().contains("found a measurement"), "{error}");
                    }
                }
            }
        }
    }
    assert_eq!(Content::of(folder.path()).unwrap(), Content::Measurement);
}

#[test]
fn rubbish_is_blamed_on_the_file_by_the_reader_that_its_name_calls() {
    let folder = tempfile::tempdir().unwrap();
    let other = br#"{"a":{"dtype":"U8","shape":[1],"data_offsets":[0,1]}}"#;
    let other = [&(other.len() as u64).to_le_bytes(), &other[..], b"x"].concat();
    let rubbish = b"\x07\x9frubbish".to_vec();
    for (name, bytes, words) in [
        ("empty.xml", Vec::new(), "expected XML"),
        ("rubbish.xml", rubbish.clone(), "UTF-8"),
        ("html.xml", b"<html><body/></html>".to_vec(), "web page"),
        ("other.xml", b"<scene/>".to_vec(), "WindowElement"),
        ("empty.safetensors", Vec::new(), "safetensors"),
        ("rubbish.safetensors", rubbish.clone(), "safetensors"),
        ("other.safetensors", other.clone(), "bsdfkit"),
        ("other", other, "bsdfkit"),
        ("rubbish.sir", rubbish.clone(), "header"),
        ("empty.txt", Vec::new(), "empty"),
        ("rubbish.txt", rubbish, "expected"),
    ] {
        let path = file(folder.path(), name, &bytes);
        let error = open(&path, Access::Checked).unwrap_err();
        assert_eq!(error.class(), ErrorClass::Format, "{error}");
        assert!(error.to_string().contains(name), "{error}");
        assert!(error.to_string().contains(words), "{words}: {error}");
    }
    let missing = open(&folder.path().join("missing.xml"), Access::InPlace).unwrap_err();
    assert_eq!(missing.class(), ErrorClass::Io);
    assert!(missing.to_string().contains("missing.xml: "), "{missing}");
}

/// As measurements, too, by whatever name.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.txt");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    for path in [pipe.as_path(), Path::new("/dev/zero")] {
        let of_points = bsdfkit_measure::read(&[path.to_owned()], &ReadOptions::default());
        for error in [
            open(path, Access::Checked).map(|_| ()).unwrap_err(),
            Interpolant::open(path).map(|_| ()).unwrap_err(),
            Interpolant::read_sir(&[path]).map(|_| ()).unwrap_err(),
            of_points.map(|_| ()).unwrap_err(),
        ] {
            assert_eq!(error.class(), ErrorClass::Argument, "{error}");
            assert!(error.to_string().contains("expected a"), "{error}");
        }
    }
}
