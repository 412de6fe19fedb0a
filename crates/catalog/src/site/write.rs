//! Writes a site: whole, or not at all.

use std::collections::{HashMap, HashSet};
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use bsdfkit::{Error, Result};
use bsdfkit_represent::Watch;

use super::cards::index_html;
use super::material::material_html;
use super::nearest::nearest;
use super::{FORMAT, INDEX, Similar, SiteEntry, SiteIndex, VERSION, VIEWER};
use crate::entry::StoredFile;
use crate::hash::Hashing;
use crate::library::Library;
use crate::look::Look;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("catalog.js");

/// Materials that a page names as looking like its own.
const SIMILAR: usize = 6;

/// How a site is made.
#[derive(Clone, Debug)]
pub struct Options {
    /// Its title.
    pub title: String,
    /// Whether materials that cannot be read are left out rather than refused.
    pub skip_faulty: bool,
    /// The viewer's page, which the pages of materials link to; without, they have downloads only.
    pub viewer: Option<&'static str>,
}

/// What was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Built {
    /// Materials.
    pub entries: usize,
    /// Their files.
    pub files: usize,
    /// Bytes of those files.
    pub bytes: u64,
}

/// Makes the site of a library in the folder `site`: into a temporary folder beside it, then renamed.
///
/// A folder that is a site already is replaced; any other that is not empty is refused.
/// Cost: copies all files; pictures once each, 0.1 s of trees, some seconds of interpolants.
///
/// Errors: format: faulty materials, unless they are left out; argument: `site` within the library, or a folder of something
/// else; io.
pub fn build(
    library: &mut Library,
    site: &Path,
    options: &Options,
    watch: &Watch<'_>,
) -> Result<Built> {
    if let Some(fault) = library.faults().first().filter(|_| !options.skip_faulty) {
        let count = library.faults().len();
        return Err(Error::format(format!(
            "{}; {count} materials cannot be read: mend them or leave them out (--skip-faulty)",
            fault.error
        )));
    }
    expect_replaceable(site, library.folder())?;
    let pictures = library.pictures(watch)?;
    let index = index_of(library, options)?;
    let parent = match site.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let io = |path: &Path, e: &std::io::Error| Error::io(path.display(), e);
    let making = tempfile::Builder::new().prefix(".bsdf-catalog-").tempdir_in(parent);
    let making = making.map_err(|e| io(parent, &e))?;
    let root = making.path().join("site");
    let write = |path: &str, bytes: &[u8]| {
        let path = root.join(path);
        let folder = path.parent().unwrap_or(&root);
        fs::create_dir_all(folder).and_then(|()| fs::write(&path, bytes)).map_err(|e| io(&path, &e))
    };
    let by_id: HashMap<&str, &SiteEntry> =
        index.entries.iter().map(|e| (&*e.entry.id, e)).collect();
    let mut built = Built { entries: index.entries.len(), files: 0, bytes: 0 };
    for ((entry, picture), from) in index.entries.iter().zip(&pictures).zip(library.entries()) {
        let page = material_html(&index, entry, &by_id, options.viewer.is_some());
        write(&entry.page, page.as_bytes())?;
        write(&entry.picture, picture)?;
        for (file, from) in entry.entry.files.iter().zip(&from.files) {
            copy(&library.folder().join(&from.path), &root.join(&file.path), file)?;
            built.files += 1;
            built.bytes += file.bytes;
        }
    }
    let json =
        serde_json::to_vec(&index).map_err(|e| Error::io(INDEX, &std::io::Error::other(e)))?;
    write(INDEX, &json)?;
    write("index.html", index_html(&index).as_bytes())?;
    write("style.css", STYLE.as_bytes())?;
    if let Some(page) = options.viewer {
        write(VIEWER, page.as_bytes())?;
    }
    write("catalog.js", SCRIPT.as_bytes())?;
    // The old site stays until the new one is whole, and goes with the temporary folder.
    let old = making.path().join("old");
    let replaces = site.exists();
    if replaces {
        fs::rename(site, &old).map_err(|e| io(site, &e))?;
    }
    if let Err(e) = fs::rename(&root, site) {
        if replaces {
            fs::rename(&old, site).map_err(|e| io(site, &e))?;
        }
        return Err(io(site, &e));
    }
    Ok(built)
}

