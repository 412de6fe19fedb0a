//! Malformed and tricky files: each gets its verdict, quickly, with a place, without panic.

mod golden;

use std::time::{Duration, Instant};

use bsdfkit::xml::{Limits, Warning, from_bytes, read, read_with};
use bsdfkit::{Bsdf, ErrorClass, Result};

/// What `expect.json` wants of a file.
fn judge(name: &str, verdict: &str, read: &Result<(Bsdf, Vec<Warning>)>) -> Result<(), String> {
    let right = match (verdict, read) {
        ("error", read) => read.is_err(),
        ("error/warn", Ok((_, warnings))) => !warnings.is_empty(),
        ("load", read) | ("load (schema says whitespace collapses)", read) => read.is_ok(),
        ("error/warn", Err(_))
        | (
            "error or load"
            | "load or error"
            | "load or clear message"
            | "load with own basis (or error)",
            _,
        ) => true,
        _ => return Err(format!("{name}: unknown verdict {verdict:?}")),
    };
    if let Err(e) = read {
        let text = e.to_string();
        if text.len() > 4000 || text.chars().any(|c| c.is_control() && c != '\n') {
            return Err(format!("{name}: message is not fit to print: {text:?}"));
        }
        if !matches!(e.class(), ErrorClass::Format | ErrorClass::Limit) {
            return Err(format!("{name}: {:?} error: {text}", e.class()));
        }
    }
    match read {
        _ if right => Ok(()),
        Ok((_, warnings)) => Err(format!("{name}: expected {verdict}, loaded; {warnings:?}")),
        Err(e) => Err(format!("{name}: expected {verdict}, found error {e}")),
    }
}

fn wrap(structure: &str, data: &str) -> String {
    format!(
        "<WindowElement><Optical><Layer><DataDefinition>\
         <IncidentDataStructure>{structure}</IncidentDataStructure></DataDefinition>\
         <WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock>\
         <WavelengthDataDirection>Reflection Back</WavelengthDataDirection>\
         <ColumnAngleBasis>LBNL/Klems Quarter</ColumnAngleBasis>\
         <RowAngleBasis>LBNL/Klems Quarter</RowAngleBasis>\
         <ScatteringData>{data}</ScatteringData></WavelengthDataBlock></WavelengthData>\
         </Layer></Optical></WindowElement>"
    )
}

/// The inputs too large to keep as files.
fn large() -> Vec<(&'static str, &'static str, String)> {
    let good = wrap("Columns", &".05 ".repeat(41 * 41));
    let grid = format!("{{ {} }}", "0 1 ".repeat(1 << 23));
    vec![
        ("64^4 grid", "load", wrap("TensorTree4", &grid)),
        ("deep tree", "error", wrap("TensorTree3", &("{".repeat(300_000) + &"}".repeat(300_000)))),
        (
            "many siblings",
            "load",
            good.replace("<Optical>", &("<Junk/>".repeat(600_000) + "<Optical>")),
        ),
        (
            "deep elements",
            "error or load",
            good.replace(
                "<Optical>",
                &("<J>".repeat(300_000) + &"</J>".repeat(300_000) + "<Optical>"),
            ),
        ),
    ]
}

