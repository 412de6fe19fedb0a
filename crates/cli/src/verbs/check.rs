//! `bsdf check`: whether a file can be trusted.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use bsdfkit::{Bsdf, Components, DVec2, DVec3, Side, reciprocity};
use bsdfkit_fit::measurement::Measurement;
use bsdfkit_fit::open::Content;
use bsdfkit_fit::tabulate::disagreement;
use bsdfkit_sphere::concentric::square_to_hemisphere;
use bsdfkit_sphere::direction::{from_degrees, to_degrees};
use clap::Args;
use serde_json::json;

use crate::files::component::name;
use crate::files::load::{Loaded, load, measure};
use crate::files::surface::Surface;
use crate::terminal::stop::{Outcome, Stop, Verdict, complain};

const EXAMPLES: &str = "\
Examples:
  bsdf check material.xml
  bsdf check measurements/ material.safetensors material.xml --json";

/// Check structure, energy, reciprocity, negative values and coverage
///
/// The verdict is negative (exit status 1) where an incidence scatters more light than it gets, a
/// value is negative or not finite, or a measurement lacks what its symmetry needs or a lobe does. Reciprocity,
/// what too little was seen of and whatever the reader remarked are reported. A file that cannot be read ends with its own
/// status after the others were checked.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML, interpolants, compiled BSDFs, measurements
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// One JSON object a file
    #[arg(long)]
    json: bool,
}

/// Scattered light beyond the incident that is taken for noise: instruments are calibrated to 1 or 2 %.
const ENERGY_TOLERANCE: f64 = 0.02;

/// What was found in one file.
#[derive(Default)]
struct Findings {
    /// Each alone makes the verdict negative.
    faults: Vec<String>,
    /// Worth knowing.
    remarks: Vec<String>,
    energy: Vec<Energy>,
    /// (component, disagreement of f(wi, wo) and f(wo, wi): 0 none, 1 complete).
    reciprocity: Vec<(String, f64)>,
}

/// The largest total of a component.
struct Energy {
    place: String,
    total: f64,
    /// Its incidence.
    wi: DVec3,
    /// Whether it is only what was seen of it.
    extrapolated: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let mut out = io::stdout().lock();
    let (mut verdict, mut unreadable) = (Verdict::Good, None);
    for file in &arguments.files {
        let found = match examine(file) {
            Ok(found) => found.with_energy_judged(),
            Err(error) => {
                if let Some(earlier) = unreadable.replace(error) {
                    complain(&earlier);
                }
                continue;
            }
        };
        if !found.faults.is_empty() {
            verdict = Verdict::Bad;
        }
        if arguments.json {
            writeln!(out, "{}", found.json(file))?;
        } else {
            found.print(&mut out, file)?;
        }
    }
    unreadable.map_or(Ok(verdict), |error| Err(Stop::Error(error)))
}

fn examine(file: &Path) -> bsdfkit::Result<Findings> {
    if Content::of(file)? != Content::Measurement {
        return Ok(examine_surface(&load(file)?));
    }
    let mut found = Findings::default();
    let paths = [file.to_owned()];
    if let Err(lacking) = measure(&paths, false) {
        found.faults.push(lacking.to_string());
    }
    for m in measure(&paths, true)? {
        examine_measurement(&m, &mut found);
    }
    Ok(found)
}

fn examine_measurement(m: &Measurement, found: &mut Findings) {
    let quality = m.quality();
    found.remarks.extend(quality.notes);
    found.remarks.extend(quality.scant.iter().map(|s| format!("{}: {s}", quality.component)));
    if let Err(few) = m.expect_enough() {
        found.faults.push(few.context(&quality.component).to_string());
    }
    let luminance = m.colorimetry.luminance_channel();
    // Of what was not seen all round, what was seen alone can be too much.
    let total = |k: usize| quality.incidences[k].hemispherical_at_least[luminance];
    let known = (0..m.incidences.len()).filter(|&k| total(k).is_finite());
    if let Some(k) = known.max_by(|&a, &b| total(a).total_cmp(&total(b))) {
        let place = quality.component.clone();
        let extrapolated = quality.incidences[k].extrapolated;
        found.energy.push(Energy { place, total: total(k), wi: m.incidences[k].wi, extrapolated });
    }
    let negatives: usize = quality.incidences.iter().map(|i| i.negatives).sum();
    if negatives > 0 {
        let text =
            format!("{}: {negatives} of {} values negative", quality.component, quality.points);
        found.remarks.push(text);
    }
    let holes = quality.incidences.iter().flat_map(|i| &i.holes).filter(|h| !h.retro_reflection);
    if let Some(h) = holes.max_by(|a, b| a.radius_degrees.total_cmp(&b.radius_degrees)) {
        found.remarks.push(format!(
            "{}: nothing measured within {:.1} degrees of theta {:.0} phi {:.0}",
            quality.component, h.radius_degrees, h.theta_degrees, h.phi_degrees
        ));
    }
}

