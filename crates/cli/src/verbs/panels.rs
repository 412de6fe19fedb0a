//! `bsdf plot`: one incidence of several files, side by side.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use bsdfkit::{Bsdf, DVec3, Error, Result, Side};
use bsdfkit_fit::interpolant::mesh::{IncidenceMesh, Vertex};
use bsdfkit_measure::{Image, Measurement};
use bsdfkit_sphere::direction::to_degrees;
use bsdfkit_sphere::locate::Location;
use clap::Args;
use rayon::prelude::*;
use serde_json::json;

use crate::files::load::{Reading, bsdf, measure};
use crate::files::target::expect_writable;
use crate::picture::canvas::{CAPTION, Canvas, FAINT, SUPER, Scale, TEXT, type_size};
use crate::picture::raster::Raster;
use crate::terminal::angles::Angles;
use crate::terminal::stop::{Outcome, Verdict};
use crate::verbs::simulate::material;

pub(crate) const EXAMPLES: &str = "\
Examples:
  bsdf plot fabric.xml --incident 30,0 -o fabric.png
  bsdf plot ours=fabric.safetensors tree=fabric.xml --incident 37,15 --measurements measurements \\
      --linear measurements --material fabric -o fabric.png
  bsdf plot fabric.xml --kind hemisphere --incident 30,0 -o fabric.svg";

/// Draw one incidence of measurements, files and the truth side by side
///
/// Each panel is the disk of scattered directions seen from the front: +X right, +Y up, rings at 30
/// and 60 degrees; colours are logarithmic and the same in all panels; a small ring marks the
/// light. With --material, captions state L1: the share of light in a wrong place, doubled.
///
/// With --kind the Python package bsdfkit draws, as PNG or SVG; `bsdf plot --kind hemisphere --help` lists its kinds and options.
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Files to draw, each as PATH or CAPTION=PATH
    #[arg(value_name = "SOURCE")]
    sources: Vec<Captioned>,
    #[command(flatten)]
    reading: Reading,
    /// Incident direction in degrees, away from the surface
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true)]
    incident: Angles,
    /// Picture to write
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Draw the measured points of that incidence, or of the nearest two where it was not measured
    #[arg(long, value_name = "DIR")]
    measurements: Option<PathBuf>,
    /// Draw the linear blend of the nearest measured incidences
    #[arg(long, value_name = "DIR")]
    linear: Option<PathBuf>,
    /// Draw the truth of an analytic material; see `bsdf simulate --list`
    #[arg(long, value_name = "NAME")]
    material: Option<String>,
    /// Draw transmitted light where there is reflected light, too
    #[arg(long)]
    transmission: bool,
    /// Most decades of the colour scale
    #[arg(long, value_name = "N", default_value_t = 3.0)]
    decades: f64,
    /// Width of a panel in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 280,
          value_parser = clap::value_parser!(u16).range(64..=2048))]
    panel: u16,
    /// Print the panels' figures as JSON
    #[arg(long)]
    json: bool,
    /// What is drawn: these panels, or what the Python package draws
    #[arg(long, value_name = "KIND", default_value = "panels")]
    kind: String,
}

/// A file with the words under its picture.
#[derive(Clone, Debug)]
struct Captioned {
    caption: String,
    path: PathBuf,
}

impl FromStr for Captioned {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let whole = Path::new(text);
        if let (false, Some((caption, path))) = (whole.exists(), text.split_once('=')) {
            return Ok(Self { caption: caption.to_owned(), path: path.into() });
        }
        let stem = whole.file_stem().unwrap_or_default().to_string_lossy();
        Ok(Self { caption: stem.into_owned(), path: whole.to_owned() })
    }
}

/// A disk and the words under it.
struct Panel {
    title: String,
    raster: Raster,
    /// Whether it shows the incidence asked for, so that it can be compared with the truth.
    comparable: bool,
}

/// What is drawn.
struct View {
    wi: DVec3,
    side: Side,
    /// Pixels along a side of a raster.
    size: usize,
}

