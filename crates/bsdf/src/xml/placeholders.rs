//! Fields of `Material` that WINDOW's engine cannot do without, where the material's are not known.
//!
//! Without them its parser refuses a file or takes the process down. What is written instead is
//! called a placeholder in a comment beside it. A reader takes a field for one if that comment
//! names it and it still has the placeholder's value; so files can be read and written again and
//! again, and edited by hand, without an invention becoming knowledge.

use crate::Metadata;

/// Fields with what is written where nothing is known. Of the numbers, those of Radiance's
/// template for WINDOW; the thickness in metres is a guess.
pub(super) const FIELDS: [(&str, &str); 9] = [
    ("Name", "unnamed"),
    ("Manufacturer", "unknown"),
    ("Thickness", "0.001"),
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
        _ => metadata.property(field).is_some_and(|value| !value.trim().is_empty()),
    };
    FIELDS.iter().map(|(field, _)| *field).filter(|field| !known(field)).collect()
}

/// What is written for a field that is not known.
pub(super) fn placeholder(field: &str) -> &'static str {
    FIELDS.iter().find(|(name, _)| *name == field).map_or("", |(_, value)| value)
}

/// The text of the comment.
pub(super) fn comment(fields: &[&str]) -> String {
    format!("{COMMENT} {}", fields.join(", "))
}

/// The fields that a comment calls placeholders; `None` for any other comment.
pub(super) fn named(comment: &str) -> Option<impl Iterator<Item = &str>> {
    Some(comment.strip_prefix(COMMENT)?.split(',').map(str::trim))
}
