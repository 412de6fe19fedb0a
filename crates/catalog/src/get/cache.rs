//! Files that were verified, by their hashes.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use bsdfkit::{Error, Result};

use super::Got;
use crate::hash::{Hashing, Sha256};
use crate::name::expect_plain;

/// Bytes of one file, unless asked for more.
pub const MOST_BYTES: u64 = 1 << 30;

/// Names the folder of the cache.
const VARIABLE: &str = "BSDFKIT_CACHE";

/// A folder with a folder for each hash, in which the file lies under its name.
#[derive(Clone, Debug)]
pub struct Cache {
    /// The folder.
    pub folder: PathBuf,
    /// Larger files are refused.
    pub most_bytes: u64,
}

/// Opens what is fetched, of which at most so many bytes are wanted.
type Open<'a> = dyn Fn(u64) -> Result<Box<dyn Read>> + 'a;

impl Cache {
    /// The usual one: what `BSDFKIT_CACHE` names, else `bsdfkit` where the system keeps caches.
    ///
    /// Errors: argument, where there is no home to keep it in.
    pub fn usual() -> Result<Self> {
        let variable =
            |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
        let home = |below: &str| std::env::home_dir().map(|home| home.join(below));
        let system = || match () {
            () if cfg!(windows) => variable("LOCALAPPDATA"),
            () if cfg!(target_os = "macos") => home("Library/Caches"),
            () => variable("XDG_CACHE_HOME").or_else(|| home(".cache")),
        };
        let folder = variable(VARIABLE).or_else(|| system().map(|folder| folder.join("bsdfkit")));
        let folder = folder.ok_or_else(|| {
            Error::argument(format!("cache: expected a home or the variable {VARIABLE}"))
        })?;
        Ok(Self { folder, most_bytes: MOST_BYTES })
    }

    /// The file with that hash: from here if it lies here and still is what it was, else from `open`.
    ///
    /// `bytes`: how many it is said to have. What fails leaves nothing behind.
    pub(super) fn fetch(
        &self,
        name: &str,
        sha256: Sha256,
        bytes: Option<u64>,
        open: &Open<'_>,
    ) -> Result<Got> {
        expect_plain(name)?;
        let folder = self.folder.join(sha256.to_string());
        let path = folder.join(name);
        let got = |cached| Got { path: path.clone(), name: name.to_owned(), sha256, cached };
        if File::open(&path)
            .and_then(|mut f| Sha256::of_reader(&mut f))
            .is_ok_and(|h| h.0 == sha256)
        {
            return Ok(got(true));
        }
        let most = bytes.unwrap_or(self.most_bytes);
        if most > self.most_bytes {
            let text = format!("expected at most {} bytes, found {most}", self.most_bytes);
            return Err(Error::limit(text));
        }
        let io = |e: std::io::Error| Error::io(folder.display(), &e);
        fs::create_dir_all(&self.folder).map_err(io)?;
        let mut making = tempfile::NamedTempFile::new_in(&self.folder).map_err(io)?;
        let found = copy(&mut *open(most)?, making.as_file_mut(), most)?;
        expect(found, sha256, bytes)?;
        fs::create_dir_all(&folder).map_err(io)?;
        making.persist(&path).map_err(|e| io(e.error))?;
        Ok(got(false))
    }
}

impl Got {
    /// Copies it into a folder under its name: whole, or not at all.
    ///
    /// Errors: io.
    pub fn copy_into(&self, folder: &Path) -> Result<PathBuf> {
        fs::create_dir_all(folder).map_err(|e| Error::io(folder.display(), &e))?;
        let to = folder.join(&self.name);
        let mut from = File::open(&self.path).map_err(|e| Error::io(self.path.display(), &e))?;
        bsdfkit::replace_file(&to, |out| {
            std::io::copy(&mut from, out).map(drop).map_err(|e| Error::io("copying", &e))
        })?;
        Ok(to)
    }
}

/// Copies all there is, but refuses more than `most` bytes.
fn copy(source: &mut dyn Read, target: &mut File, most: u64) -> Result<(Sha256, u64)> {
    let mut hashing = Hashing::default();
    let mut block = vec![0; 1 << 16];
    loop {
        let n = source.read(&mut block).map_err(|e| Error::io("fetching", &e))?;
        if n == 0 {
            return Ok(hashing.end());
        }
        hashing.add(&block[..n]);
        if hashing.bytes() > most {
            return Err(Error::limit(format!("expected at most {most} bytes, found more")));
        }
        target.write_all(&block[..n]).map_err(|e| Error::io("cache", &e))?;
    }
}

fn expect((found, length): (Sha256, u64), sha256: Sha256, bytes: Option<u64>) -> Result<()> {
    if let Some(bytes) = bytes.filter(|bytes| *bytes != length) {
        return Err(Error::format(format!("expected {bytes} bytes, found {length}: refused")));
    }
    if found != sha256 {
        return Err(Error::format(format!(
            "expected SHA-256 {sha256}, found {found}: the file was changed or damaged, and is refused"
        )));
    }
    Ok(())
}
