//! What is to be done for one material: a run of `bsdf fit`, and what tells it from any other.

use std::ffi::OsString;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use bsdfkit::{Error, Result};
use bsdfkit_catalog::Sha256;
use serde::Serialize;

/// A word of the command line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Word {
    /// As it stands.
    Text(String),
    /// The path of an input, by its number.
    Input(usize),
    /// A file to write, beside the others.
    Output(String),
}

/// A file, and what is in it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Content {
    /// Without its folder.
    pub(crate) name: String,
    pub(crate) bytes: u64,
    /// SHA-256, in hexadecimal digits.
    pub(crate) hash: String,
}

impl Content {
    /// Errors: io.
    pub(crate) fn of(path: &Path) -> Result<Self> {
        let io = |e: io::Error| Error::io(path.display(), &e);
        let mut file = File::open(path).map_err(io)?;
        let (hash, bytes) = Sha256::of_reader(&mut file).map_err(io)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, bytes, hash: hash.to_string() })
    }
}

/// What a word of the command line names: a file, or a folder with what `bsdf fit` looks at in it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Input {
    /// Absolute.
    pub(crate) path: PathBuf,
    pub(crate) folder: bool,
    pub(crate) files: Vec<Content>,
}

impl Input {
    /// Reads all of it, for the hashes.
    ///
    /// Errors: io.
    pub(crate) fn of(path: PathBuf) -> Result<Self> {
        let io = |e: io::Error| Error::io(path.display(), &e);
        let folder = path.metadata().map_err(io)?.is_dir();
        let mut paths = vec![path.clone()];
        if folder {
            let entries = path.read_dir().map_err(io)?;
            paths = entries.map(|e| Ok(e.map_err(io)?.path())).collect::<Result<_>>()?;
            paths.retain(|p| {
                let hidden = p.file_name().is_some_and(|n| n.as_encoded_bytes().starts_with(b"."));
                !hidden && p.is_file()
            });
            paths.sort();
        }
        let files = paths.iter().map(|p| Content::of(p)).collect::<Result<_>>()?;
        Ok(Self { path, folder, files })
    }
}

/// One material's run of `bsdf fit`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Job {
    pub(crate) name: String,
    /// After `fit`.
    pub(crate) words: Vec<Word>,
    pub(crate) inputs: Vec<Input>,
    /// Files that it makes.
    pub(crate) outputs: Vec<String>,
    /// What people say of the material, for a catalogue.
    pub(crate) record: String,
    /// Hash of all that decides what it makes: contents, settings, the version of this library.
    pub(crate) key: String,
}

impl Job {
    pub(crate) fn new(
        name: String,
        words: Vec<Word>,
        inputs: Vec<Input>,
        outputs: Vec<String>,
        record: String,
    ) -> Self {
        let contents: Vec<&[Content]> = inputs.iter().map(|i| &*i.files).collect();
        let all = (env!("CARGO_PKG_VERSION"), &name, &words, contents, &outputs, &record);
        let text = serde_json::to_vec(&all).unwrap_or_default();
        let key = Sha256::of(&text).to_string();
        Self { name, words, inputs, outputs, record, key }
    }

    /// The command line after `bsdf`, that writes into `folder`.
    pub(crate) fn command(&self, folder: &Path) -> Vec<OsString> {
        let word = |word: &Word| match word {
            Word::Text(text) => text.into(),
            Word::Input(k) => self.inputs[*k].path.clone().into(),
            Word::Output(file) => folder.join(file).into(),
        };
        std::iter::once("fit".into()).chain(self.words.iter().map(word)).collect()
    }

    /// Name of the log.
    pub(crate) fn log(&self) -> String {
        format!("{}.log", self.name)
    }

    /// Name of the record.
    pub(crate) fn sidecar(&self) -> String {
        format!("{}.json", self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_is_known_by_contents_and_settings_not_by_places_and_times() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, text).unwrap();
            path
        };
        let key = |paths: &[PathBuf], option: &str, name: &str| {
            let inputs = paths.iter().map(|p| Input::of(p.clone()).unwrap()).collect();
            let words = vec![Word::Text(option.into())];
            Job::new(name.into(), words, inputs, vec!["a.xml".into()], "{}".into()).key
        };
        let (a, moved) = (file("1/a.txt", "one"), file("2/a.txt", "one"));
        let (other, renamed) = (file("3/a.txt", "two"), file("1/b.txt", "one"));
        let usual = key(std::slice::from_ref(&a), "--x", "m");
        assert_eq!(usual, key(&[moved], "--x", "m"));
        for changed in [
            key(&[other], "--x", "m"),
            key(&[renamed], "--x", "m"),
            key(&[a.clone(), a.clone()], "--x", "m"),
            key(std::slice::from_ref(&a), "--y", "m"),
            key(&[a], "--x", "n"),
        ] {
            assert_ne!(usual, changed);
        }
        // Of a folder what fit looks at: no hidden files, no folders in it.
        file("4/.hidden", "x");
        file("4/deeper/c.txt", "x");
        file("4/d.txt", "x");
        let input = Input::of(folder.path().join("4")).unwrap();
        assert_eq!(input.files.iter().map(|f| &*f.name).collect::<Vec<_>>(), ["d.txt"]);
    }
}
