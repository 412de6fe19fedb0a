//! `bsdf batch`: a fit a material, for as many as a manifest names.

use std::io::{self, BufWriter, Write};
use std::path::PathBuf;
use std::sync::mpsc::channel;
use std::thread;

use bsdfkit::Error;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use crate::batch::folder::{Ended, Folder};
use crate::batch::job::Job;
use crate::batch::local::{self, Share};
use crate::batch::manifest::Manifest;
use crate::batch::state::{State, Status};
use crate::batch::stopping;
use crate::batch::summary::{self, Line};
use crate::batch::{dask, material};
use crate::terminal::stop::{Outcome, Stop, Verdict, complain};
use crate::verbs::fit::gigabytes;

const EXAMPLES: &str = "\
A manifest in TOML (in CSV: a head of the same keys, a row a material, lists parted by |):
  [defaults]
  outputs = [\"interpolant\", \"radiance\", \"window\"]

  [[material]]
  name = \"fabric-12\"
  measurements = [\"fabric12/*.txt\"]
  symmetry = \"isotropic\"
  title = \"Fabric 12, white\"

Keys: name, measurements (files, folders, patterns, beside the manifest), outputs (forms, programs, PROGRAM:FORM), title, maker,
class, instrument, date, licence, doi, notes, and the options of `bsdf fit` (symmetry, aperture, max_leaves, …).

Examples:
  bsdf batch materials.toml -o fitted
  bsdf batch materials.csv -o fitted --jobs 4 --cache ~/.cache/bsdfkit
  bsdf batch materials.toml -o fitted --scheduler tcp://10.0.0.1:8786";

/// What is told at once of a manifest's faults.
const MOST_FAULTS: usize = 20;

/// Fit many materials, each by a process of its own
///
/// DIR gets a folder a material, with its files, a record and a log, and summary.csv and summary.html. What is done
/// is known by the contents of its measurements, its settings and the version of this program: the same command goes
/// on where it was stopped, however it was, and fits again what changed. One material that fails stops no other.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// What to fit: a file named .toml or .csv
    manifest: PathBuf,
    /// Folder for all of it
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Processes at once [default: one a processor, or a processor for every --threads]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024), conflicts_with = "scheduler")]
    jobs: Option<u16>,
    /// Threads of each process [default: so many that every processor has one; 1 with --scheduler]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Keep finished stages of fits in this folder, as `bsdf fit --cache` does: a fit that was killed goes on where it was
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Most gigabytes in that folder
    #[arg(long, value_name = "GB", default_value_t = 2.0, requires = "cache", value_parser = gigabytes)]
    cache_size: f64,
    /// Hand the fits to the workers of a scheduler of Dask, through the Python package (`pip install 'bsdfkit[dask]'`)
    #[arg(long, value_name = "ADDRESS")]
    scheduler: Option<String>,
    /// Seconds to wait for a first worker
    #[arg(long, value_name = "S", default_value_t = 60.0, requires = "scheduler")]
    patience: f64,
    /// Check the manifest and tell what is to do, no more
    #[arg(long)]
    dry_run: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let jobs = jobs(arguments)?;
    if arguments.dry_run && !arguments.output.exists() {
        let line = |job| Line { job, state: None };
        summary::print(&jobs.iter().map(line).collect::<Vec<_>>(), &mut io::stdout().lock())?;
        return Ok(Verdict::Good);
    }
    let folder = Folder::open(&arguments.output)?;
    let mut lines: Vec<Line<'_>> =
        jobs.iter().map(|job| Line { job, state: folder.finished(job) }).collect();
    let left: Vec<usize> = (0..jobs.len()).filter(|&k| lines[k].state.is_none()).collect();
    let mut ended = Ok(());
    if !arguments.dry_run && !left.is_empty() {
        stopping::listen()?;
        let to_do: Vec<&Job> = left.iter().map(|&k| &jobs[k]).collect();
        let told = Told::new(to_do.len());
        ended = work(arguments, &to_do, &folder, |k, state| {
            told.tell(to_do[k], &state);
            lines[left[k]].state = Some(state);
        });
        folder.clear();
    }
    let mut out = BufWriter::new(io::stdout().lock());
    if arguments.dry_run {
        summary::print(&lines, &mut out)?;
        return Ok(Verdict::Good);
    }
    summary::save(&lines, &folder)?;
    if arguments.json {
        writeln!(out, "{}", summary::json(&lines))?;
    } else {
        summary::print(&lines, &mut out)?;
        writeln!(out, "{}", summary::places(folder.root()))?;
    }
    out.flush()?;
    ended?;
    if stopping::stopped() {
        let _ = writeln!(io::stderr(), "bsdf: stopped; the same command goes on");
        return Err(Stop::Status(130));
    }
    let done = |line: &Line<'_>| line.state.as_ref().is_some_and(|s| s.status == Status::Done);
    Ok(if lines.iter().all(done) { Verdict::Good } else { Verdict::Bad })
}

