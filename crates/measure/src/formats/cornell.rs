//! The spectra of Cornell's gonioreflectometer.

use bsdfkit::Result;

use super::Whole;
use crate::Colorimetry;
use crate::block::FileContent;
use crate::form::{Decimal, Separator};
use crate::gather::Gathered;

/// Bands of a file: five times those of an instrument that steps by 1 nm from 380 to 780.
const MOST: f64 = 2000.0;

/// What comes next.
enum Expected {
    Count,
    Wavelengths(usize),
    Rows,
}

/// Reads such a file: after `# num wls` the number of wavelengths, after `# wls` these in nm, then rows
/// `theta_i phi_i theta_s phi_s` in radians with f at each wavelength.
///
/// Convention: both directions point away from the surface.
/// Errors: class format, naming line, expected and found: wavelengths that fall, too, as of a file that is garbled.
pub(super) fn read(whole: &Whole<'_>) -> Result<FileContent> {
    let mut lines = whole.lines();
    let mut decimal = Decimal::default();
    let mut expected = Expected::Count;
    let mut sample_name = None;
    let mut wavelengths: Vec<f64> = Vec::new();
    let (mut gathered, mut values) = (Gathered::default(), Vec::new());
    let mut count = 0;
    let mut titles: Vec<String> = Vec::new();
    while let Some(line) = lines.next_line()? {
        let line = line.trim();
        if let Some(title) = line.strip_prefix('#') {
            // The second of the lines at the head.
            if title.trim() == "num wls" {
                sample_name = titles.get(1).cloned();
            } else if !title.trim().is_empty() {
                titles.push(title.trim().to_owned());
            }
            continue;
        }
        if line.is_empty() {
            continue;
        }
        let mut taken = || -> std::result::Result<(), String> {
            match expected {
                Expected::Count => {
                    let n = decimal.number(line, "num wls")?;
                    if n.fract() != 0.0 || !(1.0..=MOST).contains(&n) {
                        return Err(format!("num wls: expected 1 to {MOST}, found {line}"));
                    }
                    expected = Expected::Wavelengths(n as usize);
                }
                Expected::Wavelengths(n) => {
                    for word in line.split_whitespace() {
                        let nm = decimal.number(word, "wls")?;
                        let last = wavelengths.last().copied().unwrap_or(0.0);
                        if nm <= last {
                            return Err(format!(
                                "wls: expected rising wavelengths, found {nm} after {last}"
                            ));
                        }
                        if wavelengths.len() == n {
                            return Err(format!("wls: expected {n} wavelengths, found more"));
                        }
                        wavelengths.push(nm);
                    }
                    if wavelengths.len() == n {
                        expected = Expected::Rows;
                    }
                }
                Expected::Rows => {
                    let columns = 4 + wavelengths.len();
                    let words: Vec<&str> = Separator::Blanks.fields(line).collect();
                    if words.len() != columns {
                        return Err(Separator::Blanks.miscounted(columns, line));
                    }
                    let turn = 180.0 / std::f64::consts::PI;
                    let names = ["theta_i", "phi_i", "theta_s", "phi_s"];
                    let mut angles = [0.0; 4];
                    for (k, name) in names.into_iter().enumerate() {
                        angles[k] = decimal.degrees(words[k], turn, name)?;
                    }
                    let [a, b, c, d] = angles;
                    values.clear();
                    for word in &words[4..] {
                        values.push(decimal.value(word, 1.0)?);
                    }
                    gathered.take((a, b), (c, d), &values)?;
                }
            }
            Ok(())
        };
        taken().map_err(|m| lines.error(m))?;
        whole.budget.spend(&mut count, wavelengths.len(), whole.path)?;
    }
    let mut remarks: Vec<_> = lines.remark().into_iter().collect();
    let blocks = gathered.finish(&mut remarks);
    if blocks.is_empty() {
        return Err(lines.error("expected rows after the wavelengths, found the end of the file"));
    }
    let names = wavelengths.iter().map(|nm| format!("{nm}nm")).collect();
    let (path, colorimetry) = (whole.path.to_owned(), Colorimetry::Named(names));
    Ok(FileContent { path, sample_name, colorimetry, blocks, remarks, wavelength: None })
}
