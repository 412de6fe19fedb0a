//! Which files of a folder belong together.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use bsdfkit::{Error, Result};
use bsdfkit_fit::deliver::{Consumer, Kind};
use walkdir::WalkDir;

/// Files of one material: those that have the same name but for the suffix.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Group {
    /// That name, from the folder on, with slashes.
    pub(crate) stem: String,
    /// BSDFs and interpolants.
    pub(crate) files: Vec<PathBuf>,
    /// The record.
    pub(crate) sidecar: Option<PathBuf>,
    /// Names, sizes and times of all of them: what has the same is the same.
    pub(crate) print: String,
}

/// Suffixes of BSDFs and interpolants.
const FILES: [&str; 3] = ["xml", "safetensors", "sir"];
/// Suffixes of records.
const SIDECARS: [&str; 2] = ["toml", "json"];
/// Folders in folders.
const DEEPEST: usize = 16;
/// Files looked at.
const MOST: usize = 1_000_000;

/// All groups under `folder` that have a BSDF, by name. Hidden files and folders are passed over, links not followed.
///
/// Errors: io; format: two records of one material; limit: more than a million files.
pub(crate) fn scan(folder: &Path) -> Result<Vec<Group>> {
    let mut groups: BTreeMap<String, Group> = BTreeMap::new();
    let hidden = |name: &std::ffi::OsStr| name.as_encoded_bytes().starts_with(b".");
    let walk = WalkDir::new(folder).max_depth(DEEPEST).sort_by_file_name().into_iter();
    let walk = walk.filter_entry(|e| e.depth() == 0 || !hidden(e.file_name()));
    for (count, found) in walk.enumerate() {
        let found = found.map_err(|e| Error::io(folder.display(), &e.into()))?;
        if count == MOST {
            let text = format!("{}: expected at most {MOST} files", folder.display());
            return Err(Error::limit(text));
        }
        if !found.file_type().is_file() {
            continue;
        }
        let path = found.path();
        let Some(suffix) = path.extension().and_then(|s| s.to_str()).map(str::to_ascii_lowercase)
        else {
            continue;
        };
        let is_sidecar = SIDECARS.contains(&&*suffix);
        if !is_sidecar && !FILES.contains(&&*suffix) {
            continue;
        }
        // From the folder on: however that is named, what lies in it is the same.
        let within = path.strip_prefix(folder).unwrap_or(path);
        let stem = stem(within);
        let group = groups.entry(stem.clone()).or_default();
        group.stem = stem;
        let about = found.metadata().map_err(|e| Error::io(path.display(), &e.into()))?;
        let time = about.modified().ok().and_then(|t| t.duration_since(UNIX_EPOCH).ok());
        let nanoseconds = time.map_or(0, |t| t.as_nanos());
        group.print += &format!("{}\0{}\0{nanoseconds}\0", within.display(), about.len());
        if !is_sidecar {
            group.files.push(path.to_owned());
        } else if let Some(other) = group.sidecar.replace(path.to_owned()) {
            let text = format!("expected one record, found {} too", other.display());
            return Err(Error::format(text).context(path.display()));
        }
    }
    Ok(groups.into_values().filter(|group| !group.files.is_empty()).collect())
}

/// `metals/brushed.klems-full.xml` is of `metals/brushed`: names of [`Kind`]s and [`Consumer`]s do not count.
fn stem(path: &Path) -> String {
    let parts: Vec<String> = path.iter().map(|p| p.to_string_lossy().into_owned()).collect();
    let joined = parts.join("/");
    let mut stem = joined.rsplit_once('.').map_or(&*joined, |(stem, _)| stem);
    while let Some((shorter, word)) = stem.rsplit_once('.')
        && (word.parse::<Kind>().is_ok() || word.parse::<Consumer>().is_ok())
    {
        stem = shorter;
    }
    stem.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_one_name_belong_together() {
        for (path, expected) in [
            ("a/b.xml", "a/b"),
            ("a/b.klems-full.xml", "a/b"),
            ("a/b.window.xml", "a/b"),
            ("a/b.energyplus.klems-half.xml", "a/b"),
            ("a/1.5 mm.xml", "a/1.5 mm"),
            ("a/b.safetensors", "a/b"),
        ] {
            assert_eq!(stem(Path::new(path)), expected);
        }
    }

    #[test]
    fn a_folder_is_sorted_into_groups() {
        let folder = tempfile::tempdir().unwrap();
        for name in
            ["b.xml", "a.xml", "a.render.safetensors", "a.toml", "x.toml", ".c.xml", "d.pdf"]
        {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let groups = scan(folder.path()).unwrap();
        let stems: Vec<(&str, usize, bool)> =
            groups.iter().map(|g| (&*g.stem, g.files.len(), g.sidecar.is_some())).collect();
        assert_eq!(stems, [("a", 2, true), ("b", 1, false)]);
        // The same folder by another name.
        let roundabout = scan(&folder.path().join(".")).unwrap();
        let prints = |groups: &[Group]| groups.iter().map(|g| g.print.clone()).collect::<Vec<_>>();
        assert_eq!(prints(&roundabout), prints(&groups));
        std::fs::write(folder.path().join("a.json"), "").unwrap();
        assert!(scan(folder.path()).unwrap_err().to_string().contains("expected one record"));
    }
}