pub(crate) fn run(arguments: &Arguments) -> Outcome {
    if !(arguments.decades > 0.0 && arguments.decades <= 12.0) {
        let text = format!("decades: expected above 0 and at most 12, found {}", arguments.decades);
        return Err(Error::argument(text).into());
    }
    expect_writable(&arguments.output)?;
    let panels = panels(arguments)?;
    let scale = scale(&panels, arguments.decades)?;
    let truth = arguments.material.as_ref().and_then(|_| panels.last());
    let l1 = |p: &Panel| truth.filter(|_| p.comparable).map(|t| p.raster.l1(&t.raster));
    let last = panels.len() - 1;
    let figures: Vec<(&str, Option<f64>)> = panels
        .iter()
        .enumerate()
        .map(|(k, p)| (p.title.as_str(), l1(p).filter(|_| k != last)))
        .collect();
    picture(arguments, &panels, &figures, &scale).save(&arguments.output)?;
    let mut out = io::stdout().lock();
    if arguments.json {
        let panel = |(title, l1): &(&str, Option<f64>)| json!({"title": title, "l1": l1});
        let report = json!({
            "file": arguments.output.display().to_string(),
            "panels": figures.iter().map(panel).collect::<Vec<_>>(),
        });
        writeln!(out, "{report}")?;
    } else {
        writeln!(out, "{}", arguments.output.display())?;
        for (title, l1) in figures {
            if let Some(l1) = l1 {
                writeln!(out, "  {title}: L1 {l1:.4}")?;
            }
        }
    }
    Ok(Verdict::Good)
}

/// Left to right: measured, linear, sources, truth.
fn panels(arguments: &Arguments) -> Result<Vec<Panel>> {
    let wi = arguments.incident.direction();
    let read = |folder: &Option<PathBuf>| match folder {
        Some(folder) => measure(std::slice::from_ref(folder), true),
        None => Ok(Vec::new()),
    };
    let (points, blended) = (read(&arguments.measurements)?, read(&arguments.linear)?);
    let sources = arguments
        .sources
        .iter()
        .map(|s| Ok((s.caption.clone(), bsdf(&s.path, arguments.reading)?)))
        .collect::<Result<Vec<(String, Bsdf)>>>()?;
    let truth = arguments.material.as_deref().map(material).transpose()?;

    let measured = points.iter().chain(&blended).map(|m| (m.incident, m.scattered));
    let known = measured
        .chain(sources.iter().flat_map(|(_, b)| b.components()).map(|c| (c.incident, c.scattered)))
        .chain(truth.iter().map(|t| (Side::Front, t.scattered())));
    let here = Side::of(wi);
    let mut to: Vec<Side> = known.filter(|p| p.0 == here).map(|p| p.1).collect();
    to.sort_by_key(|&side| (side == here) == arguments.transmission);
    let Some(&side) = to.first() else {
        return Err(Error::argument("nothing given scatters light from the incident side"));
    };
    let view = View { wi, side, size: usize::from(arguments.panel) * SUPER };
    let one = |all: &[Measurement]| {
        all.iter().find(|m| m.incident == here && m.scattered == side).cloned()
    };
    let mut panels = Vec::new();
    if let Some(m) = one(&points) {
        panels.extend(view.measured(&m));
    }
    if let Some(m) = one(&blended) {
        panels.push(view.linear(&m)?);
    }
    for (title, bsdf) in &sources {
        let raster = Raster::of(view.size, side, |wo| view.values(bsdf, wo));
        panels.push(Panel { title: title.clone(), raster, comparable: true });
    }
    if let Some(material) = &truth {
        let values = |wo: &[DVec3]| wo.par_iter().map(|&w| material.eval(wi, w)).collect();
        let raster = Raster::of(view.size, side, values);
        panels.push(Panel { title: "truth".into(), raster, comparable: true });
    }
    if panels.is_empty() {
        return Err(Error::argument("nothing to draw"));
    }
    Ok(panels)
}

/// An incidence nearer than this is the one asked for.
const SAME_DEGREES: f64 = 0.5;

impl View {
    fn values(&self, bsdf: &Bsdf, wo: &[DVec3]) -> Vec<f64> {
        let mut values = vec![0.0; wo.len()];
        bsdf.eval_many(&[self.wi], wo, &mut values).expect("one value for each direction");
        values
    }

    /// Pixels that a measured point covers: 3 degrees.
    fn reach(&self) -> f64 {
        0.025 * self.size as f64
    }

    /// Points of the nearest incidences, seen through the symmetry that brings them nearest.
    fn measured(&self, m: &Measurement) -> Vec<Panel> {
        let mut near: Vec<(f64, usize, Image)> = (0..m.incidences.len())
            .map(|k| {
                let own = m.incidences[k].wi;
                let (_, image) = m.symmetry.nearest_image(own, self.wi);
                (image.apply(own).angle_between(self.wi).to_degrees(), k, image)
            })
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let same = near.first().is_some_and(|n| n.0 < SAME_DEGREES);
        let channel = m.colorimetry.luminance_channel();
        near.iter()
            .take(if same { 1 } else { 2 })
            .map(|&(_, k, image)| {
                let incidence = m.incidences[k].transformed(image);
                let (theta, phi) = to_degrees(incidence.wi);
                let raster = Raster::of_points(self.size, &incidence, channel, self.reach());
                Panel {
                    title: format!("measured {theta:.0}° {phi:.0}°"), raster, comparable: same
                }
            })
            .collect()
    }

