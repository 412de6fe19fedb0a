//! Downloads: verified, kept, never half, never elsewhere.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use bsdfkit::ErrorClass;
use bsdfkit_catalog::Sha256;
use bsdfkit_catalog::get::{Cache, Choice, get};
use common::{build, files, serve, three};

/// A library, its site and a cache.
struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        three(&folder.path().join("library"));
        build(&folder.path().join("library"), &folder.path().join("site")).unwrap();
        Self { folder }
    }

    fn site(&self) -> PathBuf {
        self.folder.path().join("site")
    }

    fn cache(&self) -> Cache {
        Cache { folder: self.folder.path().join("cache"), most_bytes: 1 << 24 }
    }

    /// What `get` of a material says that is refused; nothing may be left of it.
    fn refused(&self, address: &str) -> bsdfkit::Error {
        let error = get(address, &Choice::First, &self.cache()).unwrap_err();
        let cache = self.cache().folder;
        assert!(!cache.exists() || files(&cache).is_empty(), "{:?}", files(&cache));
        error
    }

    /// Changes the index by text.
    fn edit(&self, from: &str, to: &str) {
        let path = self.site().join("index.json");
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{from}");
        fs::write(path, text.replace(from, to)).unwrap();
    }
}

const FILE: &str = "files/mirror/mirror.xml";

#[test]
fn a_folder_and_a_web_host_give_the_same_file() {
    let place = Place::new();
    let bytes = fs::read(place.site().join(FILE)).unwrap();
    let web = serve(place.site());
    let hash = Sha256::of(&bytes);
    for (k, address) in [
        format!("{web}materials/mirror.html"),
        format!("{web}#mirror"),
        format!("{}#mirror", place.site().display()),
        format!("{}/materials/mirror.html", place.site().display()),
        format!("{web}{FILE}#sha256={hash}"),
        format!("{}/{FILE}#sha256={hash}", place.site().display()),
    ]
    .iter()
    .enumerate()
    {
        let got = get(address, &Choice::All, &place.cache()).unwrap();
        assert_eq!((got.len(), got[0].cached, got[0].sha256), (1, k > 0, hash), "{address}");
        assert_eq!(fs::read(&got[0].path).unwrap(), bytes);
        assert!(got[0].path.starts_with(place.cache().folder));
    }
    let got = get(&format!("{web}#mirror"), &Choice::First, &place.cache()).unwrap();
    let copied = got[0].copy_into(&place.folder.path().join("here")).unwrap();
    assert_eq!(fs::read(copied).unwrap(), bytes);
}

#[test]
fn a_file_that_was_tampered_with_is_refused() {
    let place = Place::new();
    let web = serve(place.site());
    let path = place.site().join(FILE);
    let good = fs::read(&path).unwrap();
    let mut changed = good.clone();
    let at = changed.len() / 2;
    changed[at] ^= 1;
    let cut = good[..good.len() - 1].to_vec();
    let long = [&good[..], b" "].concat();
    for (bytes, words) in
        [(changed, "expected SHA-256"), (cut, "bytes, found"), (long, "found more")]
    {
        fs::write(&path, bytes).unwrap();
        for address in
            [format!("{web}materials/mirror.html"), format!("{}#mirror", place.site().display())]
        {
            let error = place.refused(&address).to_string();
            assert!(error.contains(words) && error.contains(FILE), "{error}");
        }
    }
    // A damaged file in the cache is fetched again.
    fs::write(&path, &good).unwrap();
    let address = format!("{web}#mirror");
    let kept = get(&address, &Choice::First, &place.cache()).unwrap().remove(0).path;
    fs::write(&kept, "damaged").unwrap();
    let again = get(&address, &Choice::First, &place.cache()).unwrap().remove(0);
    assert!(!again.cached);
    assert_eq!(fs::read(again.path).unwrap(), good);
}

#[test]
fn an_index_leads_nowhere_else() {
    let place = Place::new();
    let address = format!("{}#mirror", place.site().display());
    let outside = fs::read(place.site().join(FILE)).unwrap();
    fs::write(place.folder.path().join("secret.xml"), outside).unwrap();
    let mut now = format!("\"path\":\"{FILE}\"");
    for path in [
        "../secret.xml",
        "/etc/passwd",
        "files/../../secret.xml",
        "..\\\\secret.xml",
        "http://h/secret.xml",
    ] {
        let next = format!("\"path\":\"{path}\"");
        place.edit(&now, &next);
        now = next;
        let error = place.refused(&address);
        assert!(error.to_string().contains("plain names within the site"), "{error}");
        assert_eq!(error.class(), ErrorClass::Format);
    }
    place.edit(&now, &format!("\"path\":\"{FILE}\""));
    place.edit("\"name\":\"mirror.xml\"", "\"name\":\"../../mirror.xml\"");
    let error = place.refused(&address).to_string();
    assert!(error.contains("name of a file"), "{error}");
    assert!(!place.folder.path().join("mirror.xml").exists());
}

#[test]
fn sizes_are_bounded() {
    let place = Place::new();
    let address = format!("{}#mirror", place.site().display());
    let bytes = fs::metadata(place.site().join(FILE)).unwrap().len();
    let small = Cache { most_bytes: bytes - 1, ..place.cache() };
    let error = get(&address, &Choice::First, &small).unwrap_err();
    assert_eq!(error.class(), ErrorClass::Limit);
    // Neither what an index claims nor what comes is believed.
    let hash = Sha256::of(&fs::read(place.site().join(FILE)).unwrap());
    let file = format!("{}/{FILE}#sha256={hash}", place.site().display());
    let error = get(&file, &Choice::First, &small).unwrap_err();
    assert_eq!(error.class(), ErrorClass::Limit);
    assert!(files(&small.folder).is_empty());
}

#[test]
fn errors_say_what_there_is() {
    let place = Place::new();
    let site = place.site();
    let web = serve(site.clone());
    let text = |address: &str| place.refused(address).to_string();
    let error = text(&format!("{}#mirrror", site.display()));
    assert!(error.contains("mirror, paint-grey") && error.contains("\"mirrror\""), "{error}");
    let error = text(&web);
    assert!(error.contains("expected #ID"), "{error}");
    let error = text(&format!("{web}elsewhere/#a"));
    assert!(error.contains("index.json") && error.contains("404"), "{error}");
    let error = text(&Path::new("/nowhere/at/all#a").display().to_string());
    assert!(error.contains("index.json"), "{error}");
    let named = Choice::Named("x.xml".into());
    let error = get(&format!("{web}#mirror"), &named, &place.cache()).unwrap_err().to_string();
    assert!(error.contains("expected one of the files mirror.xml"), "{error}");
    place.edit("bsdfkit-catalog", "other-catalog");
    assert!(text(&format!("{web}#mirror")).contains("found \"other-catalog\""));
    fs::write(site.join("index.json"), "<!doctype html>").unwrap();
    assert!(text(&format!("{web}#mirror")).contains("expected the index of a catalogue"));
}
