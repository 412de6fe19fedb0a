//! What became of one job: a small file, written whole, after all that it tells of.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::job::{Content, Job};

/// Its name in the folder of a material.
pub(crate) const FILE: &str = ".batch.json";

/// What became of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Status {
    Done,
    Failed,
}

/// A finished job.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct State {
    /// The job's.
    pub(crate) key: String,
    pub(crate) status: Status,
    /// Why it failed.
    #[serde(default)]
    pub(crate) error: String,
    /// Name, length and hash of each file that it made.
    pub(crate) outputs: Vec<(String, u64, String)>,
    /// Seconds from its start to its end.
    pub(crate) seconds: f64,
    /// What `bsdf fit --json` said.
    #[serde(default)]
    pub(crate) report: Value,
}

impl State {
    /// As it stands in `folder`, if it is whole.
    pub(crate) fn read(folder: &Path) -> Option<Self> {
        serde_json::from_slice(&fs::read(folder.join(FILE)).ok()?).ok()
    }

    /// Whether it says that `job` is done, and all that it made is still in `folder`, byte for byte.
    pub(crate) fn holds(&self, job: &Job, folder: &Path) -> bool {
        let same = |(name, bytes, hash): &(String, u64, String)| {
            Content::of(&folder.join(name)).is_ok_and(|c| c.bytes == *bytes && c.hash == *hash)
        };
        let made = |name: &String| self.outputs.iter().any(|o| o.0 == *name);
        self.status == Status::Done
            && self.key == job.key
            && job.outputs.iter().all(made)
            && self.outputs.iter().all(same)
    }
}
