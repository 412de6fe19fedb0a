//! DIR: a folder a material, in which files appear when all of them are there.

use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use bsdfkit::{Error, Result, replace_file};

use super::job::{Content, Job};
use super::state::{self, State, Status};

/// What jobs under way write into.
const PARTS: &str = ".part";
/// Whoever works in the folder holds it.
const LOCK: &str = ".lock";
/// What `bsdf fit --json` printed.
pub(crate) const REPORT: &str = "report.json";

/// How the process of a job ended.
#[derive(Clone, Debug)]
pub(crate) struct Ended {
    /// Empty: well.
    pub(crate) error: String,
    /// Seconds from its start.
    pub(crate) seconds: f64,
}

/// The folder of a batch, held by this process alone.
#[derive(Debug)]
pub(crate) struct Folder {
    root: PathBuf,
    _lock: File,
}

impl Folder {
    /// Opens or makes `root`, and clears away what a killed batch left half-made.
    ///
    /// Errors: io; argument where another batch works in it.
    pub(crate) fn open(root: &Path) -> Result<Self> {
        let io = |e: io::Error| Error::io(root.display(), &e);
        fs::create_dir_all(root).map_err(io)?;
        let root = std::path::absolute(root).map_err(io)?;
        let options =
            File::options().create(true).truncate(false).write(true).open(root.join(LOCK));
        let lock = options.map_err(io)?;
        match lock.try_lock() {
            // File systems without locks have no second batch told apart.
            Ok(()) | Err(TryLockError::Error(_)) => {}
            Err(TryLockError::WouldBlock) => {
                let text = format!(
                    "{}: expected a folder to work in alone, found another bsdf batch at work in it",
                    root.display()
                );
                return Err(Error::argument(text));
            }
        }
        let folder = Self { root, _lock: lock };
        folder.clear();
        Ok(folder)
    }

    /// Where it is: absolute.
    pub(crate) fn root(&self) -> &Path {
        &self.root
    }

    /// Where the files of `job` are when it is done.
    pub(crate) fn of(&self, job: &Job) -> PathBuf {
        self.root.join(&job.name)
    }

    /// What is known of `job`: its state, if it is finished and nothing changed since.
    pub(crate) fn finished(&self, job: &Job) -> Option<State> {
        let folder = self.of(job);
        State::read(&folder).filter(|state| state.holds(job, &folder))
    }

    /// A new empty folder for what `job` writes.
    ///
    /// Errors: io.
    pub(crate) fn part(&self, job: &Job) -> Result<PathBuf> {
        let part = self.part_of(job);
        let io = |e: io::Error| Error::io(part.display(), &e);
        if part.exists() {
            fs::remove_dir_all(&part).map_err(io)?;
        }
        fs::create_dir_all(&part).map_err(io)?;
        Ok(part)
    }

    /// The same folder once it is there.
    pub(crate) fn part_of(&self, job: &Job) -> PathBuf {
        self.root.join(PARTS).join(&job.name)
    }

    /// Removes what jobs under way wrote.
    pub(crate) fn clear(&self) {
        // What cannot be removed is made anew by `part`, which says why it cannot.
        let _ = fs::remove_dir_all(self.root.join(PARTS));
    }

    /// Takes what `job` wrote into its part to where it belongs. What it replaces goes first, the state comes last: whenever this is
    /// stopped, the job counts as not begun.
    ///
    /// Errors: io. Whatever is not of the batch in a material's folder stays.
    pub(crate) fn finish(&self, job: &Job, ended: Ended) -> Result<State> {
        let (part, folder) = (self.part_of(job), self.of(job));
        let mut state = State {
            key: job.key.clone(),
            status: Status::Done,
            error: ended.error,
            outputs: Vec::new(),
            seconds: ended.seconds,
            report: report(&part, job),
        };
        if state.error.is_empty() {
            for name in &job.outputs {
                match Content::of(&part.join(name)) {
                    Ok(c) => state.outputs.push((c.name, c.bytes, c.hash)),
                    Err(e) => state.error = e.to_string(),
                }
            }
        }
        if !state.error.is_empty() {
            state.status = Status::Failed;
            state.outputs.clear();
        }
        let io = |path: &Path, e: &io::Error| Error::io(path.display(), e);
        fs::create_dir_all(&folder).map_err(|e| io(&folder, &e))?;
        let path = folder.join(state::FILE);
        let old = State::read(&folder).map(|s| s.outputs).unwrap_or_default();
        remove(&path)?;
        let old = old.iter().map(|o| o.0.as_str()).filter(|name| !name.contains(['/', '\\']));
        for name in old.chain(job.outputs.iter().map(String::as_str)) {
            remove(&folder.join(name))?;
        }
        let (log, sidecar) = (job.log(), job.sidecar());
        let made = state.outputs.iter().map(|o| o.0.as_str());
        for name in made.chain([log.as_str()]) {
            let to = folder.join(name);
            fs::rename(part.join(name), &to).map_err(|e| io(&to, &e))?;
        }
        if state.status == Status::Done {
            write(&folder.join(&sidecar), job.record.as_bytes())?;
        }
        write(&path, serde_json::to_string_pretty(&state).unwrap_or_default().as_bytes())?;
        let _ = fs::remove_dir_all(&part);
        Ok(state)
    }
}

