//! The header of Mountain files: `#key value` lines in the dialects that exist.

use bsdfkit::spectrum::Bands;

use super::Colorimetry;
use super::form::Decimal;
use super::line::quoted;
use super::names::{Meaning, Name, in_degrees, is_no_unit_of_f};

/// What the value column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    /// f |cos θo|.
    Dsf,
    /// f.
    Bsdf,
}

impl Quantity {
    /// The quantity that a name stands for.
    pub(super) fn of(name: &Name) -> Option<Self> {
        match name.meaning? {
            Meaning::Bsdf => Some(Self::Bsdf),
            Meaning::Dsf => Some(Self::Dsf),
            _ => None,
        }
    }
}

/// What the columns of the rows are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Format {
    pub(super) quantity: Quantity,
    /// What θ and φ are to be multiplied with to be degrees.
    pub(super) degrees: [f64; 2],
}

/// The header's keys, as far as they were met.
#[derive(Default)]
pub(super) struct Header {
    pub(super) sample_name: Option<String>,
    pub(super) format: Option<Format>,
    pub(super) theta: Option<f64>,
    pub(super) phi: Option<f64>,
    pub(super) up: f64,
    pub(super) colorimetry: Option<Colorimetry>,
    pub(super) declared: Option<u64>,
    /// In nanometres, one a column of values.
    pub(super) wavelengths: Vec<f64>,
}

/// Keys with which Radiance's reader knows an angle: their values must be numbers. What follows another spelling may be
/// a sentence, and is one where no number comes.
const STRICT: [&str; 4] = ["intheta", "inphi", "incident_angle", "upphi"];

