//! `bsdf catalog`: what a person types, and the exit statuses.

use std::path::Path;
use std::process::{Command, Output};

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::{Bsdf, Component, Lambertian, Metadata, Side, xml};

fn bsdf(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bsdf"));
    command.current_dir(folder).args(line.split(' ')).env("BSDFKIT_CACHE", folder.join("cache"));
    command.output().expect("the command starts")
}

fn ok(folder: &Path, line: &str) -> String {
    let output = bsdf(folder, line);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{line}: {errors}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn fails(folder: &Path, line: &str, status: i32) -> String {
    let output = bsdf(folder, line);
    let errors = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(status), "{line}: {errors}");
    errors
}

fn put(folder: &Path, name: &str, value: f32) {
    let basis = KlemsBasis::quarter();
    let n = basis.directions();
    let matrix = KlemsMatrix::new(basis.clone(), basis, vec![value; n * n]).expect("a matrix");
    let component = Component::new(Side::Front, Side::Front, matrix);
    let bsdf = Bsdf::new(Metadata::default(), vec![component], Lambertian::default());
    xml::write(&bsdf, folder.join(format!("{name}.xml")), &Default::default()).expect("written");
    let record = format!("name = \"{name} paint\"\nmaker = \"Acme\"\n");
    std::fs::write(folder.join(format!("{name}.toml")), record).expect("written");
}

#[test]
fn published_found_and_fetched() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::create_dir(at.join("materials")).expect("a folder");
    put(&at.join("materials"), "white", 0.25);
    put(&at.join("materials"), "grey", 0.1);
    let said = ok(at, "catalog build materials -o site --json");
    let said: serde_json::Value = serde_json::from_str(&said).expect("JSON");
    assert_eq!((&said["materials"], &said["files"]), (&2.into(), &2.into()));

    let found = ok(at, "catalog search --in materials --like materials/grey.xml");
    let lines: Vec<&str> = found.lines().collect();
    assert!(lines[1].contains("grey paint") && lines[2].contains("white paint"), "{found}");
    let found = ok(at, "catalog search --in materials whi maker:acme --json");
    let found: serde_json::Value = serde_json::from_str(&found).expect("JSON");
    assert_eq!(found["name"], "white paint");

    let said = ok(at, "catalog get site/materials/white.html -o here");
    assert_eq!(said.trim(), Path::new("here").join("white.xml").display().to_string());
    let read = |path: &str| std::fs::read(at.join(path)).expect("there");
    assert_eq!(read("here/white.xml"), read("materials/white.xml"));

    let mut tampered = read("site/files/grey/grey.xml");
    let last = tampered.len() - 2;
    tampered[last] ^= 1;
    std::fs::write(at.join("site/files/grey/grey.xml"), tampered).expect("written");
    let said = fails(at, "catalog get site#grey -o here", 4);
    assert!(said.contains("is refused"), "{said}");
    assert!(!at.join("here/grey.xml").exists());
    fails(at, "catalog get site#none", 2);
    fails(at, "catalog get nowhere#none", 3);
    fails(at, "catalog get site#white --most-bytes 10 --cache other", 5);
    fails(at, "catalog search --in materials colour:red", 2);
    fails(at, "catalog build materials -o materials/site", 2);
}
