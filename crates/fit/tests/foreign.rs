//! Files of formats that are not read are named, with what to do, whichever way they come in.

use std::path::PathBuf;

use bsdfkit::{Bsdf, ErrorClass};
use bsdfkit_fit::open::{Access, Content, open};
use bsdfkit_measure::{ReadOptions, read};

const ZEMAX: &str = "# c\nSource Measured\nSymmetry PlaneSymmetrical\nSpectralContent Monochrome\nScatterType BRDF\n\
    SampleRotation 1\n0\nAngleOfIncidence 1\n0\nScatterAzimuth 2\n0 180\nScatterRadial 2\n0 10\n\nMonochrome\nDataBegin\n\
    TIS 0.1\n0.1 0.1\n0.1 0.1\nDataEnd\n";

/// Measurements, where a BSDF may be expected: (content, what it is called).
fn measured() -> Vec<(Vec<u8>, &'static str)> {
    let text = |text: &str| text.as_bytes().to_vec();
    let with = |start: &[u8]| [start, b"\0\0\x01\x02rest"].concat();
    let merl: Vec<u8> = [90u32, 90, 180, 0, 0].into_iter().flat_map(u32::to_le_bytes).collect();
    vec![
        (text(ZEMAX), "Zemax BSDF"),
        (
            text(
                &ZEMAX
                    .replace("0\nAngleOfIncidence 1\n0\n", "")
                    .replace("TIS", "AOI 0\nPOI 0\nSide Front\nTIS"),
            ),
            "LightTools",
        ),
        (text(&ZEMAX.replace('\n', "\r")), "Zemax BSDF"),
        (text(&format!("{}{ZEMAX}", "# a long preface\n".repeat(900))), "Zemax BSDF"),
        (merl, "MERL"),
        (with(b"tensor_file\0\x01\0"), "RGL tensor file"),
        (
            text("FILENAME a\nNUM_POINTS 2\nVARS=theta_i,phi_i,theta_s,phi_s,BRDF\n0,0,0,0,1\n"),
            "ASTM E1392",
        ),
        (text("!!EDS10 0-0\tRPC Photonics\n!!BSDF Data\n0.0\t0.0\n0 0 23.9\n"), "RPC Photonics"),
        (text("# Cornell\n# num wls\n31\n"), "Cornell"),
        (text("{\"metadata\": {\"type\": \"BRDF\"},\n\"data\": {}}"), "BiRD"),
        (text("{\"data\": {\"BRDF\": {\"unit\": \"1/sr\", \"values\": [1]}}}"), "BiRD"),
        (text("#SAMPLE \"a\"\n#DIM 3 1\n#PARAM_IN ISOTROPIC_TL_TV_PROJ_DPHI\n0.2 0 0 1\n"), "ALTA"),
    ]
}

/// The crate that only reads BSDFs says what it is; what may hold one is looked into.
#[test]
fn measurements_are_named_where_a_bsdf_is_expected() {
    let folder = tempfile::tempdir().unwrap();
    for (bytes, name) in measured() {
        let path = folder.path().join("file.xml");
        std::fs::write(&path, &bytes).unwrap();
        assert_eq!(Content::of(&path).unwrap(), Content::Measurement, "{name}");
        for message in [
            Bsdf::open(&path).unwrap_err().to_string(),
            Bsdf::from_bytes(&bytes).unwrap_err().to_string(),
        ] {
            assert!(message.contains("a measurement, where a BSDF is expected"), "{message}");
            assert!(message.contains(name) && message.contains("`bsdf fit`"), "{name}: {message}");
        }
    }
}

