//! The pab-opto "Mountain" text format: `#key value` lines, then `theta phi value…` rows.

use std::path::Path;

use bsdfkit::Result;
use bsdfkit_sphere::direction;

use super::Colorimetry;
use super::line::{Lines, degrees, number, quoted};
use super::scan::{Block, Budget, FileContent, HORIZON_COSINE};

/// What the value column holds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Quantity {
    /// f |cos θo|.
    Dsf,
    /// f.
    Bsdf,
}

/// The header's keys, as far as they were met.
#[derive(Default)]
struct Header {
    sample_name: Option<String>,
    quantity: Option<Quantity>,
    theta: Option<f64>,
    phi: Option<f64>,
    up: f64,
    colorimetry: Option<Colorimetry>,
    declared: Option<u64>,
}

impl Header {
    /// Takes one header line, its `#` removed; keys that are not known are comments.
    fn take(&mut self, line: &str) -> std::result::Result<(), String> {
        let line = line.trim_start();
        let end = line.find(|c: char| c.is_whitespace() || c == ':').unwrap_or(line.len());
        let key = line[..end].to_ascii_lowercase();
        let value = line[end..].trim_start().strip_prefix(':').unwrap_or(&line[end..]).trim();
        let mut words = value.split_whitespace();
        let mut angle = |what: &str| degrees(words.next().unwrap_or(""), what);
        match key.as_str() {
            "sample_name" => self.sample_name = Some(value.trim_matches('"').to_owned()),
            "format" => self.quantity = Some(quantity(value)?),
            "intheta" => self.theta = Some(angle("intheta")?),
            "inphi" => self.phi = Some(angle("inphi")?),
            "incident_angle" => {
                self.theta = Some(angle("incident_angle: theta")?);
                self.phi = Some(angle("incident_angle: phi")?);
            }
            "upphi" => self.up = angle("upphi")?,
            "colorimetry" => self.colorimetry = Some(colorimetry(value)?),
            "datapoints_in_file" => {
                let found = || {
                    format!("datapoints_in_file: expected a whole number, found {}", quoted(value))
                };
                self.declared = Some(value.parse().map_err(|_| found())?);
            }
            _ => {}
        }
        Ok(())
    }
}

fn quantity(value: &str) -> std::result::Result<Quantity, String> {
    let words: Vec<String> = value.split_whitespace().map(str::to_ascii_lowercase).collect();
    match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["theta", "phi", "dsf"] => Ok(Quantity::Dsf),
        ["theta", "phi", "bsdf" | "brdf" | "btdf"] => Ok(Quantity::Bsdf),
        _ => Err(format!(
            "format: expected theta phi and one of DSF, BSDF, BRDF, BTDF, found {}",
            quoted(value)
        )),
    }
}

fn colorimetry(value: &str) -> std::result::Result<Colorimetry, String> {
    match value.to_ascii_uppercase().as_str() {
        "CIE-Y" => Ok(Colorimetry::Luminance),
        "CIE-XYZ" => Ok(Colorimetry::Xyz),
        _ => Err(format!("colorimetry: expected CIE-Y or CIE-XYZ, found {}", quoted(value))),
    }
}

/// A file with less than this part of the rows that it declares is taken as cut off; published files that are whole
/// declare 1.2 % too many.
const TRUNCATED: f64 = 0.9;

