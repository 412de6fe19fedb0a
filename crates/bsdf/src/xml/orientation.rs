//! WINDOW's front is the exterior, ours the interior: the only place that knows.

use crate::Side;

/// `WavelengthDataDirection` → (incident side, scattered side), in any case.
///
/// Convention: the file's "Front" is light that arrives at the exterior, z < 0: our back.
pub(crate) fn sides(direction: &str) -> Option<(Side, Side)> {
    ALL.into_iter().find(|&(i, s)| self::direction(i, s).eq_ignore_ascii_case(direction))
}

/// Inverse of [`sides`].
pub(crate) fn direction(incident: Side, scattered: Side) -> &'static str {
    match (incident, scattered) {
        (Side::Back, Side::Front) => "Transmission Front",
        (Side::Front, Side::Back) => "Transmission Back",
        (Side::Back, Side::Back) => "Reflection Front",
        (Side::Front, Side::Front) => "Reflection Back",
    }
}

/// The four pairs of sides, in the order in which files list them.
pub(crate) const ALL: [(Side, Side); 4] = [
    (Side::Back, Side::Front),
    (Side::Back, Side::Back),
    (Side::Front, Side::Back),
    (Side::Front, Side::Front),
];
