//! `bsdf hemispherical`: how much light is scattered.

use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::PathBuf;

use bsdfkit::{Bsdf, Components, DVec3, Side};
use clap::Args;
use serde_json::json;

use crate::files::load::Reading;
use crate::files::seen::Seen;
use crate::files::surface::SIDES;
use crate::files::told::extrapolated_total;
use crate::terminal::angles::Angles;
use crate::terminal::queries::{Notation, Queries};
use crate::terminal::stop::{Outcome, Verdict};
use crate::terminal::table::Table;

const EXAMPLES: &str = "\
Examples:
  bsdf hemispherical fabric.xml
  bsdf hemispherical fabric.xml --incident 30,45 --incident 60,45
  bsdf hemispherical fabric.xml --stdin < incident.txt";

/// Directional-hemispherical reflectance and transmittance
///
/// Without incident directions: a table over theta 0-80 on every side that has data. Of an interpolant, ~ marks
/// totals that rest on extrapolation.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML, interpolant, compiled BSDF or Radiance interpolant
    file: PathBuf,
    #[command(flatten)]
    reading: Reading,
    /// Incident direction in degrees, away from the surface; may be repeated
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true)]
    incident: Vec<Angles>,
    /// Read rows `theta phi` from standard input and print `reflectance transmittance` for each
    #[arg(long, conflicts_with_all = ["incident", "json"])]
    stdin: bool,
    #[command(flatten)]
    notation: Notation,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Polar angles of the table, from the normal of either side.
const TABLE_DEGREES: [f64; 9] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0];

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let seen = Seen::open(&arguments.file, arguments.reading)?;
    let bsdf = &seen.bsdf;
    if arguments.stdin {
        return answer_rows(&seen, arguments.notation);
    }
    let incident = match &arguments.incident[..] {
        [] => by_default(bsdf),
        given => given.to_vec(),
    };
    let mut out = BufWriter::new(io::stdout().lock());
    let directions: Vec<DVec3> = incident.iter().map(|a| a.direction()).collect();
    let rows = incident.iter().zip(totals(&seen, &directions)?);
    if arguments.json {
        let rows: Vec<_> = rows
            .map(|(a, (r, t))| {
                let [r_extrapolated, t_extrapolated] = extrapolated(bsdf, a.direction());
                json!({
                    "theta_degrees": a.theta, "phi_degrees": a.phi,
                    "reflectance": r, "transmittance": t,
                    "reflectance_extrapolated": r_extrapolated,
                    "transmittance_extrapolated": t_extrapolated
                })
            })
            .collect();
        writeln!(out, "{}", serde_json::Value::from(rows))?;
    } else {
        let mut table = Table::new(["theta", "phi", "reflectance", "transmittance"]);
        for (a, (r, t)) in rows {
            let angles = [format!("{:.1}", a.theta), format!("{:.1}", a.phi)];
            let [theta, phi] = angles;
            let marks = extrapolated(bsdf, a.direction()).map(|e| if e { "~" } else { "" });
            table.row([theta, phi, format!("{}{r:.5}", marks[0]), format!("{}{t:.5}", marks[1])]);
        }
        table.print(&mut out, 0)?;
    }
    out.flush()?;
    Ok(Verdict::Good)
}

/// Whether reflectance, whether transmittance is extrapolated.
fn extrapolated(bsdf: &Bsdf, wi: DVec3) -> [bool; 2] {
    let side = Side::of(wi);
    [side, side.opposite()].map(|to| extrapolated_total(bsdf, wi, to))
}

/// (Reflectance, transmittance) of each.
fn totals(seen: &Seen, wi: &[DVec3]) -> bsdfkit::Result<Vec<(f64, f64)>> {
    let mut ways = [vec![0.0; wi.len()], vec![0.0; wi.len()]];
    for (totals, way) in ways.iter_mut().zip([Components::REFLECTION, Components::TRANSMISSION]) {
        seen.totals(wi, way, totals)?;
    }
    let [reflectance, transmittance] = ways;
    Ok(reflectance.into_iter().zip(transmittance).collect())
}

/// Over the sides whose data say where light from them goes.
fn by_default(bsdf: &Bsdf) -> Vec<Angles> {
    let has = |&side: &Side| {
        let sides = bsdf.components().iter().map(|c| c.incident);
        sides.chain(bsdf.specular().iter().map(|s| s.incident)).any(|incident| incident == side)
    };
    let theta = |side, degrees| if side == Side::Front { degrees } else { 180.0 - degrees };
    let table = |side| TABLE_DEGREES.map(|d| Angles { theta: theta(side, d), phi: 0.0 });
    SIDES.into_iter().filter(has).flat_map(table).collect()
}

fn answer_rows(seen: &Seen, notation: Notation) -> Outcome {
    if io::stdin().is_terminal() {
        crate::terminal::stop::remark("reading", &["rows of directions from the terminal"]);
    }
    let mut queries = Queries::<1>::new(notation);
    let mut out = io::stdout().lock();
    loop {
        let block = queries.block()?;
        if block.is_empty() {
            return Ok(Verdict::Good);
        }
        let directions: Vec<DVec3> = block.iter().map(|q| q.0[0]).collect();
        for (r, t) in totals(seen, &directions)? {
            writeln!(out, "{} {}", notation.number(r), notation.number(t))?;
        }
        out.flush()?;
    }
}
