//! `bsdf hemispherical`: how much light is scattered.

use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::PathBuf;

use bsdfkit::Side;
use clap::Args;
use serde_json::json;

use crate::angles::Angles;
use crate::load::{Reading, surface_read};
use crate::rows::Rows;
use crate::stop::{Outcome, Verdict};
use crate::surface::Surface;
use crate::table::Table;

const EXAMPLES: &str = "\
Examples:
  bsdf hemispherical fabric.xml
  bsdf hemispherical fabric.xml --incident 30,45 --incident 60,45
  bsdf hemispherical fabric.xml --stdin < incident.txt";

/// Directional-hemispherical reflectance and transmittance
///
/// Without incident directions: a table over theta 0-80 on every side that has data.
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
    #[arg(long, conflicts_with = "incident")]
    stdin: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Polar angles of the table, from the normal of either side.
const TABLE_DEGREES: [f64; 9] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0];

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let surface = surface_read(&arguments.file, arguments.reading)?;
    if arguments.stdin {
        return answer_rows(&surface);
    }
    let incident = match &arguments.incident[..] {
        [] => by_default(&surface),
        given => given.to_vec(),
    };
    let mut out = BufWriter::new(io::stdout().lock());
    let rows = incident.iter().map(|&a| (a, totals(&surface, a)));
    if arguments.json {
        let rows: Vec<_> = rows
            .map(|(a, (r, t))| {
                json!({
                    "theta_degrees": a.theta, "phi_degrees": a.phi,
                    "reflectance": r, "transmittance": t
                })
            })
            .collect();
        writeln!(out, "{}", serde_json::Value::from(rows))?;
    } else {
        let mut table = Table::new(["theta", "phi", "reflectance", "transmittance"]);
        for (a, (r, t)) in rows {
            let angles = [format!("{:.1}", a.theta), format!("{:.1}", a.phi)];
            let [theta, phi] = angles;
            table.row([theta, phi, format!("{r:.5}"), format!("{t:.5}")]);
        }
        table.print(&mut out, 0)?;
    }
    out.flush()?;
    Ok(Verdict::Good)
}

/// (Reflectance, transmittance).
fn totals(surface: &Surface, incident: Angles) -> (f64, f64) {
    let wi = incident.direction();
    let side = Side::of(wi);
    (surface.hemispherical(wi, side), surface.hemispherical(wi, side.opposite()))
}

fn by_default(surface: &Surface) -> Vec<Angles> {
    let sides = surface.incident_sides();
    let theta = |side, degrees| if side == Side::Front { degrees } else { 180.0 - degrees };
    let table = |side| TABLE_DEGREES.map(|d| Angles { theta: theta(side, d), phi: 0.0 });
    sides.into_iter().flat_map(table).collect()
}

fn answer_rows(surface: &Surface) -> Outcome {
    if io::stdin().is_terminal() {
        crate::stop::remark("reading", &["rows `theta phi` from the terminal"]);
    }
    let mut rows = Rows::<2>::new(io::stdin());
    let mut out = io::stdout().lock();
    loop {
        let block = rows.block()?;
        if block.is_empty() {
            return Ok(Verdict::Good);
        }
        for (line, [theta, phi]) in block {
            let angles = Angles::new(theta, phi).map_err(|e| {
                bsdfkit::Error::format(e.to_string())
                    .context(format!("standard input: line {line}"))
            })?;
            let (r, t) = totals(surface, angles);
            writeln!(out, "{r:.8e} {t:.8e}")?;
        }
        out.flush()?;
    }
}