fn examine_surface(loaded: &Loaded) -> Findings {
    let remarks = loaded.warnings.iter().map(ToString::to_string).collect();
    let mut found = Findings { remarks, ..Findings::default() };
    let surface = &loaded.surface;
    let bsdf = surface.bsdf();
    if surface.pairs().is_empty() {
        found.remarks.push("nothing scatters".into());
    }
    for side in surface.incident_sides() {
        let total = |wi| bsdf.directional_hemispherical(wi, Components::ALL);
        let totals = incidences(side).map(|wi| (total(wi), wi));
        if let Some((most, wi)) = totals.max_by(|a, b| a.0.total_cmp(&b.0)) {
            let place = if side == Side::Front { "front" } else { "back" };
            found.energy.push(Energy {
                place: place.to_owned(),
                total: most,
                wi,
                extrapolated: false,
            });
        }
    }
    for (incident, scattered) in surface.pairs() {
        let defect = match surface {
            Surface::Stored(bsdf) => reciprocity::defect(bsdf, incident, scattered, 4096),
            Surface::Continuous(i) => i.part(incident, scattered).and_then(|p| disagreement(p)),
        };
        found.reciprocity.extend(defect.map(|d| (name(incident, scattered), d)));
        let bad = bad_values(&bsdf, incident, scattered);
        if bad > 0 {
            let place = name(incident, scattered);
            found.faults.push(format!("{place}: {bad} values negative or not finite"));
        }
    }
    found
}

/// Incident directions at which energy is looked at: four azimuths, as trees are not symmetric.
fn incidences(side: Side) -> impl Iterator<Item = DVec3> {
    let around = [0.0, 45.0, 110.0, 250.0];
    let angles = (0..=5).flat_map(move |k| around.map(move |phi| (15.0 * f64::from(k) + 2.0, phi)));
    angles.map(move |(theta, phi)| {
        let w = from_degrees(theta, phi);
        DVec3::new(w.x, w.y, w.z * side.sign())
    })
}

/// How many of 16,384 values are no BSDF.
fn bad_values(bsdf: &Bsdf, incident: Side, scattered: Side) -> usize {
    const CELLS: u32 = 16;
    let point = |k: u32| {
        let cell = DVec2::new(f64::from(k % CELLS) + 0.5, f64::from(k / CELLS) + 0.5);
        cell / f64::from(CELLS)
    };
    let wo: Vec<DVec3> =
        (0..CELLS * CELLS).map(|k| square_to_hemisphere(point(k), scattered)).collect();
    let mut values = vec![0.0; wo.len()];
    let mut bad = 0;
    for k in (0..CELLS * CELLS).step_by(4) {
        let wi = square_to_hemisphere(point(k), incident);
        bsdf.eval_many(&[wi], &wo, &mut values).expect("one value for each direction");
        bad += values.iter().filter(|f| !(f.is_finite() && **f >= 0.0)).count();
    }
    bad
}

impl Findings {
    /// Turns totals above one into faults.
    fn with_energy_judged(mut self) -> Self {
        for Energy { place, total, wi, .. } in &self.energy {
            if total.is_nan() || *total > 1.0 + ENERGY_TOLERANCE {
                let (theta, phi) = to_degrees(*wi);
                self.faults.push(format!(
                    "{place}: scatters {total:.4} of the light at theta {theta:.0} phi {phi:.0}, expected at most 1"
                ));
            }
        }
        self
    }

    fn verdict(&self) -> &'static str {
        if self.faults.is_empty() { "good" } else { "bad" }
    }

    fn print(&self, out: &mut impl Write, file: &Path) -> io::Result<()> {
        writeln!(out, "{}: {}", file.display(), self.verdict())?;
        self.faults.iter().try_for_each(|f| writeln!(out, "  fault: {f}"))?;
        for Energy { place, total, wi, extrapolated } in &self.energy {
            let theta = to_degrees(*wi).0;
            let how = if *extrapolated { "of the part seen, scatters into it" } else { "scatters" };
            writeln!(out, "  {place}: {how} at most {total:.4} (theta {theta:.0})")?;
        }
        for (place, defect) in &self.reciprocity {
            writeln!(out, "  {place}: reciprocal but for {:.1} %", 100.0 * defect)?;
        }
        self.remarks.iter().try_for_each(|r| writeln!(out, "  remark: {r}"))
    }

    fn json(&self, file: &Path) -> serde_json::Value {
        let energy = |Energy { place, total, wi, extrapolated }: &Energy| {
            let (theta, phi) = to_degrees(*wi);
            json!({
                "component": place, "largest": total, "theta_degrees": theta, "phi_degrees": phi,
                "of_the_part_seen": extrapolated
            })
        };
        let defect = |(place, d): &(String, f64)| json!({"component": place, "defect": d});
        json!({
            "file": file.display().to_string(),
            "verdict": self.verdict(),
            "faults": self.faults,
            "remarks": self.remarks,
            "energy": self.energy.iter().map(energy).collect::<Vec<_>>(),
            "reciprocity": self.reciprocity.iter().map(defect).collect::<Vec<_>>(),
        })
    }
}