impl Header {
    /// Takes one header line, its `#` removed: a key, blanks, `:` or `=`, a value; or the value at once, where it is a
    /// number. Keys that are not known are comments.
    pub(super) fn take(&mut self, line: &str) -> Result<(), String> {
        let line = line.trim();
        let (key, rest) = line.split_at(end_of_key(line));
        let (unit, value) = unit_before(rest.trim_start());
        let value = value.trim_start().strip_prefix([':', '=']).unwrap_or(value).trim();
        let sentence = !STRICT.contains(&&*key.to_ascii_lowercase())
            && !value.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        match Name::new(key).meaning {
            Some(Meaning::IncidentTheta) if !sentence => {
                [self.theta] = angles(value, unit, ["intheta"])?.map(Some);
            }
            Some(Meaning::IncidentPhi) if !sentence => {
                [self.phi] = angles(value, unit, ["inphi"])?.map(Some);
            }
            Some(Meaning::IncidentAngles) if !sentence => {
                let what = ["incident_angle: theta", "incident_angle: phi"];
                [self.theta, self.phi] = angles(value, unit, what)?.map(Some);
            }
            Some(Meaning::Up) if !sentence => [self.up] = angles(value, unit, ["upphi"])?,
            Some(Meaning::SampleName) => {
                self.sample_name = Some(value.trim_matches(['"', '\'']).to_owned());
            }
            Some(Meaning::Format) => self.format = Some(format(value)?),
            // the names of the columns without the key
            Some(Meaning::Theta) if self.format.is_none() => self.format = format(line).ok(),
            Some(Meaning::Colorimetry) => self.colorimetry = Some(colorimetry(value)?),
            Some(Meaning::Wavelength) if !sentence => match wavelengths(value, unit) {
                Ok(found) => self.wavelengths = found,
                // "wavelength: 380 to 780 nm" is about the instrument.
                Err(message) if key.eq_ignore_ascii_case("lambda") => return Err(message),
                Err(_) => {}
            },
            Some(Meaning::Rows) => {
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

impl Header {
    /// What the columns of values are.
    ///
    /// Errors: the message, for several wavelengths of columns that are said to be something else.
    pub(super) fn colorimetry(&self) -> Result<Colorimetry, String> {
        match (&self.wavelengths[..], &self.colorimetry) {
            ([] | [_], said) => Ok(said.clone().unwrap_or(Colorimetry::Luminance)),
            (several, None | Some(Colorimetry::Luminance)) => {
                Ok(Colorimetry::Named(several.iter().map(|w| format!("{w}nm")).collect()))
            }
            (several, Some(said)) => Err(format!(
                "lambda: expected no wavelengths of columns of {said}, found {}",
                several.len()
            )),
        }
    }
}

/// Letters, and what joins them; a number may follow at once.
fn end_of_key(line: &str) -> usize {
    let mut ahead = line.char_indices().peekable();
    while let Some((at, c)) = ahead.next() {
        let joins = c == '-' && ahead.peek().is_some_and(|(_, next)| next.is_alphabetic());
        if !(c.is_alphabetic() || c == '_' || joins) {
            return at;
        }
    }
    line.len()
}

/// `[deg]: 30`: the unit in brackets, and what follows.
fn unit_before(rest: &str) -> (Option<&str>, &str) {
    let bracketed = rest.strip_prefix(['[', '(']).and_then(|r| r.split_once([']', ')']));
    bracketed.map_or((None, rest), |(unit, value)| (Some(unit), value))
}

/// The first numbers in `value` as degrees, with `unit` or one behind them.
fn angles<const N: usize>(
    value: &str,
    unit: Option<&str>,
    what: [&str; N],
) -> Result<[f64; N], String> {
    let value = value.replace('°', " deg ").to_lowercase();
    let mut factor = match unit {
        Some(unit) => in_degrees(&unit.trim().to_lowercase())
            .ok_or_else(|| format!("{}: expected deg or rad, found {}", what[0], quoted(unit)))?,
        None => 1.0,
    };
    // "30,5 0" has decimal commas, "30,0" two numbers where two are wanted
    let one_word = !value.trim().contains([' ', '\t', ';']);
    let parts = |c: char| c.is_whitespace() || c == ';' || (c == ',' && N > 1 && one_word);
    let mut words = Vec::new();
    for word in value.split(parts).map(|w| w.trim_end_matches(',')).filter(|w| !w.is_empty()) {
        match in_degrees(word.trim_matches(['[', ']', '(', ')'])) {
            Some(other) => factor = other,
            None => words.push(word),
        }
    }
    let mut decimal = Decimal::default();
    let mut angles = [0.0; N];
    for (k, angle) in angles.iter_mut().enumerate() {
        *angle = decimal.degrees(words.get(k).unwrap_or(&""), factor, what[k])?;
    }
    Ok(angles)
}

/// The wavelengths in `value` in nanometres, with `unit` or one behind them.
pub(super) fn wavelengths(value: &str, unit: Option<&str>) -> Result<Vec<f64>, String> {
    let in_nanometres = |unit: &str| match unit.trim() {
        "nm" => Some(1.0),
        "um" | "µm" | "μm" => Some(1000.0),
        _ => None,
    };
    let refused =
        |found: &str| format!("lambda: expected wavelengths in nm or um, found {}", quoted(found));
    let mut factor = match unit {
        Some(unit) => in_nanometres(unit).ok_or_else(|| refused(unit))?,
        None => 1.0,
    };
    let (mut found, mut decimal) = (Vec::new(), Decimal::default());
    let parts = |c: char| c.is_whitespace() || c == ';' || c == ',';
    for word in value.split(parts).filter(|word| !word.is_empty()) {
        let end = word.find(|c: char| c.is_alphabetic()).unwrap_or(word.len());
        let (number, behind) = word.split_at(end);
        if !behind.is_empty() {
            factor = in_nanometres(behind).ok_or_else(|| refused(word))?;
        }
        if !number.is_empty() {
            found.push(decimal.number(number, "lambda").map_err(|_| refused(word))?);
        }
    }
    let [least, most] = Bands::RANGE;
    found.iter_mut().for_each(|w| *w *= factor);
    match found.iter().find(|w| !(least..=most).contains(*w)) {
        Some(w) => Err(format!("lambda: expected {least} to {most} nm, found {w}")),
        None if found.is_empty() => Err(refused(value)),
        None => Ok(found),
    }
}

fn format(value: &str) -> Result<Format, String> {
    let names = Name::all_in(value);
    let expected = |why: &str| {
        Err(format!(
            "format: expected theta phi and one of DSF, BSDF, BRDF, BTDF, found {}{why}",
            quoted(value)
        ))
    };
    let currents = names.iter().any(|n| n.unit.as_deref().is_some_and(is_no_unit_of_f));
    if currents {
        return expected(": signals of the detector, not calibrated; export them as DSF or BSDF");
    }
    match &names[..] {
        [theta, phi, values, more @ ..]
            if theta.meaning == Some(Meaning::Theta) && phi.meaning == Some(Meaning::Phi) =>
        {
            // Of spectra a column a wavelength.
            let all_alike = more.iter().all(|name| name.meaning == values.meaning);
            let Some(quantity) = Quantity::of(values).filter(|_| all_alike) else {
                return expected("");
            };
            let unit = |name: &Name| name.degrees().map_err(|m| format!("format: {m}"));
            Ok(Format { quantity, degrees: [unit(theta)?, unit(phi)?] })
        }
        _ => expected(""),
    }
}

fn colorimetry(value: &str) -> Result<Colorimetry, String> {
    match value.trim_matches('"').to_ascii_uppercase().as_str() {
        "CIE-Y" => Ok(Colorimetry::Luminance),
        "CIE-XYZ" => Ok(Colorimetry::Xyz),
        _ => Err(format!("colorimetry: expected CIE-Y or CIE-XYZ, found {}", quoted(value))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(lines: &[&str]) -> Header {
        let mut header = Header::default();
        for line in lines {
            header.take(line).unwrap_or_else(|e| panic!("{line}: {e}"));
        }
        header
    }

    #[test]
    fn angles_in_every_spelling() {
        for line in [
            "intheta 30.5",
            "intheta\t30.5",
            "intheta30.5",
            "theta_in30.5",
            "theta_in: 30.5",
            "theta_in = 30.5",
            "theta_in=30.5",
            "Theta_I 30.5",
            " IncidentTheta [deg] 30.5",
            "intheta (deg): 30.5",
            "intheta 30.5 deg",
            "intheta 30.5°",
            "θ_i 30,5",
            "intheta 30.5 measured on a Tuesday",
            "theta_in 0.53232543 rad",
            "intheta [rad]: 0.53232543",
        ] {
            let theta = header(&[line]).theta.unwrap_or_else(|| panic!("{line}"));
            assert!((theta - 30.5).abs() < 1e-6, "{line}: {theta}");
        }
        for line in [
            "incident_angle 30.5 -2",
            "incident_angle30.5 -2",
            "incident_angle: 30.5, -2",
            "incident_angle 30.5,-2",
            "incident_angle 30,5;-2",
            "incident_angle [deg] 30,5 -2",
        ] {
            let h = header(&[line]);
            assert_eq!((h.theta, h.phi), (Some(30.5), Some(-2.0)), "{line}");
        }
        assert_eq!(header(&["phi_in-30"]).phi, Some(-30.0));
        assert_eq!(header(&["upphi90"]).up, 90.0);
        assert_eq!(header(&["datapoints_in_file120"]).declared, Some(120));
        assert!(Header::default().take("intheta thirty").is_err());
        assert!(
            Header::default().take("intheta [mm] 3").unwrap_err().contains("expected deg or rad")
        );
    }

    #[test]
    fn sentences_are_comments() {
        let h = header(&[
            "theta_i is the incident angle",
            "incident-light from a lamp",
            "up to 3 rows",
            "theta and phi",
            "2 theta",
        ]);
        assert_eq!((h.theta, h.phi, h.up, h.format), (None, None, 0.0, None));
    }

    #[test]
    fn wavelengths_of_one_column_or_several() {
        assert_eq!(header(&["lambda 550"]).wavelengths, [550.0]);
        assert_eq!(header(&["lambda: 0.55 um"]).wavelengths, [550.0]);
        let several = header(&["wavelength [nm] = 450, 550 650"]);
        assert_eq!(several.wavelengths, [450.0, 550.0, 650.0]);
        assert_eq!(several.colorimetry().unwrap().channels(), 3);
        for (line, found) in [("lambda 550 inch", "inch"), ("lambda 5.5", "5.5")] {
            let message = Header::default().take(line).expect_err(line);
            assert!(message.contains(found), "{message}");
        }
        // Words about the instrument.
        assert!(
            header(&["wavelength: 380 to 780 nm", "lambda of the laser"]).wavelengths.is_empty()
        );
        let both = header(&["colorimetry: CIE-XYZ", "lambda 450 550 650"]).colorimetry();
        assert!(both.expect_err("both").contains("CIE XYZ"));
    }

    #[test]
    fn formats() {
        let plain = |quantity| Some(Format { quantity, degrees: [1.0; 2] });
        for (line, quantity) in [
            ("format: theta phi DSF", Quantity::Dsf),
            ("format theta\tphi\tBRDF", Quantity::Bsdf),
            ("format=theta, phi, ccBSDF", Quantity::Dsf),
            ("Format: Theta [deg] Phi [deg] BTDF [1/sr]", Quantity::Bsdf),
            ("theta phi BRDF", Quantity::Bsdf),
        ] {
            assert_eq!(header(&[line]).format, plain(quantity), "{line}");
        }
        let radians = header(&["format: theta [rad] phi [deg] DSF"]).format.unwrap();
        assert_eq!(radians.degrees, [180.0 / std::f64::consts::PI, 1.0]);
        let currents = Header::default().take("format: theta\tphi\t[uA]").unwrap_err();
        assert!(currents.contains("not calibrated"), "{currents}");
    }
}
