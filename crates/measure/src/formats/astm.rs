//! ASTM E1392 and E2387: a header, the line VARS, rows parted by commas.

use bsdfkit::Result;

use super::{Whole, as_xyz};
use crate::block::FileContent;
use crate::line::quoted;
use crate::table::{Layout, Rows, is_data};

/// Reads such a file: after `VARS theta_i,phi_i,theta_s,phi_s,…` rows of these, angles in radians unless a name says deg,
/// the other variables f in 1/sr, one a channel. R, G, B are of sRGB's primaries and become CIE XYZ.
///
/// Convention: both directions point away from the surface.
/// Errors: class format, naming line, expected and found: also for fewer rows than `NUM_POINTS` says.
pub(super) fn read(whole: &Whole<'_>) -> Result<FileContent> {
    let mut lines = whole.lines();
    let (mut declared, mut sample_name) = (None, None);
    let mut rows: Option<Rows> = None;
    let mut count = 0;
    while let Some(line) = lines.next_line()? {
        let line = line.trim();
        if let Some(rows) = &mut rows {
            if is_data(line) {
                let taken = rows.take(line);
                taken.map_err(|m| lines.error(m))?;
                whole.budget.spend(&mut count, rows.channels(), whole.path)?;
            }
            continue;
        }
        let at = line.find(|c: char| c.is_whitespace() || c == '=').unwrap_or(line.len());
        let (key, value) = (&line[..at], line[at..].trim_start_matches(['=', ' ', '\t']));
        match key.to_ascii_uppercase().as_str() {
            "NUM_POINTS" => {
                let found = value.trim().parse::<u64>();
                let text = format!("NUM_POINTS: expected a count, found {}", quoted(value));
                let found = found.map_err(|_| lines.error(text))?;
                declared = Some(found);
            }
            "SAMPLE" | "SAMPLE_NAME" | "TITLE" => {
                sample_name = Some(value.trim().to_owned()).filter(|n| !n.is_empty());
            }
            "VARS" => {
                let radian = 180.0 / std::f64::consts::PI;
                let layout = Layout::new(value, radian);
                rows = Some(Rows::new(layout.map_err(|m| lines.error(format!("VARS: {m}")))?));
            }
            _ => {}
        }
    }
    let Some(rows) = rows else {
        return Err(lines.error("expected the line VARS, found the end of the file"));
    };
    if let Some(declared) = declared.filter(|d| *d > count) {
        let text = format!("NUM_POINTS: expected {declared} rows, found {count}");
        return Err(lines.error(text));
    }
    if count == 0 {
        return Err(lines.error("expected rows after VARS, found the end of the file"));
    }
    let mut remarks: Vec<_> = lines.remark().into_iter().collect();
    let (colorimetry, mut blocks) = rows.finish(&mut remarks);
    let colorimetry = as_xyz(colorimetry, &mut blocks, &mut remarks);
    Ok(FileContent {
        path: whole.path.to_owned(),
        sample_name,
        colorimetry,
        blocks,
        remarks,
        wavelength: None,
    })
}
