//! FRED's tables, and those of RPC Photonics, which FRED reads: rows about one specular direction after the other.

use bsdfkit::Result;
use bsdfkit::limits::is_plausible;

use super::Whole;
use crate::Colorimetry;
use crate::block::{FileContent, Remark};
use crate::form::{Decimal, Separator};
use crate::gather::Gathered;
use crate::line::quoted;

/// How FRED's second line says that angles and values are written.
#[derive(Clone, Copy, Debug)]
struct Form {
    /// Angles are direction cosines, not degrees.
    cosines: bool,
    /// Values are logarithms to base 10.
    logarithms: bool,
    scale: f64,
}

/// Reads such a file.
///
/// A row of two numbers is a specular direction (θ, φ), those of three after it are (θ, φ, f). All angles are from the
/// normal of the side that light goes to, so that light comes from φ + 180°.
///
/// Convention: neither form says whether light is reflected or transmitted. RPC Photonics makes diffusers, so that its
/// files are transmission; FRED's are taken as reflection. Both are told.
/// Errors: class format, naming line, expected and found; class limit.
pub(super) fn read(whole: &Whole<'_>) -> Result<FileContent> {
    let mut lines = whole.lines();
    let mut remarks = Vec::new();
    let mut form = Form { cosines: false, logarithms: false, scale: 1.0 };
    let mut transmitted = false;
    let mut sample_name = None;
    let mut gathered = Gathered::default();
    let mut decimal = Decimal::default();
    let mut specular = None;
    let mut count = 0;
    // Every azimuth of the direction along the normal is the same direction: their mean stands for it.
    let mut normal = Mean::default();
    let mut averaged = 0;
    while let Some(line) = lines.next_line()? {
        let line = line.trim();
        if let Some(title) = line.strip_prefix("!!") {
            transmitted = true;
            if sample_name.is_none() {
                sample_name = name_of(title);
            }
            continue;
        }
        if line.is_empty() || line.starts_with('!') {
            continue;
        }
        let mut taken = || -> std::result::Result<(), String> {
            let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            match word.to_ascii_lowercase().as_str() {
                "type" => return expect_bsdf(rest),
                "format" => {
                    form = Form::of(rest)?;
                    return Ok(());
                }
                _ => {}
            }
            let separator = Separator::of(line, if specular.is_some() { 3 } else { 2 });
            let words: Vec<&str> = separator.fields(line).collect();
            match (&words[..], specular) {
                (&[theta, phi], _) => {
                    averaged += normal.flush(&mut gathered)?;
                    let at = form.direction(theta, phi, &mut decimal)?;
                    specular = Some(incident(at));
                    Ok(())
                }
                (&[theta, phi, value], Some(incident)) => {
                    let (theta, phi) = form.direction(theta, phi, &mut decimal)?;
                    let value = form.value(value, &mut decimal)?;
                    let scattered = (if transmitted { 180.0 - theta } else { theta }, phi);
                    if theta == 0.0 {
                        normal.add(incident, scattered, value);
                        return Ok(());
                    }
                    gathered.take(incident, scattered, &[value])
                }
                (_, None) => Err(format!(
                    "expected the specular direction, two numbers, before its rows, found {} columns",
                    words.len()
                )),
                _ => Err(separator.miscounted(3, line)),
            }
        };
        taken().map_err(|m| lines.error(m))?;
        whole.budget.spend(&mut count, 1, whole.path)?;
    }
    averaged += normal.flush(&mut gathered).map_err(|m| lines.error(m))?;
    remarks.extend(lines.remark());
    let side = if transmitted { "transmission of the front" } else { "reflection of the front" };
    remarks.push(Remark::of_file(format!("the format does not say which: taken as {side}")));
    if averaged > 0 {
        let text = format!("{averaged} rows along the normal averaged, one for each incidence");
        remarks.push(Remark::of_file(text));
    }
    let blocks = gathered.finish(&mut remarks);
    if blocks.is_empty() {
        return Err(lines.error("expected rows \"theta phi value\", found the end of the file"));
    }
    let (path, colorimetry) = (whole.path.to_owned(), Colorimetry::Luminance);
    Ok(FileContent { path, sample_name, colorimetry, blocks, remarks, wavelength: None })
}

/// Where light comes from that would go on to (θ, φ).
fn incident((theta, phi): (f64, f64)) -> (f64, f64) {
    (theta, phi + 180.0)
}

/// "EDS10 0-0     RPC Photonics     10/24/2014": the diffuser, without the incidence that follows it.
fn name_of(title: &str) -> Option<String> {
    let name = title.split_whitespace().next()?;
    Some(name.to_owned())
}

