//! What became of every material: a table on the terminal, a file for programs, a page for people.

mod figures;
mod page;

use std::io::{self, Write};
use std::path::Path;

use bsdfkit::{Error, Result};
use serde_json::{Value, json};

use super::folder::{Folder, write};
use super::job::Job;
use super::state::{State, Status};
use crate::terminal::table::Table;
use figures::Figures;

/// Names of the files.
pub(crate) const FILES: [&str; 2] = ["summary.csv", "summary.html"];

/// One material.
#[derive(Debug)]
pub(crate) struct Line<'a> {
    pub(crate) job: &'a Job,
    /// `None`: not begun, or stopped.
    pub(crate) state: Option<State>,
}

impl Line<'_> {
    fn status(&self) -> &'static str {
        match self.state.as_ref().map(|s| s.status) {
            Some(Status::Done) => "done",
            Some(Status::Failed) => "failed",
            None => "to do",
        }
    }

    fn error(&self) -> &str {
        self.state.as_ref().map_or("", |s| &s.error)
    }

    fn figures(&self) -> Figures {
        self.state.as_ref().map(Figures::of).unwrap_or_default()
    }

    fn files(&self) -> impl Iterator<Item = &str> {
        self.state.iter().flat_map(|s| s.outputs.iter().map(|o| &*o.0))
    }
}

/// Prints what a person wants to see: a row a material, what went wrong, how many are done.
///
/// Errors: of writing.
pub(crate) fn print(lines: &[Line<'_>], out: &mut impl Write) -> io::Result<()> {
    let heads =
        ["material", "status", "points", "fit error", "between", "energy", "time s", "CPU s", "MB"];
    let mut table = Table::new(heads);
    for line in lines {
        let f = line.figures();
        let cells = [
            line.job.name.clone(),
            line.status().to_owned(),
            f.points.map(|n| n.to_string()).unwrap_or_default(),
            digits(f.fit_error, 4),
            digits(f.between, 4),
            digits(f.energy, 4),
            digits(f.seconds, 1),
            digits(f.cpu_seconds, 1),
            digits(f.peak_bytes.map(|b| b / 1e6), 0),
        ];
        table.row(cells);
    }
    table.print(out, 0)?;
    for line in lines.iter().filter(|l| !l.error().is_empty()) {
        writeln!(out, "{}: {}", line.job.name, line.error())?;
    }
    let count = |status| lines.iter().filter(|l| l.status() == status).count();
    let [done, failed, left] = ["done", "failed", "to do"].map(count);
    writeln!(out, "{done} done, {failed} failed, {left} to do")
}

/// The same for a program.
pub(crate) fn json(lines: &[Line<'_>]) -> Value {
    let one = |line: &Line<'_>| {
        let f = line.figures();
        json!({
            "material": line.job.name, "status": line.status(), "error": line.error(),
            "components": f.components, "incidences": f.incidences, "points": f.points, "lobes": f.lobes,
            "fit_error": f.fit_error, "between": f.between, "energy": f.energy,
            "seconds": f.seconds, "cpu_seconds": f.cpu_seconds, "peak_bytes": f.peak_bytes,
            "files": line.files().collect::<Vec<_>>(),
        })
    };
    lines.iter().map(one).collect()
}

/// Writes both files into `folder`.
///
/// Errors: io.
pub(crate) fn save(lines: &[Line<'_>], folder: &Folder) -> Result<()> {
    let [csv, html] = FILES.map(|name| folder.root().join(name));
    write(&csv, &self::csv(lines).map_err(|e| Error::io(csv.display(), &io::Error::other(e)))?)?;
    write(&html, page::page(lines).as_bytes())
}

fn csv(lines: &[Line<'_>]) -> std::result::Result<Vec<u8>, csv::Error> {
    let mut out = csv::Writer::from_writer(Vec::new());
    out.write_record([
        "material",
        "status",
        "components",
        "incidences",
        "points",
        "lobes",
        "fit_error",
        "between",
        "energy",
        "seconds",
        "cpu_seconds",
        "peak_bytes",
        "files",
        "error",
    ])?;
    for line in lines {
        let f = line.figures();
        let count = |n: Option<u64>| n.map(|n| n.to_string()).unwrap_or_default();
        let number = |x: Option<f64>| x.map(|x| x.to_string()).unwrap_or_default();
        let path = |file: &str| format!("{}/{file}", line.job.name);
        out.write_record([
            line.job.name.clone(),
            line.status().to_owned(),
            f.components.join(" | "),
            count(f.incidences),
            count(f.points),
            count(f.lobes),
            number(f.fit_error),
            number(f.between),
            number(f.energy),
            number(f.seconds),
            number(f.cpu_seconds),
            number(f.peak_bytes),
            line.files().map(path).collect::<Vec<_>>().join(" | "),
            harmless(line.error()),
        ])?;
    }
    Ok(out.into_inner().unwrap_or_default())
}

/// A text that no spreadsheet takes for a formula.
fn harmless(text: &str) -> String {
    let formula = text.starts_with(['=', '+', '-', '@', '\t']);
    if formula { format!("'{text}") } else { text.to_owned() }
}

fn digits(x: Option<f64>, digits: usize) -> String {
    x.map(|x| format!("{x:.digits$}")).unwrap_or_default()
}

/// Where the files are, in words.
pub(crate) fn places(root: &Path) -> String {
    FILES.map(|name| root.join(name).display().to_string()).join(", ")
}
