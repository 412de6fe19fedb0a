//! Names of files and entries: what may come from a stranger, and what is made of it.

use bsdfkit::{Error, Result};

/// Characters of an entry's id.
const LONGEST: usize = 80;

/// A name for addresses and files: `a` to `z`, digits and hyphens, never empty.
pub(crate) fn slug(text: &str) -> String {
    let mut slug = String::new();
    for c in text.chars().flat_map(char::to_lowercase) {
        match plain(c) {
            c if c.is_ascii_alphanumeric() => slug.push(c),
            _ if !slug.is_empty() && !slug.ends_with('-') => slug.push('-'),
            _ => {}
        }
        if slug.len() == LONGEST {
            break;
        }
    }
    let slug = slug.trim_end_matches('-');
    if slug.is_empty() { "material".to_owned() } else { slug.to_owned() }
}

/// A letter of Western Europe without what stands above or below it.
fn plain(c: char) -> char {
    match c {
        'à'..='å' | 'æ' => 'a',
        'ç' => 'c',
        'è'..='ë' => 'e',
        'ì'..='ï' => 'i',
        'ñ' => 'n',
        'ò'..='ö' | 'ø' | 'œ' => 'o',
        'ù'..='ü' => 'u',
        'ý' | 'ÿ' => 'y',
        'ß' => 's',
        c => c,
    }
}

/// The same, with what stands behind dots kept: `Fabric 7.klems.XML` is `fabric-7.klems.xml`.
pub(crate) fn file_slug(name: &str) -> String {
    name.split('.').map(slug).collect::<Vec<_>>().join(".")
}

/// Refuses what is not the plain name of a file, on any system.
///
/// Errors: format.
pub(crate) fn expect_plain(name: &str) -> Result<()> {
    let letter = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let plain = !name.is_empty()
        && name.len() <= 255
        && name.chars().all(letter)
        && !name.starts_with('.')
        && !name.ends_with('.');
    if plain {
        return Ok(());
    }
    Err(Error::format(format!(
        "name of a file: expected letters, digits, hyphens and dots, found {name:?}"
    )))
}

/// Refuses an address within a site that is not `folder/folder/name` of plain names.
///
/// Errors: format.
pub(crate) fn expect_within(path: &str) -> Result<()> {
    path.split('/').try_for_each(expect_plain).map_err(|_| {
        Error::format(format!(
            "address of a file: expected plain names within the site, found {path:?}"
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slugs_are_plain_names() {
        for (text, expected) in [
            ("Brushed Metal/No. 7", "brushed-metal-no-7"),
            ("<script>alert(1)</script>", "script-alert-1-script"),
            ("../..", "material"),
            ("Größe", "grose"),
            ("Möbel 1½ ПВХ", "mobel-1"),
            ("", "material"),
        ] {
            assert_eq!(slug(text), expected);
            assert!(expect_plain(&slug(text)).is_ok());
        }
        assert_eq!(file_slug("Fabric 7.klems.XML"), "fabric-7.klems.xml");
        assert!(slug(&"a ".repeat(500)).len() <= LONGEST);
    }

    #[test]
    fn no_address_leaves_its_folder() {
        assert!(expect_within("files/fabric-7/fabric.xml").is_ok());
        for path in [
            "../a",
            "a/../../b",
            "/etc/passwd",
            "a//b",
            "a\\b",
            "C:a",
            "",
            "a/",
            "a/.b",
            "a/b\0",
            "http://a/b",
            "a/b?c",
            "a/%2e%2e/b",
        ] {
            assert!(expect_within(path).is_err(), "{path:?}");
        }
    }
}