/// What the manifest asks for; all that is wrong with it is told.
fn jobs(arguments: &Arguments) -> Outcome<Vec<Job>> {
    let manifest = Manifest::read(&arguments.manifest)?;
    material::jobs(&arguments.manifest, &manifest).map_err(|mut faults| {
        let more = faults.len().saturating_sub(MOST_FAULTS);
        faults.truncate(MOST_FAULTS);
        let last = faults.pop();
        faults.iter().for_each(complain);
        if more > 0 {
            complain(&Error::format(format!("and {more} faults more")));
        }
        last.unwrap_or_else(|| Error::format("manifest")).into()
    })
}

/// Does `jobs`; `each` is told what became of one as soon as its files are where they belong.
fn work(
    arguments: &Arguments,
    jobs: &[&Job],
    folder: &Folder,
    mut each: impl FnMut(usize, State),
) -> Result<(), Stop> {
    let mut options = Vec::new();
    if let Some(cache) = &arguments.cache {
        let cache = std::path::absolute(cache).map_err(|e| Error::io(cache.display(), &e))?;
        options.push(format!("--cache={}", cache.display()));
        options.push(format!("--cache-size={}", arguments.cache_size));
    }
    let (sender, receiver) = channel::<(usize, Ended)>();
    let [processes, threads] = [arguments.jobs, arguments.threads].map(|n| n.map(usize::from));
    thread::scope(|scope| {
        let working = scope.spawn(move || match &arguments.scheduler {
            Some(scheduler) => {
                options.push(format!("--threads={}", threads.unwrap_or(1)));
                dask::run(jobs, folder, scheduler, &options, arguments.patience, &sender)
            }
            None => {
                let processors = thread::available_parallelism().map_or(1, usize::from);
                let share = Share::of(processors, jobs.len(), processes, threads);
                local::run(jobs, folder, share, &options, &sender);
                Ok(())
            }
        });
        for (k, ended) in receiver {
            let (job, seconds) = (jobs[k], ended.seconds);
            let state = folder.finish(job, ended).unwrap_or_else(|e| State {
                key: job.key.clone(),
                status: Status::Failed,
                error: e.to_string(),
                outputs: Vec::new(),
                seconds,
                report: serde_json::Value::Null,
            });
            each(k, state);
        }
        working.join().unwrap_or(Ok(()))
    })
}

/// What is told of jobs while others are under way: a bar on a terminal, a line a job.
struct Told(ProgressBar);

impl Told {
    fn new(jobs: usize) -> Self {
        let style =
            ProgressStyle::with_template("{msg:>24} {wide_bar} {pos}/{len} {elapsed} left {eta}")
                .expect("the template is valid");
        let bar = ProgressBar::new(jobs as u64).with_style(style).with_message("materials");
        bar.enable_steady_tick(std::time::Duration::from_millis(500));
        Self(bar)
    }

    fn tell(&self, job: &Job, state: &State) {
        let line = match state.status {
            Status::Done => format!("{}: done, {:.1} s", job.name, state.seconds),
            Status::Failed => format!("{}: failed: {}", job.name, state.error),
        };
        self.0.suspend(|| {
            let _ = writeln!(io::stderr(), "{line}");
        });
        self.0.inc(1);
    }
}

impl Drop for Told {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