fn expect_bsdf(kind: &str) -> std::result::Result<(), String> {
    match kind.trim().eq_ignore_ascii_case("bsdf_data") {
        true => Ok(()),
        false => Err(format!("type: expected bsdf_data, found {:?}", kind.trim())),
    }
}

impl Form {
    /// "angles=deg bsdf=value scale=1"
    fn of(text: &str) -> std::result::Result<Self, String> {
        let mut form = Self { cosines: false, logarithms: false, scale: 1.0 };
        for word in text.split_whitespace() {
            let (key, value) = word.split_once('=').unwrap_or((word, ""));
            let (key, value) = (key.to_ascii_lowercase(), value.to_ascii_lowercase());
            match (key.as_str(), value.as_str()) {
                ("angles", "deg") => form.cosines = false,
                ("angles", "sin") => form.cosines = true,
                ("bsdf", "value") => form.logarithms = false,
                ("bsdf", "log") => form.logarithms = true,
                ("scale", number) => {
                    form.scale = Decimal::default().number(number, "scale")?;
                }
                _ => {
                    return Err(format!(
                        "format: expected angles=deg or sin, bsdf=value or log and scale=NUMBER, found {word:?}"
                    ));
                }
            }
        }
        Ok(form)
    }

    /// θ and φ in degrees, θ ≥ 0.
    fn direction(
        self,
        a: &str,
        b: &str,
        decimal: &mut Decimal,
    ) -> std::result::Result<(f64, f64), String> {
        if self.cosines {
            let (x, y) = (decimal.number(a, "cosine x")?, decimal.number(b, "cosine y")?);
            let radius = x.hypot(y);
            if radius > 1.0 {
                return Err(format!("expected direction cosines in the unit disk, found {x} {y}"));
            }
            return Ok((radius.asin().to_degrees(), y.atan2(x).to_degrees()));
        }
        let theta = decimal.degrees(a, 1.0, "theta")?;
        let phi = decimal.degrees(b, 1.0, "phi")?;
        if theta.abs() > 90.0 {
            return Err(format!("theta: expected degrees from -90 to 90, found {theta}"));
        }
        Ok(if theta < 0.0 { (-theta, phi + 180.0) } else { (theta, phi) })
    }

    fn value(self, word: &str, decimal: &mut Decimal) -> std::result::Result<f32, String> {
        if !self.logarithms {
            return decimal.value(word, 1.0 / self.scale);
        }
        let value = self.scale * 10f64.powf(decimal.number(word, "value")?);
        match is_plausible(value) {
            true => Ok(value as f32),
            false => Err(format!("value: expected a logarithm of f, found {}", quoted(word))),
        }
    }
}

/// Rows of one incidence that are one direction.
#[derive(Default)]
struct Mean {
    at: Option<((f64, f64), (f64, f64))>,
    sum: f64,
    count: usize,
}

impl Mean {
    fn add(&mut self, incident: (f64, f64), scattered: (f64, f64), value: f32) {
        self.at.get_or_insert((incident, scattered));
        self.sum += f64::from(value);
        self.count += 1;
    }

    /// Passes the mean on; how many rows it stands for, if several.
    fn flush(&mut self, gathered: &mut Gathered) -> std::result::Result<usize, String> {
        let Self { at, sum, count } = std::mem::take(self);
        if let Some((incident, scattered)) = at {
            gathered.take(incident, scattered, &[(sum / count as f64) as f32])?;
        }
        Ok(if count > 1 { count } else { 0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_sphere::direction;

    #[test]
    fn negative_polar_angles_lie_opposite() {
        let form = Form::of("angles=deg bsdf=value scale=1").unwrap();
        let of = |a, b| form.direction(a, b, &mut Decimal::default()).unwrap();
        assert_eq!(of("-30", "0"), (30.0, 180.0));
        assert_eq!(of("30", "45"), (30.0, 45.0));
        assert_eq!(incident((30.0, 0.0)), (30.0, 180.0));
        let mirror = direction::from_degrees(30.0, 0.0);
        let wi = direction::from_degrees(30.0, 180.0);
        assert!((mirror.truncate() + wi.truncate()).length() < 1e-12);
    }

    #[test]
    fn cosines_logarithms_and_scale_are_what_the_format_says() {
        let form = Form::of("angles=sin bsdf=log scale=2").unwrap();
        let (theta, phi) = form.direction("0", "0.5", &mut Decimal::default()).unwrap();
        assert!((theta - 30.0).abs() < 1e-12 && (phi - 90.0).abs() < 1e-12);
        assert_eq!(form.value("-1", &mut Decimal::default()), Ok(0.2));
        assert!(Form::of("angles=rad").unwrap_err().contains("angles=rad"));
    }
}