/// Writes a file, whole or not at all.
///
/// Errors: io.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    replace_file(path, |out| out.write_all(bytes).map_err(|e| Error::io("writing", &e)))
}

/// Removes a file that may be there.
fn remove(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(Error::io(path.display(), &e)),
        _ => Ok(()),
    }
}

/// What fit said of itself, files under their names alone: where they were written is gone.
fn report(part: &Path, job: &Job) -> serde_json::Value {
    let bytes = fs::read(part.join(REPORT)).unwrap_or_default();
    let mut report: serde_json::Value = serde_json::from_slice(&bytes).unwrap_or_default();
    if let Some(outputs) = report.get_mut("outputs").and_then(|o| o.as_array_mut()) {
        for (output, name) in outputs.iter_mut().zip(&job.outputs) {
            output["file"] = name.clone().into();
        }
    }
    report
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(option: &str) -> Job {
        Job::new(
            "m".into(),
            vec![super::super::job::Word::Text(option.into())],
            Vec::new(),
            vec!["m.xml".into()],
            "{}".into(),
        )
    }

    fn ran(folder: &Folder, job: &Job, content: &str) {
        let part = folder.part(job).unwrap();
        fs::write(part.join("m.xml"), content).unwrap();
        fs::write(part.join("m.log"), "said").unwrap();
    }

    fn ended(error: &str) -> Ended {
        Ended { error: error.into(), seconds: 1.0 }
    }

    #[test]
    fn a_job_is_finished_while_all_it_made_is_there() {
        let place = tempfile::tempdir().unwrap();
        let folder = Folder::open(&place.path().join("new")).unwrap();
        let (one, other) = (job("--a"), job("--b"));
        assert!(folder.finished(&one).is_none());
        ran(&folder, &one, "tree");
        folder.finish(&one, ended("")).unwrap();
        assert!(folder.finished(&one).is_some() && folder.finished(&other).is_none());
        fs::write(folder.of(&one).join("notes.txt"), "mine").unwrap();
        fs::write(folder.of(&one).join("m.xml"), "tref").unwrap();
        assert!(folder.finished(&one).is_none(), "changed");
        ran(&folder, &one, "tree");
        folder.finish(&one, ended("")).unwrap();
        assert!(folder.finished(&one).is_some());
        // Other settings that fail: nothing is left that could be taken for theirs.
        ran(&folder, &other, "half");
        let state = folder.finish(&other, ended("too dark")).unwrap();
        assert_eq!((state.status, &*state.error), (Status::Failed, "too dark"));
        assert!(!folder.of(&one).join("m.xml").exists() && folder.of(&one).join("m.log").exists());
        assert!(folder.finished(&other).is_none() && folder.of(&one).join("notes.txt").exists());
        // It ended well and wrote nothing.
        let part = folder.part(&one).unwrap();
        fs::write(part.join("m.log"), "").unwrap();
        assert_eq!(folder.finish(&one, ended("")).unwrap().status, Status::Failed);
    }

    #[test]
    fn two_batches_do_not_share_a_folder() {
        let place = tempfile::tempdir().unwrap();
        let first = Folder::open(place.path()).unwrap();
        assert!(Folder::open(place.path()).unwrap_err().to_string().contains("another bsdf batch"));
        drop(first);
        assert!(Folder::open(place.path()).is_ok());
    }
}
