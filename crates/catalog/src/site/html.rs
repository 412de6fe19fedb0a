//! Text and addresses in HTML.

use std::borrow::Cow;
use std::fmt::Write;

/// Text as it stands in HTML, in attributes too.
pub(super) fn text(text: &str) -> Cow<'_, str> {
    quick_xml::escape::escape(text)
}

/// A page: everything but what stands in its body. `root` leads to the site's root, with its slash.
pub(super) fn page(title: &str, root: &str, body: &str) -> String {
    let title = text(title);
    format!(
        r#"<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src 'self'; style-src 'self'; script-src 'self'; base-uri 'none'; form-action 'none'">
<title>{title}</title>
<link rel="stylesheet" href="{root}style.css">
<script src="{root}catalog.js" defer></script>
</head>
<body>
{body}
<footer>Made by bsdfkit {}. Nothing here is asked of another host.</footer>
</body>
</html>
"#,
        env!("CARGO_PKG_VERSION")
    )
}

/// A licence with a link to its text, if it is a single one of SPDX's list.
pub(super) fn licence(expression: &str) -> String {
    let shown = text(expression);
    match spdx::license_id(expression) {
        Some(id) => format!(
            r#"<a rel="license noreferrer" href="https://spdx.org/licenses/{}.html">{shown}</a>"#,
            text(id.name)
        ),
        None => shown.into_owned(),
    }
}

/// A DOI with a link to what it names.
pub(super) fn doi(doi: &str) -> String {
    let mut address = String::new();
    for byte in doi.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                address.push(byte.into());
            }
            _ => write!(address, "%{byte:02X}").expect("a string takes all"),
        }
    }
    format!(r#"<a rel="noreferrer" href="https://doi.org/{address}">{}</a>"#, text(doi))
}

/// 1.2 MB.
pub(super) fn size(bytes: u64) -> String {
    match bytes as f64 {
        b if b >= 1e9 => format!("{:.1} GB", b / 1e9),
        b if b >= 1e6 => format!("{:.1} MB", b / 1e6),
        b if b >= 1e3 => format!("{:.0} kB", b / 1e3),
        b => format!("{b} bytes"),
    }
}

/// A share in per cent.
pub(super) fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_a_text_is_markup() {
        let evil = r#"<script>alert("x")</script>' onload='&"#;
        let shown = text(evil);
        assert!(!shown.contains(['<', '>', '"', '\'']), "{shown}");
        for made in [licence(evil), doi(evil)] {
            assert!(!made.contains("<script") && !made.contains("onload='"), "{made}");
        }
        assert!(licence("CC-BY-4.0").contains("https://spdx.org/licenses/CC-BY-4.0.html"));
        assert!(page(evil, "", "").contains("&lt;script&gt;"));
    }

    #[test]
    fn sizes_in_words() {
        assert_eq!(
            (size(999), size(1234), size(5_600_000)),
            ("999 bytes".into(), "1 kB".into(), "5.6 MB".into())
        );
    }
}
