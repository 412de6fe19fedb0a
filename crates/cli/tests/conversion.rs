//! `bsdf convert` of stored BSDFs: totals stay, targets that are missed are said.

use std::path::Path;
use std::process::Command;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::xml::{self, WriteOptions};
use bsdfkit::{Bsdf, Component, Lambertian, Metadata, Side};
use serde_json::Value;

/// Standard output of a command that succeeds.
fn ok(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_bsdf")).args(arguments).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// A Klems XML of one component; its path.
fn file(folder: &Path, sides: [Side; 2], f: impl Fn(&KlemsBasis, usize, usize) -> f64) -> String {
    let basis = KlemsBasis::full();
    let n = basis.directions();
    let values = (0..n * n).map(|k| f(&basis, k / n, k % n) as f32).collect();
    let matrix = KlemsMatrix::new(basis.clone(), basis, values).unwrap();
    let component = Component::new(sides[0], sides[1], matrix);
    let bsdf = Bsdf::new(Metadata::default(), vec![component], Lambertian::default());
    let path = folder.join("klems.xml");
    xml::write(&bsdf, &path, &WriteOptions::default()).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Lambertian by rows, from .56 at the normal to .71: not reciprocal.
fn uneven(basis: &KlemsBasis, i: usize, _: usize) -> f64 {
    (0.56 + 0.15 * basis.centre(i).truncate().length_squared()) / std::f64::consts::PI
}

fn through(basis: &KlemsBasis, i: usize, o: usize) -> f64 {
    0.03 + if i == o { 0.7 / basis.projected_solid_angle(i) } else { 0.0 }
}

/// Reflectance and transmittance.
fn totals(path: &str, incident: &str) -> f64 {
    let text = ok(&["hemispherical", path, "--incident", incident, "--json"]);
    let rows: Value = serde_json::from_str(&text).unwrap();
    ["reflectance", "transmittance"].iter().filter_map(|key| rows[0][key].as_f64()).sum()
}

#[test]
fn totals_are_kept_unless_averaging_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("tree.xml");
    let target = target.to_str().unwrap();
    for sides in
        [[Side::Front; 2], [Side::Back; 2], [Side::Front, Side::Back], [Side::Back, Side::Front]]
    {
        let source = file(folder.path(), sides, uneven);
        let (normal, grazing) = match sides[0] {
            Side::Front => ("0,0", "80,0"),
            Side::Back => ("180,0", "100,0"),
        };
        for kind in ["tensor-tree", "klems-half"] {
            let line = ok(&["convert", &source, "--to", kind, "-o", target]);
            assert!(!line.contains("reciprocal") && !line.contains("not reached"), "{line}");
            for incident in [normal, grazing] {
                let (was, is) = (totals(&source, incident), totals(target, incident));
                assert!((is / was - 1.0).abs() < 0.01, "{sides:?} {kind} {incident}: {was}, {is}");
            }
        }
    }
    let source = file(folder.path(), [Side::Front; 2], uneven);
    for kind in ["tensor-tree", "klems-half", "klems-full"] {
        let line = ok(&["convert", &source, "--to", kind, "-o", target, "--reciprocity", "on"]);
        assert!(line.contains("reciprocal"), "{line}");
        assert!((totals(target, "0,0") / 0.5975 - 1.0).abs() < 0.01, "{}", totals(target, "0,0"));
    }
}

#[test]
fn a_missed_target_is_said_in_the_same_words_asked_for_or_not() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("tree.xml");
    let target = target.to_str().unwrap();
    let source = file(folder.path(), [Side::Front, Side::Back], through);
    let convert = |more: &[&str]| {
        let words = ["convert", &source, "--to", "tensor-tree", "-o", target];
        ok(&[&words[..], more].concat())
    };
    let words = "target L1 0.01 not reached: it takes more than 50000 leaves";
    assert!(convert(&["--max-leaves", "50000"]).contains(words));
    let asked = convert(&["--max-leaves", "50000", "--max-error", "0.01"]);
    assert!(asked.contains(words), "{asked}");
    let json = convert(&["--max-leaves", "50000", "--json"]);
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["trees"][0]["missed"], words);
    assert!(json["trees"][0]["leaves"].as_u64().unwrap() <= 50_000);
    assert!(convert(&[]).contains("target L1 0.01 not reached: it takes more than 3000000 leaves"));
    let shallow = convert(&["--max-depth", "2"]);
    assert!(shallow.contains("target L1 0.01 not reached: it takes leaves deeper than level 2"));
    let reached = convert(&["--max-error", "0.9"]);
    assert!(!reached.contains("not reached"), "{reached}");
}

#[test]
fn what_is_negligible_is_one_leaf() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("tree.xml");
    let target = target.to_str().unwrap();
    let faint = |basis: &KlemsBasis, i, o| 0.001 * through(basis, i, o);
    let source = file(folder.path(), [Side::Front, Side::Back], faint);
    let line = ok(&["convert", &source, "--to", "tensor-tree", "-o", target]);
    assert!(line.contains("negligible: 1 leaf") && !line.contains("not reached"), "{line}");
    let info: Value = serde_json::from_str(&ok(&["info", target, "--json"])).unwrap();
    assert!(info.to_string().contains("\"leaves\":1"), "{info}");
}

#[test]
fn spectra_that_a_form_does_not_hold_are_said() {
    let folder = tempfile::tempdir().unwrap();
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/compiled");
    let source = golden.join("spectral_tree.safetensors");
    let said = |words: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bsdf"));
        let output = command.arg("convert").arg(&source).args(words).output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    let path = folder.path().join("matrix.xml");
    let text = said(&["--to", "klems-quarter", "-o", path.to_str().unwrap()]);
    assert!(text.contains("spectra of 3 wavelengths left out"), "{text}");
    let copy = folder.path().join("copy.safetensors");
    let text = said(&["--to", "tensor-tree", "-o", copy.to_str().unwrap()]);
    assert!(!text.contains("left out"), "{text}");
}