    /// What an interpolation that knows nothing of peaks makes of the incidences around.
    fn linear(&self, m: &Measurement) -> Result<Panel> {
        let directions: Vec<DVec3> =
            m.incidences.iter().map(|i| Side::Front.facing(i.wi)).collect();
        let mesh = IncidenceMesh::new(&directions, m.symmetry)?;
        let (folded, fold) = m.symmetry.fold(Side::Front.facing(self.wi));
        let corners: Vec<(f64, Vertex)> = match mesh.locate(folded) {
            Location::Inside { triangle, barycentric } => {
                let corners = mesh.topology.triangles()[triangle as usize];
                barycentric.into_iter().zip(corners.map(|v| mesh.vertices[v as usize])).collect()
            }
            Location::Outside { edge, fraction, .. } => [1.0 - fraction, fraction]
                .into_iter()
                .zip(edge.map(|v| mesh.vertices[v as usize]))
                .collect(),
        };
        let channel = m.colorimetry.luminance_channel();
        let parts: Vec<(f64, Raster)> = corners
            .into_par_iter()
            .filter(|(weight, _)| *weight > 1e-9)
            .map(|(weight, v)| {
                let incidence = m.incidences[v.incidence].transformed(v.image);
                (weight, Raster::of_points(self.size, &incidence, channel, f64::INFINITY))
            })
            .collect();
        let raster = Raster::blend(&parts, fold, self.size, self.side);
        Ok(Panel { title: "linear blend".into(), raster, comparable: true })
    }
}

/// One scale for all panels: from what a fiftieth of the pixels of the darkest does not reach, but
/// at most `decades` below, to what a ten-thousandth of the pixels of the brightest exceeds.
fn scale(panels: &[Panel], decades: f64) -> Result<Scale> {
    let (mut low, mut high) = (f64::INFINITY, 0.0f64);
    for panel in panels {
        let mut values: Vec<f64> = panel.raster.known().collect();
        values.sort_by(f64::total_cmp);
        let count = values.len();
        low = values.get(count / 50).map_or(low, |&v| low.min(v));
        high = values.get(count.saturating_sub(1 + count / 10_000)).map_or(high, |&v| high.max(v));
    }
    if high > 0.0 && high.is_finite() {
        // At least a third of a decade, for what is the same everywhere.
        Ok(Scale { low: low.max(high / 10f64.powf(decades)).min(0.5 * high), high })
    } else {
        Err(Error::argument("nothing to draw: no light is scattered to that side"))
    }
}

fn picture(
    arguments: &Arguments,
    panels: &[Panel],
    figures: &[(&str, Option<f64>)],
    scale: &Scale,
) -> Canvas {
    const MARGIN: usize = 18;
    let size = usize::from(arguments.panel);
    let width = MARGIN + panels.len() * (size + MARGIN);
    let captioned = MARGIN + size + 12;
    let mut canvas = Canvas::new(width, captioned + 116);
    let wi = arguments.incident.direction();
    for (k, (panel, &(title, l1))) in panels.iter().zip(figures).enumerate() {
        let left = MARGIN + k * (size + MARGIN);
        canvas.disk(&panel.raster, scale, left, MARGIN);
        if panel.comparable {
            canvas.mark((wi.x, wi.y), size, left, MARGIN);
        }
        canvas.text(title, left + size / 2, captioned, type_size(title, size + MARGIN), TEXT);
        if let Some(l1) = l1 {
            canvas.text(&format!("L1 = {l1:.3}"), left + size / 2, captioned + 22, CAPTION, FAINT);
        }
    }
    let bar = (width / 3).max(size.min(width - 2 * MARGIN));
    let left = (width - bar) / 2;
    canvas.bar(scale, left, captioned + 52, bar, 10);
    let Angles { theta, phi } = arguments.incident;
    let text = format!("light from θ {theta}° φ {phi}°, f in 1/sr");
    canvas.text(&text, width / 2, captioned + 90, type_size(&text, width), FAINT);
    canvas
}
