//! `bsdf info`: what a file holds.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use bsdfkit::{Bsdf, Side};
use bsdfkit_fit::open::Content;
use bsdfkit_measure::{Hole, IncidenceQuality, Measurement, Quality};
use clap::Args;
use serde_json::{Map, Value, json};

use crate::files::component::{self, Facts};
use crate::files::load::{load, measure};
use crate::files::surface::{SIDES, Surface};
use crate::files::told;
use crate::terminal::stop::{Outcome, Verdict};
use crate::terminal::table::Table;

const EXAMPLES: &str = "\
Examples:
  bsdf info measurements/
  bsdf info material.xml material.safetensors
  bsdf info --json measurements/ > coverage.json";

/// What a file or a folder of measurements holds
///
/// Measurements: symmetry, and for each incidence points, spacing, grazing limit, share of the hemisphere
/// seen, holes, noise and hemispherical value: ~ what a plane lets expect, > what was seen alone, where less than nine tenths were
/// seen. BSDFs: structure, bases, leaves, largest value, Lambertian parts.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Folders of measurements, measurement files, XML, interpolants, compiled BSDFs
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// One JSON object a file
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    let mut out = BufWriter::new(io::stdout().lock());
    for group in groups(&arguments.files)? {
        let place = group[0].display();
        match Content::of(group[0])? {
            Content::Measurement => {
                let paths: Vec<PathBuf> = group.iter().map(|p| p.to_path_buf()).collect();
                let qualities: Vec<Quality> =
                    measure(&paths, true)?.iter().map(Measurement::quality).collect();
                if arguments.json {
                    let report = json!({
                        "file": place.to_string(), "content": Content::Measurement.name(), "components": qualities
                    });
                    writeln!(out, "{report}")?;
                } else {
                    writeln!(out, "{place}: {}", Content::Measurement.name())?;
                    qualities.iter().try_for_each(|q| print_quality(&mut out, q))?;
                }
            }
            _ => describe(&mut out, group[0], arguments.json)?,
        }
    }
    out.flush()?;
    Ok(Verdict::Good)
}

/// Files to look at together: measurement files are one measurement, whatever else stands alone.
fn groups(files: &[PathBuf]) -> bsdfkit::Result<Vec<Vec<&Path>>> {
    let mut groups: Vec<Vec<&Path>> = Vec::new();
    let mut measured: Option<usize> = None;
    for file in files {
        let loose = Content::of(file)? == Content::Measurement && !file.is_dir();
        match measured {
            Some(at) if loose => groups[at].push(file),
            _ => {
                if loose {
                    measured = Some(groups.len());
                }
                groups.push(vec![file]);
            }
        }
    }
    Ok(groups)
}

fn print_quality(out: &mut impl Write, quality: &Quality) -> io::Result<()> {
    let name = quality.sample_name.as_deref().map(|n| format!(", {n}")).unwrap_or_default();
    writeln!(
        out,
        "  {}{name}: {} symmetry, {} incidences, {} points, {}",
        quality.component,
        quality.symmetry,
        quality.incidences.len(),
        quality.points,
        quality.colorimetry
    )?;
    let mut table = Table::new([
        "theta",
        "phi",
        "points",
        "negative",
        "spacing°",
        "grazing°",
        "seen %",
        "holes",
        "noise %",
        "noise 1/sr",
        "hemispherical",
    ]);
    for i in &quality.incidences {
        table.row([
            format!("{:.1}", i.theta_degrees),
            format!("{:.1}", i.phi_degrees),
            i.points.to_string(),
            i.negatives.to_string(),
            format!("{:.2}", i.spacing_degrees),
            format!("{:.1}", i.grazing_limit_degrees),
            format!("{:.0}", 100.0 * i.seen),
            holes(i),
            format!("{:.2}", 100.0 * i.relative_noise),
            format!("{:.1e}", i.absolute_noise),
            told::totals(i),
        ]);
    }
    table.print(out, 4)?;
    quality.scant.iter().try_for_each(|text| writeln!(out, "    {text}"))?;
    quality.notes.iter().try_for_each(|note| writeln!(out, "    note: {note}"))
}

