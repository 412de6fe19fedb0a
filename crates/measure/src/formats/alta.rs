//! ALTA's lists of points.

use bsdfkit::{DVec3, Result};
use bsdfkit_sphere::direction;

use super::{Whole, as_xyz};
use crate::Colorimetry;
use crate::block::FileContent;
use crate::form::{Decimal, Separator};
use crate::gather::Gathered;

/// (θ, φ) in degrees of the incident and of the scattered direction.
type Pair = ((f64, f64), (f64, f64));

/// How directions are written: its name, numbers a row, and what they mean. Angles are radians; light is where it comes
/// from, view where it goes to, both away from the surface.
struct Parametrisation {
    name: &'static str,
    columns: usize,
    directions: fn(&[f64]) -> Pair,
}

/// Those that tell both directions.
const PARAMETRISATIONS: &[Parametrisation] = &[
    Parametrisation { name: "ISOTROPIC_TL_TV_PROJ_DPHI", columns: 3, directions: projected },
    Parametrisation {
        name: "ISOTROPIC_TV_TL_DPHI",
        columns: 3,
        directions: |x| ((x[1].to_degrees(), 0.0), (x[0].to_degrees(), x[2].to_degrees())),
    },
    Parametrisation {
        name: "SPHERICAL_TL_PL_TV_PV",
        columns: 4,
        directions: |x| {
            let [a, b, c, d] = [x[0], x[1], x[2], x[3]].map(f64::to_degrees);
            ((a, b), (c, d))
        },
    },
    Parametrisation {
        name: "CARTESIAN",
        columns: 6,
        directions: |x| {
            let of = |x: &[f64]| direction::to_degrees(DVec3::new(x[0], x[1], x[2]));
            (of(&x[3..]), of(&x[..3]))
        },
    },
];

/// (θl, θv cos Δφ, θv sin Δφ)
fn projected(x: &[f64]) -> Pair {
    let (theta, phi) = (x[1].hypot(x[2]).to_degrees(), x[2].atan2(x[1]).to_degrees());
    ((x[0].to_degrees(), 0.0), (theta, phi))
}

/// What the header says.
#[derive(Default)]
struct Header {
    directions: Option<&'static Parametrisation>,
    /// Values a row.
    values: Option<usize>,
    /// Numbers behind the values: ALTA's weights and intervals.
    behind: Option<usize>,
    with_cosine: bool,
    colorimetry: Option<Colorimetry>,
    sample_name: Option<String>,
}

impl Header {
    fn take(&mut self, line: &str) -> std::result::Result<(), String> {
        let (key, value) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let value = value.trim();
        let whole = |word: &str| {
            word.parse::<usize>().ok().filter(|n| *n <= 64).ok_or_else(|| {
                format!("{key}: expected a whole number of at most 64, found {word:?}")
            })
        };
        match key {
            "DIM" => {
                let last = value.split_whitespace().nth(1);
                let n = whole(last.unwrap_or(value))?;
                if n == 0 {
                    return Err("DIM: expected at least one value a row, found none".into());
                }
                self.values = Some(n);
            }
            "VS" => self.behind = Some(whole(value)?),
            "SAMPLE" => self.sample_name = Some(value.trim_matches('"').to_owned()),
            "PARAM_IN" => {
                let known = PARAMETRISATIONS.iter().find(|p| p.name == value);
                self.directions = Some(known.ok_or_else(|| {
                    let names: Vec<&str> = PARAMETRISATIONS.iter().map(|p| p.name).collect();
                    let names = names.join(", ");
                    format!("PARAM_IN: expected one of {names}, found {value:?}")
                })?);
            }
            "PARAM_OUT" => match value {
                "INV_STERADIAN" => {}
                "RGB_COLOR" => {
                    let names = ["r", "g", "b"].map(str::to_owned).to_vec();
                    self.colorimetry = Some(Colorimetry::Named(names));
                }
                "INV_STERADIAN_COSINE_FACTOR" => self.with_cosine = true,
                "XYZ_COLOR" => self.colorimetry = Some(Colorimetry::Xyz),
                _ => {
                    return Err(format!(
                        "PARAM_OUT: expected INV_STERADIAN, INV_STERADIAN_COSINE_FACTOR or XYZ_COLOR, found {value:?}"
                    ));
                }
            },
            _ => {}
        }
        Ok(())
    }
}

/// Reads such a file: lines `#KEY value`, then rows of the directions, as `#PARAM_IN` says, and the values.
///
/// Errors: class format, naming line, expected and found.
pub(super) fn read(whole: &Whole<'_>) -> Result<FileContent> {
    let mut lines = whole.lines();
    let mut header = Header::default();
    let mut decimal = Decimal::default();
    let (mut gathered, mut values) = (Gathered::default(), Vec::new());
    let mut count = 0;
    while let Some(line) = lines.next_line()? {
        let line = line.trim();
        if let Some(key) = line.strip_prefix('#') {
            header.take(key).map_err(|m| lines.error(m))?;
            continue;
        }
        if line.is_empty() {
            continue;
        }
        let mut taken = || -> std::result::Result<(), String> {
            let Header { directions: Some(p), values: Some(n), .. } = header else {
                return Err("expected lines #PARAM_IN and #DIM before the rows, found none".into());
            };
            let columns = p.columns + n + header.behind.unwrap_or(0);
            let words: Vec<&str> = Separator::Blanks.fields(line).collect();
            if words.len() != columns {
                return Err(Separator::Blanks.miscounted(columns, line));
            }
            let mut x = [0.0; 6];
            for (x, word) in x.iter_mut().zip(&words[..p.columns]) {
                *x = decimal.number(word, "direction")?;
            }
            let (incident, scattered) = (p.directions)(&x[..p.columns]);
            let [theta_i, theta_o] = [incident.0, scattered.0];
            if ![theta_i, theta_o].iter().all(|t| (0.0..=180.0).contains(&t.abs())) {
                return Err(format!(
                    "expected polar angles up to half a turn in radians, found {theta_i} and {theta_o} degrees"
                ));
            }
            let cosine = theta_o.to_radians().cos().abs();
            let divisor = if header.with_cosine { cosine.max(1e-4) } else { 1.0 };
            values.clear();
            for word in &words[p.columns..][..n] {
                values.push(decimal.value(word, divisor)?);
            }
            gathered.take(incident, scattered, &values)
        };
        taken().map_err(|m| lines.error(m))?;
        whole.budget.spend(&mut count, values.len(), whole.path)?;
    }
    let mut remarks: Vec<_> = lines.remark().into_iter().collect();
    let mut blocks = gathered.finish(&mut remarks);
    if blocks.is_empty() {
        return Err(lines.error("expected rows after the header, found the end of the file"));
    }
    let n = header.values.unwrap_or(1);
    let named = || Colorimetry::Named((1..=n).map(|k| format!("value {k}")).collect());
    let colorimetry = match (n, header.colorimetry) {
        (1, _) => Colorimetry::Luminance,
        (3, Some(colour)) => as_xyz(colour, &mut blocks, &mut remarks),
        _ => named(),
    };
    let path = whole.path.to_owned();
    Ok(FileContent {
        path,
        sample_name: header.sample_name,
        colorimetry,
        blocks,
        remarks,
        wavelength: None,
    })
}
