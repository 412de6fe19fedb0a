//! Folders of BSDFs: what is read, what is read again, what is found.

mod common;

use std::fs;

use bsdfkit_catalog::{Look, Query};
use bsdfkit_represent::Watch;
use common::{material, named, open, put, three};

fn found(
    folder: &std::path::Path,
    words: &[&str],
    like: Option<Look>,
) -> Vec<(String, Option<f64>)> {
    let library = open(folder);
    let query = Query { words: words.iter().map(|w| (*w).to_owned()).collect(), like };
    let found = query.of(&library).unwrap();
    found.iter().map(|f| (f.entry.id.clone(), f.distance)).collect()
}

fn ids(folder: &std::path::Path, words: &[&str]) -> Vec<String> {
    let mut ids: Vec<String> = found(folder, words, None).into_iter().map(|f| f.0).collect();
    ids.sort();
    ids
}

#[test]
fn words_are_found_in_all_fields_or_in_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    three(at);
    assert_eq!(ids(at, &[]), ["mirror", "paint-grey", "paint-white"]);
    assert_eq!(ids(at, &["acme"]), ["mirror", "paint-white"]);
    assert_eq!(ids(at, &["maker:acm"]), ["paint-white"]);
    assert_eq!(ids(at, &["paint", "gr"]), ["paint-grey"]);
    assert_eq!(ids(at, &["\"", "*"]), [""; 0]);
    assert_eq!(ids(at, &["licence:CC-BY-4.0"]).len(), 3);
    let query = Query { words: vec!["colour:red".into()], like: None };
    let error = query.of(&open(at)).unwrap_err().to_string();
    assert!(error.contains("expected one of the fields name, maker"), "{error}");
}

#[test]
fn what_looks_alike_comes_first_with_its_distance() {
    let folder = tempfile::tempdir().unwrap();
    three(folder.path());
    let like = Look::of(&material(0.7, 0.0)).unwrap();
    let near = found(folder.path(), &[], Some(like.clone()));
    let order: Vec<&str> = near.iter().map(|f| &*f.0).collect();
    assert_eq!(order, ["paint-grey", "paint-white", "mirror"]);
    // Diffusers differ by their reflectances, which patches up to the horizon keep.
    for (distance, expected) in [(near[0].1, 0.05), (near[1].1, 0.10)] {
        assert!((distance.unwrap() - expected).abs() < 0.01, "{distance:?} {expected}");
    }
    assert!(near[2].1.unwrap() > 1.0, "{near:?}");
    let only = found(folder.path(), &["maker:silver"], Some(like));
    assert_eq!(only.len(), 1);
}

#[test]
fn facts_are_those_of_the_files() {
    let folder = tempfile::tempdir().unwrap();
    three(folder.path());
    let library = open(folder.path());
    let white = library.entries().iter().find(|e| e.id == "paint-white").unwrap();
    assert_eq!(white.facts.components, ["front reflection"]);
    assert!((white.facts.reflectance - 0.8).abs() < 1e-3 && white.facts.transmittance == 0.0);
    assert_eq!(white.files[0].path, "paint/white.xml");
    assert_eq!(white.files[0].form, "matrix, LBNL/Klems Quarter");
}

#[test]
fn what_changed_is_read_again_and_what_is_gone_forgotten() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    three(at);
    assert_eq!(open(at).entries().len(), 3);
    put(at, "mirror", &material(0.0, 0.5), &named("Dull mirror"));
    fs::remove_file(at.join("paint/grey.xml")).unwrap();
    let library = open(at);
    let titles: Vec<&str> = library.entries().iter().map(bsdfkit_catalog::Entry::title).collect();
    assert_eq!(titles, ["Dull mirror", "White paint"]);
    assert!((library.entries()[0].facts.reflectance - 0.5).abs() < 1e-3);
    assert_eq!(ids(at, &["street"]), [""; 0]);
}

#[test]
fn a_damaged_index_is_made_anew() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    three(at);
    drop(open(at));
    let index = at.join(".bsdf-catalog.sqlite");
    assert!(index.exists());
    fs::write(&index, "rubbish, long enough to be taken for a page of a database".repeat(100))
        .unwrap();
    assert_eq!(open(at).entries().len(), 3);
    assert_eq!(ids(at, &["acme"]).len(), 2);
}

#[test]
fn faults_are_told_and_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    three(at);
    assert_eq!(open(at).entries().len(), 3);
    fs::write(at.join("mirror.json"), r#"{"licence": "mine"}"#).unwrap();
    fs::write(at.join("bad.xml"), "<WindowElement>").unwrap();
    let library = open(at);
    assert_eq!(library.entries().len(), 2);
    let mut faults: Vec<String> = library.faults().iter().map(|f| f.error.to_string()).collect();
    faults.sort();
    assert!(faults[0].contains("bad.xml"), "{faults:?}");
    assert!(faults[1].contains("mirror.json: licence: expected an SPDX"), "{faults:?}");
    // They are read again until they are mended.
    fs::write(at.join("mirror.json"), r#"{"licence": "MIT"}"#).unwrap();
    fs::remove_file(at.join("bad.xml")).unwrap();
    assert_eq!(open(at).entries().len(), 3);
}

#[test]
fn a_file_without_a_record_speaks_for_itself() {
    let folder = tempfile::tempdir().unwrap();
    let mut metadata = bsdfkit::Metadata { name: "Cloth".into(), ..Default::default() };
    bsdfkit_catalog::Record { instrument: "pab".into(), ..named("Cloth -- fine") }
        .write_into(&mut metadata);
    let cloth = material(0.3, 0.0);
    let cloth = bsdfkit::Bsdf::new(metadata, cloth.components().to_vec(), Default::default());
    bsdfkit::xml::write(&cloth, folder.path().join("cloth.xml"), &Default::default()).unwrap();
    let library = open(folder.path());
    let record = &library.entries()[0].record;
    assert_eq!((&*record.name, &*record.instrument), ("Cloth -- fine", "pab"));
}

#[test]
fn ids_are_unique_and_no_folder_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    for stem in ["a b", "a-b", "A.B"] {
        put(folder.path(), stem, &material(0.3, 0.0), &named(stem));
    }
    let library = open(folder.path());
    let ids: Vec<&str> = library.entries().iter().map(|e| &*e.id).collect();
    assert_eq!(ids, ["a-b", "a-b-2", "a-b-3"]);
    let file = folder.path().join("a b.xml");
    assert!(bsdfkit_catalog::Library::open(&file, &Watch::default()).is_err());
}
