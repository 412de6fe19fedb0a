//! What was found in one file, and how it is told.

use std::io::{self, Write};
use std::path::Path;

use bsdfkit::xml::doctor::{ENERGY_TOLERANCE, Finding, Harm, Mends, Program};
use bsdfkit::{DVec3, Error};
use bsdfkit_sphere::direction::to_degrees;
use serde_json::{Value, json};

/// What was found in one file.
#[derive(Default)]
pub(super) struct Report {
    /// Each alone makes the verdict negative.
    pub(super) faults: Vec<String>,
    /// Worth knowing.
    pub(super) remarks: Vec<String>,
    pub(super) energy: Vec<Energy>,
    /// (component, disagreement of f(wi, wo) and f(wo, wi): 0 none, 1 complete).
    pub(super) reciprocity: Vec<(String, f64)>,
    /// Of XML, with the programs that each breaks.
    pub(super) findings: Vec<Finding>,
    /// Why the file cannot be read.
    pub(super) error: Option<Error>,
    /// The program that it is for.
    program: Option<Program>,
}

/// The largest total of a component.
pub(super) struct Energy {
    pub(super) place: String,
    pub(super) total: f64,
    /// Its incidence.
    pub(super) wi: DVec3,
    /// Whether it is only what was seen of it.
    pub(super) extrapolated: bool,
}

/// Findings that make the verdict negative whatever the file is for.
const FAULTS: [&str; 2] = ["energy", "exchanged-sides"];

impl Report {
    /// Turns totals above one into faults, and leaves out what does not matter to `program`.
    pub(super) fn judged(mut self, program: Option<Program>) -> Self {
        self.program = program;
        self.findings.retain(|f| f.matters(program));
        let told = self.findings.iter().any(|f| FAULTS.contains(&f.kind.code));
        for Energy { place, total, wi, .. } in self.energy.iter().filter(|_| !told) {
            if total.is_nan() || *total > 1.0 + ENERGY_TOLERANCE {
                let (theta, phi) = to_degrees(*wi);
                self.faults.push(format!(
                    "{place}: scatters {total:.4} of the light at theta {theta:.0} phi {phi:.0}, expected at most 1"
                ));
            }
        }
        self
    }

    /// Whether a finding makes the verdict negative.
    fn is_fault(&self, finding: &Finding) -> bool {
        FAULTS.contains(&finding.kind.code) || self.program.is_some_and(|p| finding.kind.breaks(p))
    }

    pub(super) fn is_good(&self) -> bool {
        self.faults.is_empty() && !self.findings.iter().any(|f| self.is_fault(f))
    }

    fn verdict(&self) -> &'static str {
        match (&self.error, self.is_good()) {
            (Some(_), _) => "unreadable",
            (None, true) => "good",
            (None, false) => "bad",
        }
    }

    pub(super) fn print(&self, out: &mut impl Write, file: &Path) -> io::Result<()> {
        let of = self.program.map(|p| format!(" for {}", p.name())).unwrap_or_default();
        writeln!(out, "{}: {}{of}", file.display(), self.verdict())?;
        self.faults.iter().try_for_each(|f| writeln!(out, "  fault: {f}"))?;
        let (faults, others): (Vec<_>, Vec<_>) =
            self.findings.iter().partition(|f| self.is_fault(f));
        // Why a file cannot be read is said on standard error.
        let told = |f: &&&Finding| self.error.is_none() || !f.place.is_empty();
        faults.iter().filter(told).try_for_each(|f| self.finding(out, "fault", f))?;
        for Energy { place, total, wi, extrapolated } in &self.energy {
            let theta = to_degrees(*wi).0;
            let how = if *extrapolated { "of the part seen, scatters into it" } else { "scatters" };
            writeln!(out, "  {place}: {how} at most {total:.4} (theta {theta:.0})")?;
        }
        for (place, defect) in &self.reciprocity {
            writeln!(out, "  {place}: reciprocal but for {:.1} %", 100.0 * defect)?;
        }
        others.iter().filter(told).try_for_each(|f| self.finding(out, "remark", f))?;
        self.remarks.iter().try_for_each(|r| writeln!(out, "  remark: {r}"))
    }

    /// What was found, what each program does about it, and what to do.
    fn finding(&self, out: &mut impl Write, label: &str, finding: &Finding) -> io::Result<()> {
        let place = match finding.place.as_str() {
            "" => String::new(),
            place => format!("{place}: "),
        };
        writeln!(out, "  {label}: {place}{} [{}]", finding.text, finding.kind.code)?;
        let kind = finding.kind;
        for harm in
            kind.harms.iter().filter(|h| self.program.is_none_or(|p| h.programs.contains(&p)))
        {
            writeln!(out, "    {}: {}", self.programs(harm), harm.text)?;
        }
        let mended = match kind.mends {
            Mends::Always(_) => " (`--fix` does)",
            _ => "",
        };
        writeln!(out, "    to do: {}{mended}", kind.remedy)
    }

    fn programs(&self, harm: &Harm) -> String {
        match self.program {
            Some(program) => program.name().to_owned(),
            None if harm.programs.len() == Program::ALL.len() => "every program".to_owned(),
            None => harm.programs.iter().map(|p| p.name()).collect::<Vec<_>>().join(", "),
        }
    }

    pub(super) fn json(&self, file: &Path) -> Value {
        let energy = |Energy { place, total, wi, extrapolated }: &Energy| {
            let (theta, phi) = to_degrees(*wi);
            json!({
                "component": place, "largest": total, "theta_degrees": theta, "phi_degrees": phi,
                "of_the_part_seen": extrapolated
            })
        };
        let defect = |(place, d): &(String, f64)| json!({"component": place, "defect": d});
        let text = |f: &Finding| match f.place.as_str() {
            "" => f.text.clone(),
            place => format!("{place}: {}", f.text),
        };
        let (faults, others): (Vec<_>, Vec<_>) =
            self.findings.iter().partition(|f| self.is_fault(f));
        let faults = self.faults.iter().cloned().chain(faults.into_iter().map(text));
        let remarks = self.remarks.iter().cloned().chain(others.into_iter().map(text));
        json!({
            "file": file.display().to_string(),
            "for": self.program.map(Program::name),
            "verdict": self.verdict(),
            "error": self.error.as_ref().map(ToString::to_string),
            "faults": faults.collect::<Vec<_>>(),
            "remarks": remarks.collect::<Vec<_>>(),
            "findings": self.findings.iter().map(finding_json).collect::<Vec<_>>(),
            "energy": self.energy.iter().map(energy).collect::<Vec<_>>(),
            "reciprocity": self.reciprocity.iter().map(defect).collect::<Vec<_>>(),
        })
    }
}

/// A finding for a program.
pub(super) fn finding_json(finding: &Finding) -> Value {
    let kind = finding.kind;
    let mut programs = serde_json::Map::new();
    for (harm, program) in kind.harms.iter().flat_map(|h| h.programs.iter().map(move |p| (h, p))) {
        let what = json!({"how": harm.how.name(), "text": harm.text});
        programs.insert(program.name().to_owned(), what);
    }
    json!({
        "code": kind.code,
        "place": finding.place,
        "text": finding.text,
        "programs": programs,
        "to_do": kind.remedy,
        "mended": kind.mends.name(),
    })
}
