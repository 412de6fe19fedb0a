//! `bsdf check`: findings, the program they are for, corrected copies.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// Status, standard output, standard error.
fn bsdf(words: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_bsdf")).args(words).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

fn golden(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/badxml");
    folder.join(name).to_str().unwrap().to_owned()
}

fn fresh() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

#[test]
fn a_program_decides_the_verdict() {
    let padded = golden("55_padded_wavelength.xml");
    let (status, told, _) = bsdf(&["check", &padded]);
    assert_eq!(status, 0);
    assert!(told.contains("[padded-label]") && told.contains("black without a word"), "{told}");
    let (status, told, _) = bsdf(&["check", &padded, "--for", "radiance"]);
    assert_eq!(status, 1);
    assert!(told.contains("bad for radiance") && told.contains("fault: line "), "{told}");
    assert!(!told.contains("no-solar"), "{told}");
    let (status, told, _) = bsdf(&["check", &padded, "--for", "mitsuba"]);
    assert_eq!(status, 0, "{told}");
    let (status, _, error) = bsdf(&["check", &padded, "--for", "blender"]);
    assert!(status == 2 && error.contains("honeybee"), "{error}");
}

#[test]
fn findings_are_json_on_request() {
    let (_, told, _) = bsdf(&["check", &golden("55_padded_wavelength.xml"), "--json"]);
    let told: Value = serde_json::from_str(&told).unwrap();
    let all = told["findings"].as_array().unwrap();
    let padded = all.iter().find(|f| f["code"] == "padded-label").unwrap();
    assert_eq!(padded["programs"]["radiance"]["how"], "wrong");
    assert_eq!(padded["mended"], "always");
    assert!(padded["place"].as_str().unwrap().starts_with("line "));
    assert_eq!(told["verdict"], "good");
    let (status, told, error) = bsdf(&["check", &golden("09_too_few_values.xml"), "--json"]);
    let told: Value = serde_json::from_str(&told).unwrap();
    assert_eq!((status, &told["verdict"]), (4, &Value::from("unreadable")));
    assert!(error.contains("expected 1681 values") && told["error"].as_str().is_some(), "{error}");
}

#[test]
fn a_corrected_copy_says_what_changed_and_has_its_verdict() {
    let folder = fresh();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (once, twice) = (path("once.xml"), path("twice.xml"));
    let padded = golden("55_padded_wavelength.xml");
    let (status, told, _) = bsdf(&["check", &padded, "--for", "radiance", "--fix", "-o", &once]);
    assert_eq!(status, 0, "{told}");
    assert!(told.contains("mended: padded-label") && told.contains("white space taken away"));
    let (status, told, _) = bsdf(&["check", &once, "--fix", "-o", &twice]);
    assert!(status == 0 && told.contains("nothing to mend"), "{told}");
    assert_eq!(fs::read(&once).unwrap(), fs::read(&twice).unwrap());
}

#[test]
fn a_copy_for_window_has_all_that_it_wants() {
    let folder = fresh();
    let copy = folder.path().join("copy.xml").to_str().unwrap().to_owned();
    for name in ["00_good_tree.xml", "55_padded_wavelength.xml"] {
        let (status, told, error) =
            bsdf(&["check", &golden(name), "--for", "window", "--fix", "-o", &copy, "--json"]);
        assert_eq!(status, 0, "{told}{error}");
        let told: Value = serde_json::from_str(&told).unwrap();
        assert_eq!(told["verdict"], "good");
        assert!(!told["changes"].as_array().unwrap().is_empty());
        let said = told["said"].to_string();
        assert!(said.contains("Solar is not known: written as Visible"), "{said}");
        let (status, told, _) = bsdf(&["check", &copy, "--for", "window", "--fix", "-o", &copy]);
        assert!(status == 0 && told.contains("nothing to mend"), "{told}");
    }
}

#[test]
fn what_cannot_be_mended_leaves_nothing_behind() {
    let folder = fresh();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (page, copy) = (path("page.xml"), path("copy.xml"));
    fs::write(&page, "<!DOCTYPE html><html></html>").unwrap();
    let (status, told, error) = bsdf(&["check", &page]);
    assert!(status == 4 && told.contains("unreadable"), "{told}");
    assert!(error.contains("web page"), "{error}");
    for file in [page, golden("09_too_few_values.xml")] {
        let (status, _, error) = bsdf(&["check", &file, "--fix", "-o", &copy]);
        assert!(status == 4 && error.contains("not mended"), "{error}");
        assert!(!Path::new(&copy).exists());
    }
}

#[test]
fn the_command_line_is_checked() {
    let good = golden("00_good_matrix.xml");
    let folder = fresh();
    let copy = folder.path().join("copy.xml").to_str().unwrap().to_owned();
    for (words, expected) in [
        (vec!["check", &good, &good, "--fix", "-o", &copy], "expected one file, found 2"),
        (vec!["check", &good, "--fix"], "--output"),
        (vec!["check", &good, "-o", &copy], "--fix"),
        (vec!["check", &good, "--fix", "-o", &copy, "--also", "energy"], "not-reciprocal"),
    ] {
        let (status, _, error) = bsdf(&words);
        assert!(status == 2 && error.contains(expected), "{words:?}: {error}");
    }
    assert!(!Path::new(&copy).exists());
}
