//! What the words of headers and column names mean: the one table of dialects.
//!
//! A name is compared by its letters and digits alone: `theta_i`, `Theta I`, `"θi"` are one name. A unit may stand
//! behind it: `theta_i [rad]`, `theta_i(deg)`, `theta_i_deg`, `phi_i °`; degrees where none does.

use super::form::Separator;

/// What a name stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// θ of the incident direction.
    IncidentTheta,
    /// φ of the incident direction.
    IncidentPhi,
    /// θ of the scattered direction.
    ScatteredTheta,
    /// φ of the scattered direction.
    ScatteredPhi,
    /// θ of whatever the row is about.
    Theta,
    /// φ of whatever the row is about.
    Phi,
    /// θ and φ of the incident direction.
    IncidentAngles,
    /// φ of the specimen's "up".
    Up,
    /// f in 1/sr.
    Bsdf,
    /// f |cos θo| in 1/sr.
    Dsf,
    /// The name of the specimen.
    SampleName,
    /// What the columns are.
    Format,
    /// Which colours.
    Colorimetry,
    /// How many rows.
    Rows,
    /// The wavelength of the row.
    Wavelength,
    /// Angles of another parametrisation.
    HalfAngle,
    /// No value of f: the number of the row, an uncertainty.
    Beside,
}

use Meaning::{
    Beside, Bsdf, Colorimetry, Dsf, Format, HalfAngle, IncidentAngles, IncidentPhi, IncidentTheta,
    Phi, Rows, SampleName, ScatteredPhi, ScatteredTheta, Theta, Up, Wavelength,
};

/// Spellings by their letters and digits. Sources: Radiance's reader (intheta, inphi, incident_angle, upphi, format,
/// colorimetry, sample_name, datapoints_in_file), Mitsuba's exporter and Tekari (theta_in, phi_in), Ignis (i_phi),
/// ASTM E2387 (theta_i, theta_s), tables of renderers and papers (theta_r, theta_o, theta_out, CCBSDF).
#[rustfmt::skip] // one meaning a paragraph
const NAMES: &[(Meaning, &[&str])] = &[
    (IncidentTheta, &["intheta", "thetain", "thetai", "itheta", "thetainc", "thetaincident", "thetaincidence",
        "incidenttheta", "incomingtheta", "aoi"]),
    (IncidentPhi, &["inphi", "phiin", "phii", "iphi", "phiinc", "phiincident", "phiincidence", "incidentphi",
        "incomingphi"]),
    (ScatteredTheta, &["thetao", "thetaout", "thetas", "thetar", "thetat", "thetascattered", "thetascatter",
        "thetareflected", "thetatransmitted", "thetav", "thetaview", "thetaoutgoing", "outtheta", "otheta",
        "scattertheta", "scatteredtheta", "outgoingtheta"]),
    (ScatteredPhi, &["phio", "phiout", "phis", "phir", "phit", "phiscattered", "phiscatter", "phireflected",
        "phitransmitted", "phiv", "phiview", "phioutgoing", "outphi", "ophi", "scatterphi", "scatteredphi",
        "outgoingphi"]),
    (Theta, &["theta"]),
    (Phi, &["phi"]),
    (IncidentAngles, &["incidentangle", "incidentangles"]),
    (Up, &["upphi", "phiup"]),
    (Bsdf, &["bsdf", "brdf", "btdf"]),
    (Dsf, &["dsf", "ccbsdf", "ccbrdf", "ccbtdf", "bsdfcos", "brdfcos", "btdfcos", "cosbsdf", "cosbrdf", "cosbtdf"]),
    (SampleName, &["samplename"]),
    (Format, &["format"]),
    (Colorimetry, &["colorimetry", "colourimetry"]),
    (Rows, &["datapointsinfile"]),
    (Wavelength, &["wavelength", "wavelengthnm", "lambda", "wl"]),
    (HalfAngle, &["thetah", "thetad", "phih", "phid", "thetahalf", "thetadiff", "phihalf", "phidiff", "dphi",
        "phidelta", "deltaphi"]),
    (Beside, &["", "index", "row", "no", "nr", "uncertainty", "sigma", "std", "stdev", "stddev", "error", "snr"]),
];

/// What `letters` (of [`Name`]) stand for.
fn meaning(letters: &str) -> Option<Meaning> {
    NAMES.iter().find(|(_, spellings)| spellings.contains(&letters)).map(|(meaning, _)| *meaning)
}

/// A name in a header or above a column.
#[derive(Debug)]
pub(super) struct Name {
    /// As written, without quotes, in small letters.
    pub(super) text: String,
    /// Its letters and digits, without the unit.
    pub(super) letters: String,
    /// What it stands for, if that is known.
    pub(super) meaning: Option<Meaning>,
    /// The unit behind it, as it is written.
    pub(super) unit: Option<String>,
}

