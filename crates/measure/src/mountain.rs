//! The pab-opto "Mountain" text format: `#key value` lines, then `theta phi value…` rows.

use std::path::Path;

use bsdfkit::Result;
use bsdfkit_sphere::direction;

use super::block::{Block, Budget, FileContent, HORIZON_COSINE, Remark};
use super::form::{Decimal, Separator};
use super::header::{Format, Header, Quantity};
use super::line::{Lines, quoted};
use super::names::Name;

/// A file with less than this part of the rows that it declares is taken as cut off; published
/// files that are whole declare 1.2 % too many.
const TRUNCATED: f64 = 0.9;

/// Reads one Mountain file.
///
/// Keys and columns may be spelt as in any of the dialects of [`super`]; where no line says what
/// the values are, they are taken as BSDF, with a remark.
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
            None => Rows::begin(&header, path, line).and_then(|r| rows.insert(r).take(line)),
        };
        taken.map_err(|m| lines.error(m))?;
        budget.spend(&mut count, rows.as_ref().map_or(1, |r| r.channels), path)?;
    }
    let Some(mut rows) = rows else {
        return Err(lines.error(
            "expected rows \"theta phi value\" after the header, found the end of the file",
        ));
    };
    rows.remarks.extend(lines.remark());
    let mut content = rows.finish(&header, path).map_err(|m| lines.error(m))?;
    let spectral = content.colorimetry.spectral(&mut content.blocks);
    content.colorimetry = spectral.map_err(|e| e.context(path.display()))?;
    Ok(content)
}

/// The data under way.
struct Rows {
    quantity: Quantity,
    separator: Separator,
    decimal: Decimal,
    /// What θ and φ are to be multiplied with to be degrees.
    degrees: [f64; 2],
    /// Added to every azimuth, degrees.
    turn: f64,
    channels: usize,
    block: Block,
    horizon: u64,
    remarks: Vec<Remark>,
}

impl Rows {
    /// The header is complete: checks that it says enough for rows like `row`.
    fn begin(header: &Header, path: &Path, row: &str) -> std::result::Result<Self, String> {
        let missing =
            |key: &str| format!("expected a header line #{key} before the data, found none");
        let theta = header.theta.ok_or_else(|| {
            let table = "or a line that names the columns of a table: theta_i, phi_i, theta_o, phi_o, value";
            format!("{}, {table}", missing("intheta or #incident_angle"))
        })?;
        let phi = header.phi.ok_or_else(|| missing("inphi or #incident_angle"))?;
        let channels = header.colorimetry()?.channels();
        let separator = Separator::of(row, 2 + channels);
        let mut remarks = Vec::new();
        let format = match header.format {
            Some(format) => format,
            None if separator.fields(row).count() == 2 + channels => {
                let (format, text) = usual(path);
                remarks.push(Remark::of_file(text));
                format
            }
            None => return Err(missing("format: theta phi BSDF")),
        };
        let turn = 90.0 - header.up;
        let wi = direction::from_degrees(theta, phi + turn);
        if wi.z.abs() < HORIZON_COSINE {
            return Err(format!(
                "intheta: expected an incident direction off the horizon, found {theta} degrees"
            ));
        }
        Ok(Self {
            quantity: format.quantity,
            separator,
            decimal: Decimal::default(),
            degrees: format.degrees,
            turn,
            channels,
            block: Block::new(wi),
            horizon: 0,
            remarks,
        })
    }

    fn take(&mut self, line: &str) -> std::result::Result<(), String> {
        let wanted = 2 + self.channels;
        let short = || self.separator.miscounted(wanted, line);
        let mut words = self.separator.fields(line);
        let mut next = || words.next().ok_or_else(short);
        let [to_theta, to_phi] = self.degrees;
        let theta = self.decimal.degrees(next()?, to_theta, "theta")?;
        let phi = self.decimal.degrees(next()?, to_phi, "phi")?;
        let wo = direction::from_degrees(theta, phi + self.turn);
        let cosine = wo.z.abs();
        let off = cosine >= HORIZON_COSINE;
        let divisor = if off && self.quantity == Quantity::Dsf { cosine } else { 1.0 };
        let start = self.block.values.len();
        for _ in 0..self.channels {
            self.block.values.push(self.decimal.value(next()?, divisor)?);
        }
        if words.next().is_some() {
            return Err(short());
        }
        if off {
            self.block.wo.push(wo);
        } else {
            self.block.values.truncate(start);
            self.horizon += 1;
        }
        Ok(())
    }

    fn finish(mut self, header: &Header, path: &Path) -> std::result::Result<FileContent, String> {
        let found = self.block.wo.len() as u64 + self.horizon;
        if let Some(declared) = header.declared.filter(|&d| d != found) {
            let message = format!("expected {declared} rows (datapoints_in_file), found {found}");
            if (found as f64) < TRUNCATED * declared as f64 {
                return Err(format!("{message}: is the file truncated?"));
            }
            self.remarks.push(Remark::of_file(message));
        }
        if self.horizon > 0 {
            self.remarks
                .push(Remark::of_file(format!("{} rows at the horizon dropped", self.horizon)));
        }
        self.block.shrink_to_fit();
        let wavelength = match &header.wavelengths[..] {
            [alone] => Some(*alone),
            _ => None,
        };
        Ok(FileContent {
            path: path.to_owned(),
            sample_name: header.sample_name.clone(),
            colorimetry: header.colorimetry()?,
            blocks: vec![self.block],
            remarks: self.remarks,
            wavelength,
        })
    }
}

/// What rows hold where no header line says so, and why: what the suffix names, else BSDF, as most
/// files do.
fn usual(path: &Path) -> (Format, String) {
    let suffix = path.extension().map(|s| Name::new(&s.to_string_lossy()));
    let named = suffix.as_ref().and_then(Quantity::of);
    let quantity = named.unwrap_or(Quantity::Bsdf);
    let (this, other) = match quantity {
        Quantity::Bsdf => {
            ("f in 1/sr", "If they contain the cosine, add \"#format: theta phi DSF\"")
        }
        Quantity::Dsf => ("f times cosine", "If they do not, add \"#format: theta phi BSDF\""),
    };
    let why = if named.is_some() { ", as the suffix says" } else { "" };
    let text = format!("no line #format: values taken as {this}{why}. {other}");
    (Format { quantity, degrees: [1.0; 2] }, text)
}