/// "4.1° retro, 2.2°": radii, largest first.
fn holes(incidence: &IncidenceQuality) -> String {
    let text = |h: &Hole| {
        format!("{:.1}°{}", h.radius_degrees, if h.retro_reflection { " retro" } else { "" })
    };
    match &incidence.holes[..] {
        [] => "none".into(),
        [a] => text(a),
        [a, rest @ ..] => format!("{}, {} more", text(a), rest.len()),
    }
}

fn describe(out: &mut impl Write, path: &Path, as_json: bool) -> Outcome<()> {
    let loaded = load(path)?;
    loaded.warn(path);
    let (mut components, peaks): (Vec<Facts>, _) = match &loaded.surface {
        Surface::Stored(bsdf) => {
            (bsdf.components().iter().map(component::stored).collect(), bsdf.specular())
        }
        Surface::Continuous(i) => {
            (i.components.iter().map(component::continuous).collect(), &i.specular[..])
        }
    };
    components.extend(peaks.iter().map(component::specular));
    let metadata = loaded.metadata();
    let bands = match &loaded.surface {
        Surface::Stored(bsdf) => bsdf.bands(),
        Surface::Continuous(_) => &[],
    };
    let unread = metadata.bound();
    let lambertian = match &loaded.surface {
        Surface::Stored(bsdf) => lambertian(bsdf),
        Surface::Continuous(_) => Vec::new(),
    };
    if as_json {
        let object = |facts: Facts| {
            Value::from(facts.into_iter().map(|(k, v)| (k.to_owned(), v)).collect::<Map<_, _>>())
        };
        let report = json!({
            "file": path.display().to_string(),
            "content": loaded.content.name(),
            "name": metadata.name,
            "manufacturer": metadata.manufacturer,
            "width_metres": metadata.width,
            "height_metres": metadata.height,
            "thickness_metres": metadata.thickness,
            "comments": metadata.comments,
            "lambertian": lambertian.into_iter().collect::<Map<_, _>>(),
            "components": components.into_iter().map(object).collect::<Vec<_>>(),
            "bands": bands.iter().map(|b| json!({
                "name": b.name,
                "components": b.components.iter().map(|c| object(component::stored(c))).collect::<Vec<_>>(),
            })).collect::<Vec<_>>(),
            "kept_unread": unread,
            "warnings": loaded.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        });
        writeln!(out, "{report}")?;
        return Ok(());
    }
    writeln!(out, "{}: {}", path.display(), loaded.content.name())?;
    for (key, value) in [("name", &metadata.name), ("manufacturer", &metadata.manufacturer)] {
        if !value.is_empty() {
            writeln!(out, "  {key}: {value}")?;
        }
    }
    if metadata.thickness > 0.0 {
        writeln!(out, "  thickness: {} m", metadata.thickness)?;
    }
    for comment in &metadata.comments {
        writeln!(out, "  comment: {}", comment.trim())?;
    }
    for facts in components {
        let mut facts = facts.into_iter();
        if let Some((_, name)) = facts.next() {
            writeln!(out, "  {}:", plain(&name))?;
        }
        for (key, value) in facts {
            writeln!(out, "    {}: {}", key.replace('_', " "), plain(&value))?;
        }
    }
    for band in bands {
        let names = band.components.iter().map(|c| component::name(c.incident, c.scattered));
        writeln!(out, "  band {}: {}", band.name, names.collect::<Vec<_>>().join(", "))?;
    }
    if !unread.is_empty() {
        writeln!(out, "  kept, not read: {}", unread.join(", "))?;
    }
    for (key, value) in lambertian {
        writeln!(out, "  Lambertian {}: {}", key.replace('_', " "), plain(&value))?;
    }
    Ok(())
}

/// Lambertian parts that are not zero.
fn lambertian(bsdf: &Bsdf) -> Vec<(String, Value)> {
    let pair = |from: Side, to: Side| {
        (component::name(from, to).replace(' ', "_"), bsdf.lambertian().get(from, to).y)
    };
    SIDES
        .into_iter()
        .flat_map(|from| [pair(from, from), pair(from, from.opposite())])
        .filter(|(_, value)| *value > 0.0)
        .map(|(key, value)| (key, json!(value)))
        .collect()
}

/// A value without JSON's quotes.
fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(n) => match n.as_f64() {
            Some(x) if n.is_f64() => format!("{x:.5}"),
            _ => n.to_string(),
        },
        other => other.to_string(),
    }
}