impl Name {
    /// Reads a name, quoted or not, with its unit.
    pub(super) fn new(text: &str) -> Self {
        let text = text.trim().trim_matches(['"', '\'']).to_lowercase();
        let spelt = text.replace('θ', "theta").replace(['φ', 'ϕ'], "phi").replace('°', " deg");
        let (name, unit) = match spelt.find(['[', '(']) {
            Some(at) => {
                (&spelt[..at], Some(spelt[at + 1..].split([']', ')']).next().unwrap_or("").trim()))
            }
            None => split_unit(&spelt),
        };
        let letters: String = name.chars().filter(|c| c.is_alphanumeric()).collect();
        // CCBSDF by words: "BRDF * cos", "cosine-corrected BRDF (1/sr)", "ccbrdf 550nm"
        let known = meaning(&letters).or_else(|| contains_cosine(name).then_some(Dsf));
        let unit = unit.map(str::to_owned);
        Self { text, letters, meaning: known, unit }
    }

    /// The names above the columns of a table.
    pub(super) fn all_in(line: &str) -> Vec<Self> {
        let separator = Separator::of_names(line);
        let mut names: Vec<String> = Vec::new();
        for field in separator.fields(line) {
            match names.last_mut() {
                // "theta_i [deg] phi_i [deg]"
                Some(last) if separator == Separator::Blanks && field.starts_with(['[', '(']) => {
                    *last += field;
                }
                _ => names.push(field.to_owned()),
            }
        }
        names.iter().map(|name| Self::new(name)).collect()
    }

    /// What an angle under this name is to be multiplied with to be degrees.
    ///
    /// Errors: the message for a unit that is none of an angle.
    pub(super) fn degrees(&self) -> Result<f64, String> {
        match self.unit.as_deref() {
            None => Ok(1.0),
            Some(unit) => in_degrees(unit).ok_or_else(|| {
                format!("expected an angle in deg or rad, found the unit \"{unit}\"")
            }),
        }
    }
}

/// What an angle in `unit` is to be multiplied with to be degrees, if it is a unit of angles.
pub(super) fn in_degrees(unit: &str) -> Option<f64> {
    match unit.trim_end_matches('.') {
        "deg" | "degree" | "degrees" | "°" => Some(1.0),
        "rad" | "radian" | "radians" => Some(180.0 / std::f64::consts::PI),
        _ => None,
    }
}

/// Whether values in `unit` are surely none of f: percent, and what detectors give.
pub(super) fn is_no_unit_of_f(unit: &str) -> bool {
    unit.contains('%')
        || ["a", "ma", "ua", "µa", "μa", "na", "pa", "v", "mv", "counts"].contains(&unit)
}

/// `theta_i_deg`, `phi_i / rad`, `theta_o in degrees`: the unit apart.
fn split_unit(text: &str) -> (&str, Option<&str>) {
    let apart = |c: char| !c.is_alphanumeric();
    let text = text.trim_end_matches(apart);
    let at =
        text.rfind(apart).map_or(0, |at| at + text[at..].chars().next().map_or(1, char::len_utf8));
    match (at, in_degrees(&text[at..])) {
        (1.., Some(_)) => {
            let name = text[..at].trim_end_matches(apart);
            (name.strip_suffix(" in").unwrap_or(name), Some(&text[at..]))
        }
        _ => (text, None),
    }
}

fn contains_cosine(name: &str) -> bool {
    let words = || name.split(|c: char| !c.is_alphanumeric());
    let means = |wanted| words().any(|word| meaning(word) == Some(wanted));
    means(Dsf) || means(Bsdf) && words().any(|w| ["cos", "cosine", "costheta"].contains(&w))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_known_by_their_letters() {
        for (text, meaning) in [
            ("theta_i", IncidentTheta),
            (" \"Theta I\" ", IncidentTheta),
            ("θi", IncidentTheta),
            ("theta_in", IncidentTheta),
            ("PHI-R", ScatteredPhi),
            ("theta_s [deg]", ScatteredTheta),
            ("phi_out(deg)", ScatteredPhi),
            ("BTDF (1/sr)", Bsdf),
            ("ccBSDF", Dsf),
            ("ccbrdf_550nm", Dsf),
            ("BRDF * cos", Dsf),
            ("Cosine-corrected BRDF", Dsf),
            ("theta_d", HalfAngle),
        ] {
            assert_eq!(Name::new(text).meaning, Some(meaning), "{text}");
        }
        for text in ["value", "450nm", "cos", "brdf_550nm"] {
            assert_eq!(Name::new(text).meaning, None, "{text}");
        }
    }

    #[test]
    fn units_stand_behind_names() {
        let turn = 180.0 / std::f64::consts::PI;
        for (text, factor) in [
            ("theta_i", 1.0),
            ("theta_i [deg]", 1.0),
            ("theta_i(°)", 1.0),
            ("theta_i °", 1.0),
            ("theta_i_degrees", 1.0),
            ("theta_i [rad]", turn),
            ("theta_i(RAD)", turn),
            ("theta_i_rad", turn),
            ("theta_i / rad", turn),
            ("theta_i in radians", turn),
        ] {
            let name = Name::new(text);
            assert_eq!((name.meaning, name.degrees()), (Some(IncidentTheta), Ok(factor)), "{text}");
        }
        assert!(Name::new("theta_i [mm]").degrees().unwrap_err().contains("\"mm\""));
        assert_eq!(Name::new("deg").unit, None);
    }
}
