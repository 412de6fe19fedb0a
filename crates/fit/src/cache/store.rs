//! The folder of finished stages.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::SystemTime;

use bsdfkit::{Error, Result, replace_file};

/// Files of it end so: no other file of the folder is ever read or removed.
const SUFFIX: &str = "stage";
/// Length of the checksum at the head of a file.
const SUM: usize = blake3::OUT_LEN;
/// When it is full, the stages that were longest not used go until so much is left.
const LEFT: f64 = 0.8;

/// A folder of finished stages, bounded in size.
///
/// Several processes may use one folder at once. A stage that cannot be written (full disk, read-only folder) is computed again the
/// next time, and nothing else happens; one that was damaged is computed again, too.
///
/// Stages are trusted as far as their checksum: use a folder that no stranger writes to.
#[derive(Debug)]
pub struct Cache {
    folder: PathBuf,
    most_bytes: u64,
    /// Bytes there were when last counted, and bytes written since.
    held: Mutex<u64>,
}

impl Cache {
    /// Usual bound: 2 GiB, some forty fits of 36 incidences.
    pub const USUAL_BYTES: u64 = 2 << 30;

    /// Opens or makes `folder`.
    ///
    /// Errors: io, where it cannot be made or read.
    pub fn open(folder: &Path, most_bytes: u64) -> Result<Self> {
        let io = |e: std::io::Error| Error::io(folder.display(), &e);
        fs::create_dir_all(folder).map_err(io)?;
        let cache = Self { folder: folder.to_owned(), most_bytes, held: Mutex::new(0) };
        let held = cache.stages().map_err(io)?.iter().map(|s| s.bytes).sum();
        cache.held.lock().map(|mut h| *h = held).unwrap_or_default();
        Ok(cache)
    }

    /// What was kept under `key`, if it is whole.
    pub(super) fn get(&self, key: &blake3::Hash) -> Option<Vec<u8>> {
        let mut file = File::open(self.path(key)).ok()?;
        if file.metadata().ok()?.len() > self.most_bytes {
            return None;
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).ok()?;
        let whole = bytes.len() >= SUM && *blake3::hash(&bytes[SUM..]).as_bytes() == bytes[..SUM];
        if !whole {
            return None;
        }
        // Used now. What cannot be marked goes earlier than it might.
        let _ = file.set_modified(SystemTime::now());
        bytes.drain(..SUM);
        Some(bytes)
    }

    /// Keeps `bytes` under `key`, if that can be done.
    pub(super) fn put(&self, key: &blake3::Hash, bytes: &[u8]) {
        let size = (SUM + bytes.len()) as u64;
        if size > self.most_bytes {
            return;
        }
        let written = replace_file(&self.path(key), |out| {
            out.write_all(blake3::hash(bytes).as_bytes())
                .and_then(|()| out.write_all(bytes))
                .map_err(|e| Error::io("writing", &e))
        });
        let Ok(mut held) = self.held.lock() else { return };
        if written.is_ok() {
            *held += size;
        }
        if *held > self.most_bytes {
            *held = self.shrunk();
        }
    }

    /// Removes the stages that were longest not used; the bytes that are left.
    fn shrunk(&self) -> u64 {
        let Ok(mut stages) = self.stages() else { return 0 };
        stages.sort_by_key(|s| s.used);
        let mut held: u64 = stages.iter().map(|s| s.bytes).sum();
        for stage in stages {
            if held as f64 <= LEFT * self.most_bytes as f64 {
                break;
            }
            // Another process may have been quicker.
            let _ = fs::remove_file(&stage.path);
            held -= stage.bytes;
        }
        held
    }

    fn path(&self, key: &blake3::Hash) -> PathBuf {
        self.folder.join(format!("{}.{SUFFIX}", key.to_hex()))
    }

    fn stages(&self) -> std::io::Result<Vec<Stored>> {
        let mut found = Vec::new();
        for entry in fs::read_dir(&self.folder)? {
            let path = entry?.path();
            if path.extension().is_some_and(|e| e == SUFFIX)
                && let Ok(of) = fs::metadata(&path)
            {
                let used = of.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                found.push(Stored { path, bytes: of.len(), used });
            }
        }
        Ok(found)
    }
}

/// One stage's file.
struct Stored {
    path: PathBuf,
    bytes: u64,
    used: SystemTime,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(n: u32) -> blake3::Hash {
        blake3::hash(&n.to_le_bytes())
    }

    #[test]
    fn what_is_kept_comes_back_and_what_is_damaged_does_not() {
        let folder = tempfile::tempdir().expect("folder");
        let cache = Cache::open(&folder.path().join("new"), 1 << 20).expect("cache");
        assert!(cache.get(&key(1)).is_none());
        cache.put(&key(1), b"lobes");
        cache.put(&key(2), b"");
        assert_eq!(cache.get(&key(1)).as_deref(), Some(&b"lobes"[..]));
        assert_eq!(cache.get(&key(2)).as_deref(), Some(&b""[..]));
        for damaged in [&b"short"[..], &[7; 60]] {
            fs::write(cache.path(&key(1)), damaged).expect("write");
            assert!(cache.get(&key(1)).is_none());
        }
    }

    #[test]
    fn the_folder_stays_within_its_bound_and_nothing_else_in_it_is_touched() {
        let folder = tempfile::tempdir().expect("folder");
        fs::write(folder.path().join("notes.txt"), [0; 5000]).expect("notes");
        let cache = Cache::open(folder.path(), 10_000).expect("cache");
        for n in 0..30 {
            cache.put(&key(n), &[0; 1000]);
            let held: u64 = cache.stages().expect("stages").iter().map(|s| s.bytes).sum();
            assert!(held <= 10_000, "{held}");
        }
        assert!(cache.get(&key(29)).is_some());
        cache.put(&key(99), &[0; 20_000]);
        assert!(cache.get(&key(99)).is_none());
        assert!(folder.path().join("notes.txt").exists());
    }
}
