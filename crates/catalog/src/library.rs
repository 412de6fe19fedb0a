//! A folder of BSDFs with records beside them.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use bsdfkit::{Error, Result};
use bsdfkit_represent::{Progress, Watch};
use rayon::prelude::*;

use crate::entry::Entry;
use crate::index::{Index, Read};
use crate::look::Look;
use crate::name::slug;
use crate::picture;
use crate::scan::{Group, scan};

/// A material that could not be read.
#[derive(Debug)]
pub struct Fault {
    /// Its files' common name.
    pub stem: String,
    /// What is wrong.
    pub error: Error,
}

/// A folder of BSDFs: its entries, and its index.
#[derive(Debug)]
pub struct Library {
    folder: PathBuf,
    entries: Vec<Entry>,
    /// Stems of the entries.
    stems: Vec<String>,
    index: Index,
    faults: Vec<Fault>,
}

/// Pixels of a picture's side: twice as many as are shown, for fine screens.
const PICTURE: usize = 240;

impl Library {
    /// Opens a folder: what changed since its index was written is read anew, on all threads.
    ///
    /// Files that cannot be read are faults, and left out. Only BSDFs in XML, containers of ours and SIR files are looked at.
    /// Cost: a file 10 ms and what reading it takes; unchanged ones some microseconds.
    ///
    /// Errors: io; argument where `folder` is none; as [`Watch`] when cancelled.
    pub fn open(folder: &Path, watch: &Watch<'_>) -> Result<Self> {
        let is_folder =
            std::fs::metadata(folder).map_err(|e| Error::io(folder.display(), &e))?.is_dir();
        if !is_folder {
            return Err(Error::argument("expected a folder of BSDFs").context(folder.display()));
        }
        let groups = scan(folder)?;
        let mut index = Index::open(folder)?;
        let known: HashMap<String, String> = index.prints()?.into_iter().collect();
        let changed: Vec<&Group> = groups
            .iter()
            .filter(|g| known.get(&g.stem).is_none_or(|print| *print != g.print))
            .collect();
        let (read, faults) = read_all(folder, &changed, watch)?;
        let there: HashSet<&str> = groups.iter().map(|g| &*g.stem).collect();
        let faulty = faults.iter().map(|fault| &*fault.stem);
        let gone = known.keys().map(|s| &**s).filter(|s| !there.contains(s)).chain(faulty);
        index.replace(gone, &read)?;
        let (stems, mut entries): (Vec<String>, Vec<Entry>) = index.entries()?.into_iter().unzip();
        give_ids(&stems, &mut entries);
        Ok(Self { folder: folder.to_owned(), entries, stems, index, faults })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// All entries, by the names of their files.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// What could not be read.
    pub fn faults(&self) -> &[Fault] {
        &self.faults
    }

    /// The looks of all entries, in their order.
    ///
    /// Errors: io, format.
    pub fn looks(&self) -> Result<Vec<Look>> {
        Ok(self.index.looks()?.into_iter().map(|(_, look)| look).collect())
    }

    /// How far each entry's look is from `like`, in the entries' order.
    ///
    /// Errors: io, format.
    pub(crate) fn distances(&self, like: &Look) -> Result<Vec<Option<f64>>> {
        let (mut all, mut buffer) = (Vec::with_capacity(self.entries.len()), Vec::new());
        self.index.each_look(|bytes| {
            all.push(like.distance_of_bytes(bytes, &mut buffer)?);
            Ok(())
        })?;
        Ok(all)
    }

    /// Numbers of the entries that an FTS5 expression finds, the best first.
    pub(crate) fn matching(&self, expression: &str) -> Result<Vec<usize>> {
        let at = |stem: &String| self.stems.binary_search(stem).ok();
        Ok(self.index.matching(expression)?.iter().filter_map(at).collect())
    }

    /// Pictures of all entries, in their order, as PNG: drawn once, and kept in the index.
    ///
    /// Errors: io, and as the readers of the files.
    pub(crate) fn pictures(&mut self, watch: &Watch<'_>) -> Result<Vec<Vec<u8>>> {
        let keys: Vec<String> = self.entries.iter().map(picture_key).collect();
        let mut all: Vec<Option<Vec<u8>>> =
            keys.iter().map(|key| self.index.picture(key)).collect::<Result<_>>()?;
        let missing: Vec<usize> = (0..all.len()).filter(|&k| all[k].is_none()).collect();
        let done = std::sync::atomic::AtomicUsize::new(0);
        let draw = |&k: &usize| {
            let drawn = picture::sphere(&self.entries[k].best(&self.folder)?, PICTURE)?;
            report(watch, &done, missing.len())?;
            Ok((k, drawn))
        };
        let drawn: Vec<(usize, Vec<u8>)> = missing.par_iter().map(draw).collect::<Result<_>>()?;
        let kept: Vec<(String, Vec<u8>)> =
            drawn.iter().map(|(k, png)| (keys[*k].clone(), png.clone())).collect();
        self.index.keep_pictures(&kept)?;
        for (k, png) in drawn {
            all[k] = Some(png);
        }
        Ok(all.into_iter().flatten().collect())
    }
}

/// Pictures are of the files' bytes, of the size and of how they are drawn.
fn picture_key(entry: &Entry) -> String {
    let hashes: Vec<String> = entry.files.iter().map(|f| f.sha256.to_string()).collect();
    format!("{PICTURE} {} {}", picture::VERSION, hashes.join(" "))
}

fn read_all(
    folder: &Path,
    groups: &[&Group],
    watch: &Watch<'_>,
) -> Result<(Vec<Read>, Vec<Fault>)> {
    let done = std::sync::atomic::AtomicUsize::new(0);
    let read = |group: &&Group| {
        let read = Entry::read(folder, group);
        report(watch, &done, groups.len())?;
        Ok(match read {
            Ok((entry, look)) => {
                let (stem, print) = (group.stem.clone(), group.print.clone());
                Ok(Read { stem, print, entry, look })
            }
            Err(error) => Err(Fault { stem: group.stem.clone(), error }),
        })
    };
    let all: Vec<std::result::Result<Read, Fault>> =
        groups.par_iter().map(read).collect::<Result<_>>()?;
    let (mut read, mut faults) = (Vec::new(), Vec::new());
    for one in all {
        match one {
            Ok(one) => read.push(one),
            Err(fault) => faults.push(fault),
        }
    }
    Ok((read, faults))
}

/// One more is done.
fn report(watch: &Watch<'_>, done: &std::sync::atomic::AtomicUsize, total: usize) -> Result<()> {
    let done = 1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    if let Some(progress) = watch.progress {
        progress(Progress { done, total });
    }
    match watch.cancel {
        Some(cancel) if cancel.load(std::sync::atomic::Ordering::Relaxed) => {
            Err(Error::limit("cancelled"))
        }
        _ => Ok(()),
    }
}

/// Names for addresses, of the files' names: the same as long as those are.
fn give_ids(stems: &[String], entries: &mut [Entry]) {
    let mut taken = HashSet::new();
    for (stem, entry) in stems.iter().zip(entries) {
        let wanted = slug(stem);
        let mut id = wanted.clone();
        let mut next = 2;
        while !taken.insert(id.clone()) {
            id = format!("{wanted}-{next}");
            next += 1;
        }
        entry.id = id;
    }
}
