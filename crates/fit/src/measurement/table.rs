//! Plain tables: CSV, TSV or blank-separated, with a line that names the columns.

use std::collections::HashMap;
use std::path::Path;

use bsdfkit::Result;
use bsdfkit_sphere::direction;

use super::Colorimetry;
use super::line::{Lines, degrees, number, quoted};
use super::scan::{Block, Budget, FileContent, HORIZON_COSINE};

/// The four columns that every table must have, in degrees.
const ANGLES: [&str; 4] = ["theta_i", "phi_i", "theta_o", "phi_o"];

/// One incident direction a row is no goniophotometer's table, and each costs a block of memory.
const MOST_INCIDENCES: usize = 20_000;

/// Five times the bands of a spectral instrument that steps by 1 nm from 380 to 780.
const MOST_COLUMNS: usize = 2000;

/// Reads a table: columns theta_i, phi_i, theta_o, phi_o in any order, the others one a channel.
///
/// Convention: degrees in Radiance's frame (θ 0–180 from +Z, φ from +X toward +Y), values f in 1/sr. A single value
/// column is luminance, columns x, y, z are CIE XYZ, any others are channels by name.
/// Errors: class format, naming line, expected and found; class limit; class io.
pub(super) fn read(path: &Path, budget: &Budget) -> Result<FileContent> {
    let mut lines = Lines::open(path)?;
    let layout = loop {
        let Some(line) = lines.next_line()? else {
            return Err(
                lines.error("expected a line that names the columns, found the end of the file")
            );
        };
        if !is_data(line) {
            continue;
        }
        match Layout::new(line) {
            Ok(layout) => break layout,
            Err(message) => return Err(lines.error(message)),
        }
    };
    let mut rows = Rows { layout, blocks: Vec::new(), index: HashMap::new(), horizon: 0 };
    let mut count = 0;
    while let Some(line) = lines.next_line()? {
        if is_data(line) {
            let taken = rows.take(line);
            taken.map_err(|m| lines.error(m))?;
            budget.spend(&mut count, path)?;
        }
    }
    if count == 0 {
        return Err(lines.error("expected rows after the column names, found the end of the file"));
    }
    let mut notes = Vec::new();
    if rows.horizon > 0 {
        notes.push(format!("{}: {} rows at the horizon dropped", path.display(), rows.horizon));
    }
    Ok(FileContent {
        path: path.to_owned(),
        sample_name: None,
        colorimetry: rows.layout.colorimetry,
        blocks: rows.blocks,
        notes,
    })
}

fn is_data(line: &str) -> bool {
    let line = line.trim_start();
    !line.is_empty() && !line.starts_with('#')
}

/// Whether `line` names columns of such a table.
pub(super) fn names_columns(line: &str) -> bool {
    let line = line.to_ascii_lowercase();
    ANGLES.iter().any(|name| line.contains(name))
}

/// Which column holds what.
struct Layout {
    separator: Option<char>,
    columns: usize,
    angles: [usize; 4],
    values: Vec<usize>,
    colorimetry: Colorimetry,
}

impl Layout {
    fn new(line: &str) -> std::result::Result<Self, String> {
        let separator = ['\t', ',', ';'].into_iter().find(|&c| line.contains(c));
        let names: Vec<String> =
            fields(line, separator).map(|f| f.trim_matches('"').to_ascii_lowercase()).collect();
        if names.len() > MOST_COLUMNS {
            return Err(format!("expected at most {MOST_COLUMNS} columns, found {}", names.len()));
        }
        let mut angles = [0; 4];
        for (place, wanted) in angles.iter_mut().zip(ANGLES) {
            let at = names.iter().position(|n| n == wanted);
            *place = at.ok_or_else(|| {
                format!(
                    "expected a column {wanted}, found the columns {}",
                    quoted(&names.join(" "))
                )
            })?;
        }
        for (i, name) in names.iter().enumerate() {
            if names[..i].contains(name) {
                return Err(format!("expected each column once, found {} twice", quoted(name)));
            }
        }
        let mut values: Vec<usize> = (0..names.len()).filter(|i| !angles.contains(i)).collect();
        if values.iter().any(|&i| names[i] == "dsf") {
            return Err(
                "expected values of f in 1/sr without cosine, found a column dsf".to_owned()
            );
        }
        let named = |wanted: &str| names.iter().position(|n| n == wanted);
        let colorimetry = match (values.len(), named("x"), named("y"), named("z")) {
            (0, ..) => return Err("expected a column of values, found only angles".to_owned()),
            (1, ..) => Colorimetry::Luminance,
            (3, Some(x), Some(y), Some(z)) => {
                values = vec![x, y, z];
                Colorimetry::Xyz
            }
            _ => Colorimetry::Named(values.iter().map(|&i| names[i].clone()).collect()),
        };
        Ok(Self { separator, columns: names.len(), angles, values, colorimetry })
    }
}

fn fields(line: &str, separator: Option<char>) -> impl Iterator<Item = &str> {
    let by_separator = separator.map(|c| line.split(c).map(str::trim));
    let by_blanks = separator.is_none().then(|| line.split_whitespace());
    by_separator.into_iter().flatten().chain(by_blanks.into_iter().flatten())
}

/// The data under way.
struct Rows {
    layout: Layout,
    blocks: Vec<Block>,
    /// Incident (θ, φ) as written → block.
    index: HashMap<(u64, u64), usize>,
    horizon: u64,
}

impl Rows {
    fn take(&mut self, line: &str) -> std::result::Result<(), String> {
        let layout = &self.layout;
        let words: Vec<&str> = fields(line, layout.separator).collect();
        if words.len() != layout.columns {
            let wanted = layout.columns;
            return Err(format!(
                "expected {wanted} columns, found {} in {}",
                words.len(),
                quoted(line)
            ));
        }
        let mut angles = [0.0; 4];
        for ((angle, &column), name) in angles.iter_mut().zip(&layout.angles).zip(ANGLES) {
            *angle = degrees(words[column], name)?;
        }
        let [theta_i, phi_i, theta_o, phi_o] = angles;
        let key = (theta_i.to_bits(), phi_i.to_bits());
        let block = match self.index.get(&key) {
            Some(&block) => block,
            None => {
                let wi = direction::from_degrees(theta_i, phi_i);
                if wi.z.abs() < HORIZON_COSINE {
                    return Err(format!(
                        "theta_i: expected a direction off the horizon, found {theta_i} degrees"
                    ));
                }
                if self.blocks.len() == MOST_INCIDENCES {
                    return Err(format!(
                        "expected at most {MOST_INCIDENCES} incident directions, found more"
                    ));
                }
                self.blocks.push(Block { wi, wo: Vec::new(), values: Vec::new() });
                self.index.insert(key, self.blocks.len() - 1);
                self.blocks.len() - 1
            }
        };
        let block = &mut self.blocks[block];
        let wo = direction::from_degrees(theta_o, phi_o);
        let start = block.values.len();
        for &column in &layout.values {
            block.values.push(number(words[column], "value")?);
        }
        if wo.z.abs() < HORIZON_COSINE {
            block.values.truncate(start);
            self.horizon += 1;
        } else {
            block.wo.push(wo);
        }
        Ok(())
    }
}