/// (content, what it is called, what to do).
fn foreign() -> Vec<(Vec<u8>, &'static str, &'static str)> {
    let table = "export it as a table with the columns theta_i";
    let text = |text: &str| text.as_bytes().to_vec();
    let with = |start: &[u8]| [start, b"\0\0\x01\x02rest"].concat();
    let tar = [vec![b'a'; 257], b"ustar\x0000".to_vec()].concat();
    vec![
        (text("Source Measured\nTypeSym ASymmetrical\nTypeColorModel BW\n"), "Integra DDR", table),
        (text("VERSION 0.2\nPARAM_TYPE SpecularCoordinateSystem\n"), "SSDD", table),
        (text("OPTIS - Brdf file v7.0\n0\n"), "OPTIS", table),
        (text("IESNA:LM-63-2002\n[TEST] 1\n"), "IES", "luminaire"),
        (text("Lamp of somebody\nTILT=NONE\n1 1000 1\n"), "IES", "luminaire"),
        (
            text("Somebody\r\n1\r\n0\r\n24\r\n15\r\n37\r\n2,5\r\n\r\nA lamp\r\n"),
            "EULUMDAT",
            "luminaire",
        ),
        (with(b"\x89HDF\r\n\x1a\n"), "HDF5", table),
        (with(b"MATLAB 5.0 MAT-file, Platform"), "MATLAB", table),
        (with(b"\x93NUMPY\x01"), "NumPy", table),
        (text("{\"a\": [1, 2]}"), "JSON", table),
        (
            text("{\"data\": [{\"dataPoints\": [{\"incidence\": {}, \"emergence\": {}}]}]}"),
            "BED-JSON",
            "a catalogue reads it beside a BSDF",
        ),
        (
            with(b"PK\x03\x04....[Content_Types].xml....xl/workbook.xml"),
            "Excel",
            "save the sheet as CSV",
        ),
        (with(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"), "Excel", "save the sheet as CSV"),
        (with(b"PK\x03\x04....data.txt"), "ZIP", "unpack it"),
        (with(b"\x1f\x8b\x08"), "gzip", "unpack it"),
        (tar, "tar", "unpack it"),
        (
            text("<!DOCTYPE html>\n<html><body>404</body></html>"),
            "web page",
            "fetch the file itself",
        ),
        (text("\n  <HTML><head/></HTML>"), "web page", "fetch the file itself"),
        (
            text("<?xml version=\"1.0\"?>\n<!DOCTYPE html>\n<html/>"),
            "web page",
            "fetch the file itself",
        ),
        (
            text("version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 3\n"),
            "Git LFS",
            "fetch the file itself",
        ),
        (with(b"%PDF-1.7"), "PDF", "expected a measurement or BSDF"),
        (with(b"\x89PNG\r\n\x1a\n"), "PNG", "expected a measurement or BSDF"),
        (with(b"\xff\xd8\xff\xe0"), "JPEG", "expected a measurement or BSDF"),
        (
            text("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n"),
            "Radiance picture",
            "expected a measurement or BSDF",
        ),
        (
            text("# a room\nvoid plastic red\n0\n0\n5 1 0 0 0 0\n"),
            "Radiance scene",
            "expected a measurement or BSDF",
        ),
        (text("ply\nformat ascii 1.0\n"), "PLY", "expected a measurement or BSDF"),
        (
            text("# Blender\no a\nv 0 0 1\nv 0 1 0\nv 1 0 0\nf 1 2 3\n"),
            "OBJ",
            "expected a measurement or BSDF",
        ),
        (text("solid cube\n facet normal 0 0 1\n"), "STL", "expected a measurement or BSDF"),
    ]
}

/// Whatever the suffix says, and through every way in.
#[test]
fn each_format_is_named_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    for (bytes, name, way_out) in foreign() {
        for suffix in ["txt", "bsdf", "xml", "safetensors", "binary", "sir"] {
            let path = folder.path().join(format!("file.{suffix}"));
            std::fs::write(&path, &bytes).unwrap();
            let paths = [path.clone()];
            for error in [
                Content::of(&path).unwrap_err(),
                open(&path, Access::Checked).unwrap_err(),
                Bsdf::open(&path).unwrap_err(),
                read(&paths, &ReadOptions::default()).unwrap_err(),
            ] {
                assert_eq!(error.class(), ErrorClass::Format, "{error}");
                let message = error.to_string();
                let start = format!("{}: looks like ", path.display());
                assert!(message.starts_with(&start), "{name}: {message}");
                assert!(message.contains(name) && message.contains(way_out), "{name}: {message}");
            }
        }
        let message = Bsdf::from_bytes(&bytes).unwrap_err().to_string();
        assert!(message.starts_with("looks like "), "{name}: {message}");
    }
}

/// What is read is never taken for something else: its comments and geometry may hold anything.
#[test]
fn nothing_that_is_read_is_called_foreign() {
    let golden = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden");
    for folder in ["xml", "sir", "badxml", "compiled"] {
        for entry in golden.join(folder).read_dir().unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|s| s != "json") {
                Content::of(&path).unwrap();
            }
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.xml");
    let mesh = "<MGFblock>\nv a =\np 0 0 0\nf a b c\nvoid plastic\n</MGFblock>";
    for start in ["", "\u{feff}", "stray line\n<?xml version='1.0'?>\n"] {
        std::fs::write(&path, format!("{start}<WindowElement>{mesh}</WindowElement>")).unwrap();
        assert_eq!(Content::of(&path).unwrap(), Content::Xml, "{start}");
    }
    let comments = "#solid aluminium\n#void\n#v 1\n#f 2\n#TILT=NONE\n#ply board\n#NUM_POINTS 3\n";
    std::fs::write(
        &path,
        format!("{comments}#incident_angle 0 0\n#format: theta phi BSDF\n1 1 1\n"),
    )
    .unwrap();
    read(&[path], &ReadOptions { incomplete: true, ..Default::default() }).unwrap();
}

#[test]
fn in_a_folder_they_are_skipped_and_told_but_pages_in_place_of_data_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    put("a.txt", b"#incident_angle 0 0\n#format: theta phi BSDF\n1 1 1\n");
    put("photo.jpg", b"\xff\xd8\xff\xe0\0\0");
    put("report.pdf", b"%PDF-1.7\n\0");
    put("page.html", b"<!DOCTYPE html>\n");
    let options = ReadOptions { incomplete: true, ..Default::default() };
    let m = read(&[folder.path().to_owned()], &options).unwrap().remove(0);
    for part in [
        "photo.jpg: skipped: a JPEG image",
        "report.pdf: skipped: a PDF",
        "page.html: skipped: a web page",
    ] {
        assert!(m.notes.iter().any(|n| n.contains(part)), "{part}: {:?}", m.notes);
    }
    put("t30.txt", b"<!DOCTYPE html>\n");
    let message = read(&[folder.path().to_owned()], &options).unwrap_err().to_string();
    assert!(message.contains("t30.txt: looks like a web page"), "{message}");
}