/// All that `index.json` says.
fn index_of(library: &Library, options: &Options) -> Result<SiteIndex> {
    let looks: Vec<Look> = library.looks()?;
    let entries = library.entries();
    let similar = |near: &Vec<(usize, f64)>| {
        let similar = |&(k, distance): &(usize, f64)| Similar {
            id: entries[k].id.clone(),
            distance: (1e4 * distance).round() / 1e4,
        };
        near.iter().map(similar).collect()
    };
    let site_entry = |(entry, near): (&crate::Entry, &Vec<(usize, f64)>)| {
        let mut entry = entry.clone();
        let mut taken = HashSet::new();
        for (k, file) in entry.files.iter_mut().enumerate() {
            if !taken.insert(file.name.clone()) {
                file.name = format!("{k}-{}", file.name);
                taken.insert(file.name.clone());
            }
            file.path = format!("files/{}/{}", entry.id, file.name);
        }
        let (page, picture) =
            (format!("materials/{}.html", entry.id), format!("pictures/{}.png", entry.id));
        SiteEntry { entry, page, picture, similar: similar(near) }
    };
    let near = nearest(&looks, SIMILAR);
    Ok(SiteIndex {
        format: FORMAT.to_owned(),
        version: VERSION,
        title: options.title.clone(),
        made_by: format!("bsdfkit {}", env!("CARGO_PKG_VERSION")),
        distance: Look::DISTANCE.to_owned(),
        entries: entries.iter().zip(&near).map(site_entry).collect(),
    })
}

/// Refuses to replace what is no site, and to write a site into its own library.
fn expect_replaceable(site: &Path, library: &Path) -> Result<()> {
    let absolute = |path: &Path| -> std::io::Result<PathBuf> {
        let path = std::path::absolute(path)?;
        // What does not exist yet is where its nearest folder that does exist is.
        let there = path.ancestors().find(|a| a.exists()).unwrap_or(Path::new("/"));
        let rest = path.strip_prefix(there).unwrap_or(Path::new(""));
        Ok(there.canonicalize()?.join(rest))
    };
    let io = |e: std::io::Error| Error::io(site.display(), &e);
    let (at, library) = (absolute(site).map_err(io)?, absolute(library).map_err(io)?);
    if at.starts_with(&library) || library.starts_with(&at) {
        let text = "expected a folder apart from the catalogue's own";
        return Err(Error::argument(text).context(site.display()));
    }
    let is_empty = match fs::read_dir(site) {
        Ok(mut files) => files.next().is_none(),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => true,
        Err(e) => return Err(io(e)),
    };
    let mut head = String::new();
    let index = File::open(site.join(INDEX));
    let read = index.and_then(|file| file.take(256).read_to_string(&mut head));
    if is_empty || (read.is_ok() && head.contains(FORMAT)) {
        return Ok(());
    }
    let text = "expected a new folder, an empty one or an older site, found other files";
    Err(Error::argument(text).context(site.display()))
}

/// Copies a file, and finds out whether it still is what was read.
fn copy(from: &Path, to: &Path, file: &StoredFile) -> Result<()> {
    let io = |path: &Path, e: &std::io::Error| Error::io(path.display(), e);
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder).map_err(|e| io(to, &e))?;
    }
    let mut source = File::open(from).map_err(|e| io(from, &e))?;
    let mut target = File::create(to).map_err(|e| io(to, &e))?;
    let mut hashing = Hashing::default();
    let mut block = vec![0; 1 << 16];
    loop {
        let n = source.read(&mut block).map_err(|e| io(from, &e))?;
        if n == 0 {
            break;
        }
        hashing.add(&block[..n]);
        target.write_all(&block[..n]).map_err(|e| io(to, &e))?;
    }
    if hashing.end() != (file.sha256, file.bytes) {
        let text = "expected the file that was read, found that it changed meanwhile: build again";
        return Err(Error::format(text).context(from.display()));
    }
    Ok(())
}
