//! Files that each target begins with: `corpus/TARGET`, and those of `tests/golden` that fit.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Folders and endings of what other tests have, by target.
const SHARED: [(&str, &str, &str); 4] = [
    ("xml", "../tests/golden/xml", "xml"),
    ("xml", "../tests/golden/badxml", "xml"),
    ("container", "../tests/golden/compiled", "safetensors"),
    ("sir", "../tests/golden/sir", "sir"),
];

/// Larger files make slow targets.
const MOST_BYTES: u64 = 40_000;

/// The files for that target, in order of name.
pub fn files(target: &str) -> Vec<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let own = here.join("corpus").join(target);
    let shared = SHARED.iter().filter(|(name, ..)| *name == target);
    let mut found = list(&own, None);
    for (_, folder, suffix) in shared {
        found.extend(list(&here.join(folder), Some(suffix)));
    }
    found
}

fn list(folder: &Path, suffix: Option<&str>) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path());
    let small = |path: &PathBuf| path.metadata().is_ok_and(|m| m.len() <= MOST_BYTES);
    let fits = |path: &PathBuf| suffix.is_none_or(|s| path.extension().is_some_and(|e| e == s));
    let mut found: Vec<PathBuf> = entries.filter(|p| small(p) && fits(p)).collect();
    found.sort();
    found
}

/// Containers that are sound, whatever they hold.
pub(crate) fn containers() -> &'static [Vec<u8>] {
    static FOUND: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    FOUND.get_or_init(|| {
        let read = |path: &PathBuf| fs::read(path).expect("a file of the corpus");
        let sound = |bytes: &Vec<u8>| bsdfkit_fit::open::open_bytes(bytes).is_ok();
        files("container").iter().map(read).filter(sound).collect()
    })
}
