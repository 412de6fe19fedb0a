//! Jobs on many machines: the Python package hands them to a scheduler of Dask and writes what comes back where we look for it.

use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use bsdfkit::Error;
use serde::{Deserialize, Serialize};

use super::folder::{Ended, Folder, write};
use super::job::Job;
use super::local::fault;
use super::stopping::stopped;
use crate::terminal::python::Module;
use crate::terminal::stop::Stop;

const MODULE: Module = Module {
    name: "bsdfkit.batch",
    verb: "batch --scheduler",
    extra: "dask",
    packages: &["bsdfkit", "distributed"],
};

/// Between two looks whether somebody asked for the end.
const LOOK: Duration = Duration::from_millis(50);

/// What the package reads.
#[derive(Serialize)]
struct Plan<'a> {
    scheduler: &'a str,
    /// What a worker must have: other versions make other bytes.
    version: &'a str,
    /// After the words of each job.
    options: &'a [String],
    /// Seconds to wait for a first worker.
    patience: f64,
    jobs: Vec<Task<'a>>,
}

#[derive(Serialize)]
struct Task<'a> {
    #[serde(flatten)]
    job: &'a Job,
    /// Folder for what it makes.
    part: std::path::PathBuf,
    log: String,
}

/// What the package prints, a line a job.
#[derive(Deserialize)]
struct Line {
    /// Its number.
    job: usize,
    /// Of its process; `None` where a signal ended it or there was none.
    exit: Option<i32>,
    /// Where there was none: what became of it.
    #[serde(default)]
    lost: String,
    seconds: f64,
}

/// Runs `jobs` by the workers of `scheduler`; as [`super::local::run`].
///
/// Errors: argument where the package is missing; what the package says where it ends early.
pub(crate) fn run(
    jobs: &[&Job],
    folder: &Folder,
    scheduler: &str,
    options: &[String],
    patience: f64,
    sender: &Sender<(usize, Ended)>,
) -> std::result::Result<(), Stop> {
    let mut tasks = Vec::new();
    for job in jobs {
        tasks.push(Task { job, part: folder.part(job)?, log: job.log() });
    }
    let version = env!("CARGO_PKG_VERSION");
    let plan = Plan { scheduler, version, options, patience, jobs: tasks };
    let path = folder.root().join(".plan.json");
    write(&path, &serde_json::to_vec(&plan).unwrap_or_default())?;
    let mut package = MODULE.command()?;
    package.arg(&path).stdin(Stdio::null()).stdout(Stdio::piped());
    let io = |e: std::io::Error| Error::io(MODULE.name, &e);
    let mut package = package.spawn().map_err(io)?;
    let Some(stdout) = package.stdout.take() else { return Ok(()) };
    let (lines, arrived) = channel();
    let reading = thread::spawn(move || {
        for line in BufReader::new(stdout).lines().map_while(std::result::Result::ok) {
            if lines.send(line).is_err() {
                break;
            }
        }
    });
    loop {
        match arrived.recv_timeout(LOOK) {
            Ok(line) => {
                let Ok(line) = serde_json::from_str::<Line>(&line) else { continue };
                let Some(job) = jobs.get(line.job) else { continue };
                let error = match line.lost.is_empty() {
                    true => fault(line.exit, &folder.part_of(job).join(job.log())),
                    false => line.lost,
                };
                if sender.send((line.job, Ended { error, seconds: line.seconds })).is_err() {
                    break;
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if stopped() {
            // The scheduler forgets what nobody waits for.
            let _ = package.kill();
            break;
        }
    }
    let status = package.wait().map_err(io)?;
    let _ = reading.join();
    let _ = std::fs::remove_file(&path);
    match status.code() {
        _ if stopped() => Ok(()),
        Some(0) => Ok(()),
        code => Err(Stop::Status(code.and_then(|c| u8::try_from(c).ok()).unwrap_or(2))),
    }
}
