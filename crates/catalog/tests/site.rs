//! Sites: whole, safe, replaced whole or not at all.

mod common;

use std::fs;

use bsdfkit_catalog::site::{self, SiteIndex};
use bsdfkit_catalog::{Record, Sha256};
use bsdfkit_represent::Watch;
use common::{build, files, material, named, open, options, put, three};

#[test]
fn a_site_holds_what_its_index_says() {
    let folder = tempfile::tempdir().unwrap();
    let (library, at) = (folder.path().join("library"), folder.path().join("site"));
    three(&library);
    let built = build(&library, &at).unwrap();
    assert_eq!((built.entries, built.files), (3, 3));
    let index: SiteIndex =
        serde_json::from_slice(&fs::read(at.join("index.json")).unwrap()).unwrap();
    assert_eq!((&*index.title, index.entries.len()), ("Test & co", 3));
    let cards = fs::read_to_string(at.join("index.html")).unwrap();
    for entry in &index.entries {
        let page = fs::read_to_string(at.join(&entry.page)).unwrap();
        assert!(cards.contains(&entry.page) && cards.contains(&entry.picture));
        assert!(fs::read(at.join(&entry.picture)).unwrap().starts_with(b"\x89PNG"));
        for file in &entry.entry.files {
            let bytes = fs::read(at.join(&file.path)).unwrap();
            assert_eq!((Sha256::of(&bytes), bytes.len() as u64), (file.sha256, file.bytes));
            assert!(page.contains(&file.path) && page.contains(&file.sha256.to_string()));
        }
        assert_eq!(entry.similar.len(), 2);
    }
    let white = index.entries.iter().find(|e| e.entry.id == "paint-white").unwrap();
    assert_eq!(white.similar[0].id, "paint-grey");
    assert!((white.similar[0].distance - 0.05).abs() < 0.01, "{:?}", white.similar);
    // Built again, the same.
    let before: Vec<_> = files(&at).iter().map(|f| fs::read(at.join(f)).unwrap()).collect();
    build(&library, &at).unwrap();
    let after: Vec<_> = files(&at).iter().map(|f| fs::read(at.join(f)).unwrap()).collect();
    assert!(before == after);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "nothing is left beside it");
}

#[test]
fn pages_ask_no_other_host() {
    let folder = tempfile::tempdir().unwrap();
    let (library, at) = (folder.path().join("library"), folder.path().join("site"));
    three(&library);
    build(&library, &at).unwrap();
    for name in files(&at).iter().filter(|n| n.ends_with(".html")) {
        let page = fs::read_to_string(at.join(name)).unwrap();
        for start in ["src=\"", "<link rel=\"stylesheet\" href=\""] {
            for address in page.split(start).skip(1) {
                assert!(
                    !address.starts_with("http") && !address.starts_with('/'),
                    "{name}: {start}"
                );
            }
        }
        assert!(page.contains("default-src 'none'"), "{name}");
    }
}

/// Every tag of a page, whose text stands between `<` and `>`: in what we write, no attribute holds a bare `>`.
fn tags(page: &str) -> Vec<&str> {
    page.split('<').skip(1).map(|rest| rest.split('>').next().unwrap()).collect()
}

#[test]
fn markup_in_a_record_is_text_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    let (library, at) = (folder.path().join("library"), folder.path().join("site"));
    three(&library);
    build(&library, &at).unwrap();
    let known = |at: &std::path::Path| {
        let mut known: Vec<String> = Vec::new();
        for name in files(at).iter().filter(|n| n.ends_with(".html")) {
            let page = fs::read_to_string(at.join(name)).unwrap();
            let element = |tag: &&str| tag.split_whitespace().next().unwrap_or("").to_owned();
            known.extend(tags(&page).iter().map(element));
        }
        known.sort();
        known.dedup();
        known
    };
    let plain = known(&at);
    let script = "<script>alert(1)</script>";
    let attribute = "\"><img src=x onerror=alert(1)>";
    let evil = Record {
        name: script.into(),
        maker: attribute.into(),
        class: "' onmouseover='alert(1)' \" onfocus=\"alert(1)".into(),
        instrument: "</dd></dl><iframe src=x>".into(),
        notes: "<svg onload=alert(1)>&lt;b&gt;".into(),
        licence: "LicenseRef-x".into(),
        doi: "10.1/\"><b>".into(),
        ..Record::default()
    };
    put(&library, "evil", &material(0.79, 0.0), &evil);
    #[cfg(unix)]
    put(&library, "<img src=x onerror=alert(2)>", &material(0.78, 0.0), &named(""));
    let title = format!("Title {script}");
    let options = site::Options { title: title.clone(), ..options() };
    site::build(&mut open(&library), &at, &options, &Watch::default()).unwrap();
    assert_eq!(known(&at), plain, "no element that harmless records have not");
    let escaped = "&lt;script&gt;alert(1)&lt;/script&gt;";
    for name in files(&at).iter().filter(|n| n.ends_with(".html")) {
        let page = fs::read_to_string(at.join(name)).unwrap();
        assert!(page.contains(escaped), "{name}: shown as text");
        for tag in tags(&page) {
            let quotes = tag.matches('"').count();
            assert!(quotes % 2 == 0, "{name}: {tag}");
            // Outside its quotes a tag has no handler.
            let bare: String = tag.split('"').step_by(2).collect();
            assert!(!bare.contains(" on"), "{name}: {tag}");
        }
        assert_eq!(page.matches("<script").count(), 1, "{name}: our own");
    }
    let page = fs::read_to_string(at.join("materials/evil.html")).unwrap();
    assert!(page.contains("https://doi.org/10.1/%22%3E%3Cb%3E"));
    let index: SiteIndex =
        serde_json::from_slice(&fs::read(at.join("index.json")).unwrap()).unwrap();
    let entry = index.entries.iter().find(|e| e.entry.id == "evil").unwrap();
    assert_eq!(entry.entry.record, evil);
}

