//! Files of a site or of anywhere, fetched, verified and kept.
//!
//! The hash comes from the site's index or with the address. It finds what was damaged, cut short or changed after the index
//! was written; who controls a site controls its index, too.

mod cache;
mod place;

use bsdfkit::{Error, Result};

use crate::hash::Sha256;
use crate::name::{expect_plain, expect_within, file_slug};
use crate::site::{FORMAT, INDEX, SiteIndex, VERSION};

pub use cache::{Cache, MOST_BYTES};
use place::{Address, Root};

/// Bytes of an index.
const MOST_INDEX: u64 = 1 << 26;

/// Which files of a material are fetched.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// The one that stands first.
    #[default]
    First,
    /// All.
    All,
    /// The one of that name.
    Named(String),
}

/// A file that is verified and lies in the cache.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Got {
    /// Where it lies.
    pub path: std::path::PathBuf,
    /// Its name, a plain one.
    pub name: String,
    /// What it hashes to.
    pub sha256: Sha256,
    /// Whether it lay there already.
    pub cached: bool,
}

/// Fetches what `address` names, into `cache`:
///
/// - the page of a material, `https://host/site/materials/ID.html`, or `SITE#ID`;
/// - any file with its hash, `https://host/file.xml#sha256=HEX`.
///
/// Both may be paths of this machine instead of addresses with `https://` or `http://`.
///
/// Errors: argument: an address of another kind, an id or a name that the site has not; format: an index or a file that is not what
/// it should be; limit: larger than said, or than [`Cache::most_bytes`]; io: not reached. Nothing is kept of what failed.
pub fn get(address: &str, choice: &Choice, cache: &Cache) -> Result<Vec<Got>> {
    match Address::parse(address)? {
        Address::File { root, name, sha256 } => {
            let kept = file_slug(&name);
            let got = cache.fetch(&kept, sha256, None, &|most| root.open(&name, most));
            Ok(vec![got.map_err(|e| e.context(address))?])
        }
        Address::Material { root, id } => {
            material(&root, id.as_deref(), choice, cache).map_err(|e| e.context(address))
        }
    }
}

fn material(root: &Root, id: Option<&str>, choice: &Choice, cache: &Cache) -> Result<Vec<Got>> {
    let index = read_index(root).map_err(|e| e.context(INDEX))?;
    let entry = index.entries.iter().find(|e| Some(&*e.entry.id) == id);
    let Some(entry) = entry else {
        let ids: Vec<&str> = index.entries.iter().take(8).map(|e| &*e.entry.id).collect();
        let found = id.map_or("none".to_owned(), |id| format!("{id:?}"));
        return Err(Error::argument(format!(
            "expected #ID, the id of one of {} materials ({}, …), found {found}",
            index.entries.len(),
            ids.join(", ")
        )));
    };
    let files = &entry.entry.files;
    let chosen: Vec<_> = match choice {
        Choice::First => files.iter().take(1).collect(),
        Choice::All => files.iter().collect(),
        Choice::Named(name) => files.iter().filter(|f| f.name == *name).collect(),
    };
    if chosen.is_empty() {
        let names: Vec<&str> = files.iter().map(|f| &*f.name).collect();
        return Err(Error::argument(format!(
            "{}: expected one of the files {}",
            entry.entry.id,
            names.join(", ")
        )));
    }
    // All are looked at before the first is fetched.
    for file in &chosen {
        expect_plain(&file.name)?;
        expect_within(&file.path)?;
    }
    let fetch = |file: &&crate::StoredFile| {
        let open = |most| root.open(&file.path, most);
        let got = cache.fetch(&file.name, file.sha256, Some(file.bytes), &open);
        got.map_err(|e| e.context(&file.path))
    };
    chosen.iter().map(fetch).collect()
}

/// The index of a site.
///
/// Errors: io; format: not an index, or of another version; limit: more than 64 MiB.
fn read_index(root: &Root) -> Result<SiteIndex> {
    let mut bytes = Vec::new();
    let mut source = std::io::Read::take(root.open(INDEX, MOST_INDEX)?, MOST_INDEX + 1);
    std::io::Read::read_to_end(&mut source, &mut bytes).map_err(|e| Error::io("reading", &e))?;
    if bytes.len() as u64 > MOST_INDEX {
        return Err(Error::limit(format!("expected at most {MOST_INDEX} bytes")));
    }
    let value: serde_json::Value = serde_json::from_slice(&bytes)
        .map_err(|e| Error::format(format!("expected the index of a catalogue in JSON: {e}")))?;
    let (format, version) = (&value["format"], &value["version"]);
    if format != FORMAT || *version != VERSION {
        return Err(Error::format(format!(
            "expected {FORMAT} of version {VERSION}, found {format} of version {version}"
        )));
    }
    serde_json::from_value(value).map_err(|e| Error::format(e.to_string()))
}
