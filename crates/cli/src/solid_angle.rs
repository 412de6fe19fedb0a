//! `bsdf solid-angle`: how fine the stored cells are.

use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

use bsdfkit::Error;
use clap::Args;
use serde_json::json;

use crate::angles::Angles;
use crate::load::surface;
use crate::stop::{Outcome, Verdict};
use crate::surface::Surface;
use crate::table::Table;

const EXAMPLES: &str = "\
Examples:
  bsdf solid-angle fabric.xml
  bsdf solid-angle fabric.xml --incident 30,0 --scattered 30,180";

/// Projected solid angles of the stored cells
///
/// Smallest and largest in sr, of all cells that light from an incident direction reaches, or of
/// those that a pair of directions falls in. Without directions: a table over theta 0-80.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML or compiled BSDF
    file: PathBuf,
    /// Incident direction in degrees, away from the surface; may be repeated
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true)]
    incident: Vec<Angles>,
    /// Scattered direction in degrees, away from the surface
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true, requires = "incident")]
    scattered: Option<Angles>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let file = &arguments.file;
    let Surface::Stored(bsdf) = surface(file)? else {
        let text = "expected a tree or a matrix, found an interpolant, which has no cells";
        return Err(Error::argument(text).context(file.display()).into());
    };
    let table = || (0..=8).map(|k| Angles { theta: 10.0 * f64::from(k), phi: 0.0 }).collect();
    let incident = match &arguments.incident[..] {
        [] => table(),
        given => given.to_vec(),
    };
    let scattered = arguments.scattered.map(Angles::direction);
    let rows: Vec<(Angles, (f64, f64))> = incident
        .iter()
        .map(|&a| (a, bsdf.projected_solid_angle(a.direction(), scattered)))
        .collect();
    let mut out = BufWriter::new(io::stdout().lock());
    if arguments.json {
        let rows: Vec<_> = rows
            .iter()
            .map(|(a, (least, most))| {
                json!({
                    "theta_degrees": a.theta, "phi_degrees": a.phi,
                    "smallest": least, "largest": most
                })
            })
            .collect();
        writeln!(out, "{}", serde_json::Value::from(rows))?;
    } else {
        let mut table = Table::new(["theta", "phi", "smallest sr", "largest sr"]);
        for (a, (least, most)) in rows {
            let [theta, phi] = [format!("{:.1}", a.theta), format!("{:.1}", a.phi)];
            table.row([theta, phi, format!("{least:.6e}"), format!("{most:.6e}")]);
        }
        table.print(&mut out, 0)?;
    }
    out.flush()?;
    Ok(Verdict::Good)
}
