//! Jobs as processes of this machine, some at once.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::Sender;
use std::thread;
use std::time::{Duration, Instant};

use bsdfkit::{Error, Result};

use super::folder::{Ended, Folder, REPORT};
use super::job::Job;
use super::stopping::stopped;
use crate::terminal::ward;

/// Between two looks at a process: doubled, a batch of quick jobs takes 1 % longer.
const LOOK: Duration = Duration::from_millis(5);
/// Bytes of a log that are looked through for what went wrong.
const TAIL: usize = 16 << 10;

/// How processes share the machine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Share {
    /// At once.
    pub(crate) processes: usize,
    /// Of each.
    pub(crate) threads: usize,
}

impl Share {
    /// Of a machine of `processors` for `jobs` jobs, as asked for or so that every processor has one thread.
    pub(crate) fn of(
        processors: usize,
        jobs: usize,
        processes: Option<usize>,
        threads: Option<usize>,
    ) -> Self {
        let most = threads.map_or(processors, |t| (processors / t).max(1));
        let processes = processes.unwrap_or(most).clamp(1, jobs.max(1));
        Self { processes, threads: threads.unwrap_or((processors / processes).max(1)) }
    }
}

/// Runs `jobs` by `bsdf` with `options` after their own; whatever ends is sent with its number. Returns when all did, or soon after
/// somebody asked for the end.
pub(crate) fn run(
    jobs: &[&Job],
    folder: &Folder,
    share: Share,
    options: &[String],
    sender: &Sender<(usize, Ended)>,
) {
    let next = AtomicUsize::new(0);
    let work = || {
        while !stopped() {
            let k = next.fetch_add(1, Ordering::Relaxed);
            let Some(job) = jobs.get(k) else { break };
            let began = Instant::now();
            let error = match one(job, folder, share.threads, options) {
                Ok(Some(error)) => error,
                Ok(None) => break,
                Err(e) => e.to_string(),
            };
            let seconds = began.elapsed().as_secs_f64();
            if sender.send((k, Ended { error, seconds })).is_err() {
                break;
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..share.processes {
            scope.spawn(work);
        }
    });
}

/// Runs one job; what went wrong, empty if nothing; `None` if it was stopped.
fn one(job: &Job, folder: &Folder, threads: usize, options: &[String]) -> Result<Option<String>> {
    let part = folder.part(job)?;
    let log = part.join(job.log());
    let io = |path: &Path, e: std::io::Error| Error::io(path.display(), &e);
    let mut words = job.command(&part);
    words.extend(options.iter().map(Into::into));
    words.extend([format!("--threads={threads}").into(), "--json".into()]);
    let mut said = File::create(&log).map_err(|e| io(&log, e))?;
    let line: Vec<String> = words.iter().map(|w| quoted(&w.to_string_lossy())).collect();
    writeln!(said, "bsdf {}", line.join(" ")).map_err(|e| io(&log, e))?;
    let report = part.join(REPORT);
    let report = File::create(&report).map_err(|e| io(&report, e))?;
    let bsdf = std::env::current_exe().map_err(|e| Error::io("bsdf", &e))?;
    let mut command = Command::new(bsdf);
    command.args(&words).stdout(report).stderr(said);
    let mut process = ward::bind(&mut command).spawn().map_err(|e| Error::io("bsdf fit", &e))?;
    loop {
        if let Some(status) = process.try_wait().map_err(|e| Error::io("bsdf fit", &e))? {
            // On a terminal the process is asked to end as we are.
            let interrupted = stopped() && !status.success();
            return Ok((!interrupted).then(|| fault(status.code(), &log)));
        }
        if stopped() {
            let _ = process.kill();
            let _ = process.wait();
            return Ok(None);
        }
        thread::sleep(LOOK);
    }
}

/// What went wrong in a process that ended with `code` (`None`: by a signal) and wrote `log`; empty: nothing.
pub(crate) fn fault(code: Option<i32>, log: &Path) -> String {
    if code == Some(0) {
        return String::new();
    }
    let bytes = std::fs::read(log).unwrap_or_default();
    let tail = String::from_utf8_lossy(&bytes[bytes.len().saturating_sub(TAIL)..]);
    let said = tail.lines().rev().find_map(|line| line.strip_prefix("bsdf: "));
    match (said, code) {
        (Some(said), _) => said.to_owned(),
        (None, Some(code)) => format!("expected bsdf fit to say why it failed, found exit status {code}; see its log"),
        (None, None) => "expected bsdf fit to end by itself, found it killed: no memory left, or somebody killed it".to_owned(),
    }
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "/._-=:,+".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processors_are_shared_out_once() {
        let share = |processors, jobs, processes, threads| {
            let s = Share::of(processors, jobs, processes, threads);
            (s.processes, s.threads)
        };
        assert_eq!(share(8, 100, None, None), (8, 1));
        assert_eq!(share(8, 3, None, None), (3, 2));
        assert_eq!(share(8, 100, Some(2), None), (2, 4));
        assert_eq!(share(8, 100, None, Some(4)), (2, 4));
        assert_eq!(share(2, 1, Some(9), None), (1, 2));
        assert_eq!(share(2, 100, Some(5), None), (5, 1));
        assert_eq!(share(2, 100, None, Some(4)), (1, 4));
    }

    #[test]
    fn words_come_back_from_a_shell() {
        assert_eq!(quoted("a/b-c=1.5"), "a/b-c=1.5");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted(""), "''");
    }
}
