//! Names of materials, which name folders and files.

use bsdfkit::{Error, Result};

/// Bytes of a name: with what is hung onto it, it fits any file system.
const LONGEST_NAME: usize = 100;

/// Whether `name` can be a folder's and a file's everywhere, and nothing else.
///
/// Errors: format.
pub(super) fn expect_name(name: &str) -> Result<()> {
    let wrong = |what: &str| Err(Error::format(format!("expected {what}, found {name:?}")));
    if name.is_empty() || name.len() > LONGEST_NAME {
        return wrong(&format!("a name of 1 to {LONGEST_NAME} bytes"));
    }
    let allowed = |c: char| c.is_alphanumeric() || " ._-+()".contains(c);
    if !name.chars().all(allowed) {
        return wrong("letters, digits, blanks and ._-+() (it names files)");
    }
    let ends = |c: char| c == '.' || c == ' ';
    if name.starts_with(['.', '-', ' ']) || name.ends_with(ends) {
        return wrong(
            "a name that begins with a letter, a digit or _ and ends neither in . nor in a blank",
        );
    }
    // Devices of Windows, with any suffix.
    let stem = name.split('.').next().unwrap_or_default().to_ascii_lowercase();
    let numbered = |prefix: &str| {
        stem.strip_prefix(prefix)
            .is_some_and(|n| n.len() == 1 && n.bytes().all(|b| b.is_ascii_digit()))
    };
    if ["con", "prn", "aux", "nul"].contains(&&*stem) || numbered("com") || numbered("lpt") {
        return wrong("a name that is no device of Windows");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_their_folder() {
        for good in ["a", "Fabric 12", "été-3_b", "1.5 mm (white)", "console"] {
            assert!(expect_name(good).is_ok(), "{good}");
        }
        let long = "a".repeat(LONGEST_NAME + 1);
        for bad in [
            "", ".", "..", "../a", "a/b", "a\\b", "/a", "C:a", ".a", "-o", "a.", "a ", "a\0",
            "a\nb", "con", "NUL.xml", "lpt1", "<b>", "a*", &long,
        ] {
            assert!(expect_name(bad).is_err(), "{bad:?}");
        }
    }
}