/// Reads one Mountain file.
///
/// Convention: both azimuths get + (90° − upphi), upphi 0 when absent, so that "up" becomes +Y; a
/// negative θ is its positive at φ + 180°. Rows at the horizon are counted and dropped.
/// Errors: class format, naming line, expected and found; class io.
pub(super) fn read(path: &Path, budget: &Budget) -> Result<FileContent> {
    let mut lines = Lines::open(path)?;
    let mut header = Header::default();
    let mut rows: Option<Rows> = None;
    let mut count = 0;
    while let Some(line) = lines.next_line()? {
        if let Some(key) = line.trim_start().strip_prefix('#') {
            let taken = if rows.is_some() {
                let found =
                    format!("header lines before the data, found {} after it", quoted(line));
                if key.trim().is_empty() { Ok(()) } else { Err(format!("expected {found}")) }
            } else {
                header.take(key)
            };
            taken.map_err(|m| lines.error(m))?;
            continue;
        }
        if line.trim().is_empty() {
            continue;
        }
        let taken = match &mut rows {
            Some(rows) => rows.take(line),
            None => Rows::begin(&header).and_then(|r| rows.insert(r).take(line)),
        };
        taken.map_err(|m| lines.error(m))?;
        budget.spend(&mut count, path)?;
    }
    let Some(rows) = rows else {
        return Err(lines.error(
            "expected rows \"theta phi value\" after the header, found the end of the file",
        ));
    };
    rows.finish(header, path).map_err(|m| lines.error(m))
}

/// The data under way.
struct Rows {
    quantity: Quantity,
    /// Added to every azimuth, degrees.
    turn: f64,
    channels: usize,
    block: Block,
    horizon: u64,
}

impl Rows {
    /// The header is complete: checks that it says enough.
    fn begin(header: &Header) -> std::result::Result<Self, String> {
        let missing =
            |key: &str| format!("expected a header line #{key} before the data, found none");
        let quantity = header.quantity.ok_or_else(|| missing("format: theta phi BSDF"))?;
        let theta = header.theta.ok_or_else(|| missing("intheta or #incident_angle"))?;
        let phi = header.phi.ok_or_else(|| missing("inphi or #incident_angle"))?;
        let turn = 90.0 - header.up;
        let wi = direction::from_degrees(theta, phi + turn);
        if wi.z.abs() < HORIZON_COSINE {
            return Err(format!(
                "intheta: expected an incident direction off the horizon, found {theta} degrees"
            ));
        }
        let channels = header.colorimetry.as_ref().map_or(1, Colorimetry::channels);
        let block = Block { wi, wo: Vec::new(), values: Vec::new() };
        Ok(Self { quantity, turn, channels, block, horizon: 0 })
    }

    fn take(&mut self, line: &str) -> std::result::Result<(), String> {
        let mut words = line.split_whitespace();
        let wanted = 2 + self.channels;
        let short = || format!("expected {wanted} numbers, found {}", quoted(line));
        let mut next = || words.next().ok_or_else(short);
        let (theta, phi) = (degrees(next()?, "theta")?, degrees(next()?, "phi")?);
        let wo = direction::from_degrees(theta, phi + self.turn);
        let cosine = wo.z.abs();
        let scale = if self.quantity == Quantity::Dsf { 1.0 / cosine } else { 1.0 };
        let start = self.block.values.len();
        for _ in 0..self.channels {
            self.block.values.push(scale * number(next()?, "value")?);
        }
        if words.next().is_some() {
            return Err(short());
        }
        if cosine < HORIZON_COSINE {
            self.block.values.truncate(start);
            self.horizon += 1;
        } else {
            self.block.wo.push(wo);
        }
        Ok(())
    }

    fn finish(self, header: Header, path: &Path) -> std::result::Result<FileContent, String> {
        let found = self.block.wo.len() as u64 + self.horizon;
        let mut notes = Vec::new();
        if let Some(declared) = header.declared.filter(|&d| d != found) {
            let message = format!("expected {declared} rows (datapoints_in_file), found {found}");
            if (found as f64) < TRUNCATED * declared as f64 {
                return Err(format!("{message}: is the file truncated?"));
            }
            notes.push(format!("{}: {message}", path.display()));
        }
        if self.horizon > 0 {
            notes.push(format!("{}: {} rows at the horizon dropped", path.display(), self.horizon));
        }
        Ok(FileContent {
            path: path.to_owned(),
            sample_name: header.sample_name,
            colorimetry: header.colorimetry.unwrap_or(Colorimetry::Luminance),
            blocks: vec![self.block],
            notes,
        })
    }
}