#[test]
fn what_is_no_site_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let library = folder.path().join("library");
    three(&library);
    let other = folder.path().join("other");
    fs::create_dir(&other).unwrap();
    fs::write(other.join("thesis.tex"), "").unwrap();
    let error = build(&library, &other).unwrap_err().to_string();
    assert!(error.contains("found other files"), "{error}");
    assert!(other.join("thesis.tex").exists());
    for within in [library.join("site"), library.clone(), folder.path().to_owned()] {
        let error = build(&library, &within).unwrap_err().to_string();
        assert!(error.contains("apart from the catalogue's own"), "{error}");
    }
}

#[test]
fn a_site_that_cannot_be_made_leaves_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let (library, at) = (folder.path().join("library"), folder.path().join("site"));
    three(&library);
    build(&library, &at).unwrap();
    let before = files(&at);
    fs::write(library.join("bad.xml"), "<WindowElement>").unwrap();
    let error = build(&library, &at).unwrap_err().to_string();
    assert!(error.contains("bad.xml") && error.contains("--skip-faulty"), "{error}");
    assert_eq!(files(&at), before);
    let options = site::Options { skip_faulty: true, ..options() };
    let built = site::build(&mut open(&library), &at, &options, &Watch::default()).unwrap();
    assert_eq!(built.entries, 3);
    // A file that changes between reading and copying is noticed.
    let mut read = open(&library);
    put(&library, "mirror", &material(0.2, 0.2), &named("Other"));
    let error = site::build(&mut read, &at, &options, &Watch::default()).unwrap_err().to_string();
    assert!(error.contains("mirror.xml") && error.contains("changed meanwhile"), "{error}");
    assert_eq!(files(&at), before);
}

#[test]
fn totals_of_a_bed_record_stand_on_its_page() {
    let folder = tempfile::tempdir().unwrap();
    let (library, at) = (folder.path().join("library"), folder.path().join("site"));
    three(&library);
    let record = r#"{"name": "Glass <i>x</i>", "optical": [{"data": [{"data": [{"dataPoints": [
        {"incidence": {"direction": {"polar": 8}, "wavelengths": {"integral": "visible"}},
         "emergence": {"direction": "hemispherical"}, "results": {"reflectance": 0.0812}}]}]}]}]}"#;
    let json = library.join("paint/white.json");
    fs::write(&json, record).unwrap();
    build(&library, &at).unwrap();
    let index: SiteIndex =
        serde_json::from_slice(&fs::read(at.join("index.json")).unwrap()).unwrap();
    let entry = index.entries.iter().find(|e| e.entry.id == "paint-white").unwrap();
    assert_eq!(entry.entry.totals[0].reflectance, Some(0.0812));
    assert!(index.entries.iter().filter(|e| !e.entry.totals.is_empty()).count() == 1);
    let page = fs::read_to_string(at.join(&entry.page)).unwrap();
    assert!(page.contains("<td>8°</td>") && page.contains("<td>0.081</td>"), "{page}");
    assert!(page.contains("Glass &lt;i&gt;x&lt;/i&gt;") && !page.contains("<i>x"));
    // A fault is told with the file.
    fs::write(&json, record.replace("0.0812", "null, \"x\": []").replace("\"hemispherical\"", "7"))
        .unwrap();
    let error = build(&library, &at).unwrap_err().to_string();
    assert!(error.contains(".json") && error.contains("emergence.direction"), "{error}");
}

#[test]
fn a_material_of_any_name_has_a_card_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let (library, at) = (folder.path().join("library"), folder.path().join("site"));
    // As the page calls its own parts, and two names that are the same without their accents.
    let names = ["cards", "filters", "count", "get", "Grün", "Grun"];
    for name in names {
        put(&library, name, &material(0.5, 0.0), &named(name));
    }
    assert_eq!(build(&library, &at).unwrap().entries, names.len());
    let cards = fs::read_to_string(at.join("index.html")).unwrap();
    for id in ["cards", "filters", "count"] {
        assert_eq!(cards.matches(&format!("id=\"{id}\"")).count(), 1, "{id}");
    }
    let page = |name: &str| fs::read_to_string(at.join("materials").join(name)).unwrap();
    assert!(page("grun.html").contains("id=\"get\""));
    assert_eq!(files(&at).iter().filter(|f| f.starts_with("materials/grun")).count(), 2);
    let mut ids: Vec<&str> =
        cards.split(" id=\"").skip(1).filter_map(|s| s.split('"').next()).collect();
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count);
}
