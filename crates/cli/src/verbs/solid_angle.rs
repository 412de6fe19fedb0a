//! `bsdf solid-angle`: how fine the stored cells are.

use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

use bsdfkit::{Bsdf, DVec3};
use clap::Args;
use serde_json::json;

use crate::files::load::{Reading, bsdf};
use crate::terminal::angles::Angles;
use crate::terminal::queries::{Notation, Queries};
use crate::terminal::stop::{Outcome, Verdict};
use crate::terminal::table::Table;

const EXAMPLES: &str = "\
Examples:
  bsdf solid-angle fabric.xml
  bsdf solid-angle fabric.xml --incident 30,0 --scattered 30,180";

/// Projected solid angles of the stored cells
///
/// Smallest and largest in sr, of all cells that light from an incident direction reaches, or of
/// those that a pair of directions falls in. Without directions: a table over theta 0-80. An
/// interpolant has the cells of the table that it is drawn from.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// XML, interpolant, compiled BSDF or Radiance interpolant
    file: PathBuf,
    /// Incident direction in degrees, away from the surface; may be repeated
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true)]
    incident: Vec<Angles>,
    /// Scattered direction in degrees, away from the surface
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true, requires = "incident")]
    scattered: Option<Angles>,
    /// Read rows `theta phi` from standard input and print `smallest largest` for each
    #[arg(long, conflicts_with_all = ["incident", "json"])]
    stdin: bool,
    /// Rows are of two directions, `theta_i phi_i theta_o phi_o`
    #[arg(long, requires = "stdin")]
    pairs: bool,
    #[command(flatten)]
    notation: Notation,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let bsdf = bsdf(&arguments.file, Reading::default())?;
    if arguments.stdin {
        return match arguments.pairs {
            true => answer_rows::<2>(&bsdf, arguments.notation),
            false => answer_rows::<1>(&bsdf, arguments.notation),
        };
    }
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

fn answer_rows<const D: usize>(bsdf: &Bsdf, notation: Notation) -> Outcome {
    let mut queries = Queries::<D>::new(notation);
    let mut out = io::stdout().lock();
    loop {
        let block = queries.block()?;
        if block.is_empty() {
            return Ok(Verdict::Good);
        }
        let all = |k: usize| block.iter().map(|q| q.0[k]).collect::<Vec<DVec3>>();
        let wo = (D > 1).then(|| all(D - 1));
        let mut ranges = vec![[0.0; 2]; block.len()];
        bsdf.projected_solid_angle_many(&all(0), wo.as_deref(), &mut ranges)?;
        for [least, most] in ranges {
            writeln!(out, "{} {}", notation.number(least), notation.number(most))?;
        }
        out.flush()?;
    }
}
