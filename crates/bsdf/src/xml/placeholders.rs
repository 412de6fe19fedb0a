//! Fields of `Material` that WINDOW's engine or Radiance's pkgBSDF cannot do without, where the material's are not known.
//!
//! Without them the engine's parser does not read a file as it should, and pkgBSDF has no pane to make. What is written instead is
//! called a placeholder in a comment beside it. A reader takes a field for one if that comment
//! names it and it still has the placeholder's value; so files can be read and written again and
//! again, and edited by hand, without an invention becoming knowledge.

use std::borrow::Cow;

use crate::{Error, Metadata, Result};

/// Fields with what is written where nothing is known. Of the numbers, those of Radiance's
/// template for WINDOW; the sizes in metres are guesses.
pub(super) const FIELDS: [(&str, &str); 11] = [
    ("Name", "unnamed"),
    ("Manufacturer", "unknown"),
    ("Thickness", "0.001"),
    ("Width", "1"),
    ("Height", "1"),
    ("DeviceType", "Other"),
    ("ThermalConductivity", "1"),
    ("EmissivityFront", "0.9"),
    ("EmissivityBack", "0.9"),
    ("TIR", "0.1"),
    ("EffectiveOpennessFraction", "0.05"),
];

/// How the comment begins; the names follow, parted by commas.
const COMMENT: &str = "placeholders, not known of the material:";

/// The fields that a file gets placeholders in, as `metadata` does not know them.
pub fn placeholders(metadata: &Metadata) -> Vec<&'static str> {
    let known = |field: &str| match field {
        "Name" => !metadata.name.trim().is_empty(),
        "Manufacturer" => !metadata.manufacturer.trim().is_empty(),
        "Thickness" => metadata.thickness > 0.0,
        "Width" => metadata.width > 0.0,
        "Height" => metadata.height > 0.0,
        _ => metadata.property(field).is_some_and(|value| holds(field, value)),
    };
    FIELDS.iter().map(|(field, _)| *field).filter(|field| !known(field)).collect()
}

/// Elements of `Material` and beside it that have a field of [`Metadata`] of their own.
const OWN: [&str; 6] = ["Name", "Manufacturer", "Thickness", "Width", "Height", "Geometry"];

/// Sets a property of `metadata`, under the spelling that WINDOW knows.
///
/// Errors: argument, for what has a field of its own, and for a value that WINDOW's engine would stumble over.
pub fn set_property(metadata: &mut Metadata, key: &str, value: &str) -> Result<()> {
    if let Some(own) = OWN.iter().find(|own| own.eq_ignore_ascii_case(key)) {
        return Err(Error::argument(format!(
            "property: expected a field without an option of its own, found {own} (--name, --manufacturer, --thickness, --width and --height set those, in Python the arguments of these names)"
        )));
    }
    let known = FIELDS.iter().map(|(field, _)| *field);
    let key = known.into_iter().find(|field| field.eq_ignore_ascii_case(key)).unwrap_or(key);
    if !holds(key, value) {
        let expected = match key {
            "ThermalConductivity" => "a number of at least 0",
            "EmissivityFront" | "EmissivityBack" | "TIR" | "EffectiveOpennessFraction" => {
                "a number from 0 to 1"
            }
            _ => "a text",
        };
        return Err(Error::argument(format!(
            "property {key}: expected {expected}, found {value:?}"
        )));
    }
    metadata.properties.retain(|(k, _)| !k.eq_ignore_ascii_case(key));
    metadata.properties.push((key.to_owned(), value.to_owned()));
    Ok(())
}

/// Whether a field holds `value`: text, or for what WINDOW's engine reads as a number a finite one, of shares at most 1.
fn holds(field: &str, value: &str) -> bool {
    let number = || value.trim().parse::<f64>().ok().filter(|x| x.is_finite() && *x >= 0.0);
    match field {
        "ThermalConductivity" => number().is_some(),
        "EmissivityFront" | "EmissivityBack" | "TIR" | "EffectiveOpennessFraction" => {
            number().is_some_and(|share| share <= 1.0)
        }
        _ => !value.trim().is_empty(),
    }
}

/// What is written for a field that is not known, beside fields whose values are `known`; nothing for other fields.
///
/// WINDOW's engine refuses a face whose emissivity and TIR are more than 1 together: what is known leaves the rest.
pub fn placeholder(field: &str, known: impl Fn(&str) -> Option<f64>) -> Cow<'static, str> {
    let usual = FIELDS.iter().find(|(name, _)| *name == field).map_or("", |(_, value)| value);
    let beside: &[&str] = match field {
        "TIR" => &["EmissivityFront", "EmissivityBack"],
        "EmissivityFront" | "EmissivityBack" => &["TIR"],
        _ => &[],
    };
    let left = beside.iter().filter_map(|field| known(field)).map(|share| 1.0 - share);
    let left = left.fold(1.0, f64::min).max(0.0);
    match usual.parse::<f64>() {
        Ok(share) if share > left => format!("{}", (left * 1e6).floor() / 1e6).into(),
        _ => usual.into(),
    }
}

/// The text of the comment.
pub(super) fn comment(fields: &[&str]) -> String {
    format!("{COMMENT} {}", fields.join(", "))
}

/// The fields that a comment calls placeholders; `None` for any other comment.
pub(super) fn named(comment: &str) -> Option<impl Iterator<Item = &str>> {
    Some(comment.strip_prefix(COMMENT)?.split(',').map(str::trim))
}