#[test]
fn every_bad_file_gets_its_verdict_in_time() {
    let verdicts = golden::json("badxml/expect.json");
    let mut wrong = Vec::new();
    let mut count = 0;
    let mut check = |name: &str, verdict: &str, bytes: &[u8]| {
        let start = Instant::now();
        let read = from_bytes(bytes, &Limits::default());
        if start.elapsed() > Duration::from_secs(5) {
            wrong.push(format!("{name}: took {:?}", start.elapsed()));
        }
        wrong.extend(judge(name, verdict, &read).err());
        count += 1;
    };
    for (name, verdict) in verdicts.as_object().unwrap() {
        // The four largest are made below.
        let large = ["31_", "41_", "42_", "43_"].iter().any(|p| name.starts_with(p));
        if !large {
            let bytes = std::fs::read(golden::path(&format!("badxml/{name}"))).unwrap();
            check(name, verdict.as_str().unwrap(), &bytes);
        }
    }
    for (name, verdict, text) in large() {
        check(name, verdict, text.as_bytes());
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_eq!(count, 65);
}

#[test]
fn a_fault_names_line_path_expected_and_found() {
    let message =
        |name: &str| read(golden::path(&format!("badxml/{name}"))).unwrap_err().to_string();
    let few = message("09_too_few_values.xml");
    let place = "09_too_few_values.xml: line 10: Optical/Layer/WavelengthData/WavelengthDataBlock/ScatteringData";
    assert!(few.contains(place), "{few}");
    assert!(
        few.ends_with("expected 1681 values, found 1581")
            || few.contains("expected 1681 values, found"),
        "{few}"
    );
    let word = message("11_nan_matrix.xml");
    assert!(word.contains("expected a number, found \"nan\""), "{word}");
    let unit = message("56_unknown_unit.xml");
    assert!(unit.contains("line 7: Optical/Layer/Material/Width: expected unit"), "{unit}");
    let bomb = message("40_entity_bomb.xml");
    assert!(bomb.contains("entity &a11;"), "{bomb}");
}

#[test]
fn all_faults_of_a_file_are_listed() {
    let text = wrap("Columns", "1 2 x").replace(
        "<DataDefinition>",
        "<Material><Width unit=\"ell\">1</Width><Height>tall</Height></Material><DataDefinition>",
    );
    let message = from_bytes(text.as_bytes(), &Limits::default()).unwrap_err().to_string();
    assert!(message.starts_with("3 faults\n"), "{message}");
    for part in ["Width: expected unit", "\"tall\"", "found \"x\""] {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn questionable_data_are_warned_of() {
    let warnings = |structure, data: &str| {
        let text = wrap(structure, data);
        let (_, warnings) = from_bytes(text.as_bytes(), &Limits::default()).unwrap();
        warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
    };
    assert_eq!(warnings("Rows", &".1 ".repeat(1681)), "");
    assert!(warnings("Rows", &"0 ".repeat(1681)).contains("Reflection Back: no light"));
    assert!(warnings("Rows", &(".1 ".repeat(1680) + "-2")).contains("1 negative values read as 0"));
    let bright = warnings("TensorTree4", "{.4}");
    assert!(bright.contains("Optical/Layer: Reflection Back: up to 125.7 %"), "{bright}");
}

#[test]
fn what_is_no_file_is_an_io_error() {
    let folder = std::env::temp_dir();
    let long = "x".repeat(5000);
    for path in [folder.as_path(), "no/such/file.xml".as_ref(), long.as_ref()] {
        let error = read(path).unwrap_err();
        assert_eq!(error.class(), ErrorClass::Io, "{error}");
        assert!(error.to_string().len() < 500);
    }
    assert!(read("no/such/file.xml").unwrap_err().to_string().contains("no/such/file.xml"));
}

#[test]
fn each_limit_is_refused_as_such() {
    let small = golden::path("xml/chk.xml");
    let limits = |change: fn(&mut Limits)| {
        let mut limits = Limits::default();
        change(&mut limits);
        read_with(&small, &limits).unwrap_err()
    };
    for error in [
        limits(|l| l.file_bytes = 1000),
        limits(|l| l.elements = 5),
        limits(|l| l.element_depth = 3),
        limits(|l| l.values = 100),
    ] {
        assert_eq!(error.class(), ErrorClass::Limit, "{error}");
    }
    let tree = wrap("TensorTree3", &format!("{{{}}}", ".1 ".repeat(64)));
    let error = from_bytes(tree.as_bytes(), &Limits { tree_depth: 1, ..Limits::default() });
    assert_eq!(error.unwrap_err().class(), ErrorClass::Limit);
}

#[test]
fn an_html_page_is_recognised() {
    let page = b"<!DOCTYPE html><html><body>404</body></html>";
    let message = from_bytes(page, &Limits::default()).unwrap_err().to_string();
    assert!(message.contains("expected root element WindowElement, found html"), "{message}");
}
