//! `bsdf check --fix`: a corrected copy.

use std::io::Write;
use std::path::Path;

use bsdfkit::xml::{self, Limits, doctor};
use bsdfkit::{Error, replace_file};
use bsdfkit_fit::deliver::{self, Change};
use bsdfkit_represent::Watch;
use serde_json::json;

use super::report::finding_json;
use super::{Arguments, of_examination};
use crate::terminal::stop::{Outcome, Verdict};

pub(super) fn run(arguments: &Arguments, output: &Path, out: &mut impl Write) -> Outcome {
    let [file] = arguments.files.as_slice() else {
        let found = arguments.files.len();
        return Err(Error::argument(format!("--fix: expected one file, found {found}")).into());
    };
    let limits = Limits::default();
    let bytes = xml::bytes_of(file, &limits)?;
    let also: Vec<&str> = arguments.also.iter().map(String::as_str).collect();
    let watch = Watch { progress: None, cancel: None };
    let mended = deliver::mend(&bytes, arguments.program, &also, &limits, &watch)
        .map_err(|e| e.context(format!("{}: not mended", file.display())))?;
    replace_file(output, |to| {
        to.write_all(&mended.bytes).map_err(|e| Error::io(output.display(), &e))
    })?;
    let report = of_examination(doctor::examine(&mended.bytes, &limits), output);
    let report = report.judged(arguments.program);
    if arguments.json {
        let mut told = report.json(output);
        told["mended_from"] = json!(file.display().to_string());
        told["changes"] = mended.changes.iter().map(change_json).collect();
        told["said"] = json!(mended.said);
        writeln!(out, "{told}")?;
    } else {
        for Change { finding, how } in &mended.changes {
            writeln!(out, "mended: {finding}: {how}")?;
        }
        for said in &mended.said {
            writeln!(out, "note: {said}")?;
        }
        if mended.changes.is_empty() {
            writeln!(out, "nothing to mend: {} is a copy", output.display())?;
        }
        report.print(out, output)?;
    }
    Ok(if report.is_good() { Verdict::Good } else { Verdict::Bad })
}

fn change_json(Change { finding, how }: &Change) -> serde_json::Value {
    let mut told = finding_json(finding);
    told["how"] = json!(how);
    told
}
