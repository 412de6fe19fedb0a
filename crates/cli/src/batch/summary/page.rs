//! The summary as one page, without scripts: texts of files and of people are never markup.

use std::fmt::Write;

use percent_encoding::{NON_ALPHANUMERIC, utf8_percent_encode};
use quick_xml::escape::escape;

use super::{Line, digits};

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;margin:2em auto;max-width:80em;padding:0 1em;color:#222;background:#fff}
table{border-collapse:collapse;width:100%}
th,td{text-align:left;padding:.3em .7em;border-bottom:1px solid #ddd;vertical-align:top}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}
tr.failed td{background:#fdecea}.error{color:#9b1c10;white-space:pre-wrap;overflow-wrap:anywhere}
@media (prefers-color-scheme:dark){body{color:#ddd;background:#181818}th,td{border-color:#444}a{color:#8ab4f8}
tr.failed td{background:#3a1f1c}.error{color:#f3a69c}}";

/// The whole page.
pub(super) fn page(lines: &[Line<'_>]) -> String {
    let count = |status| lines.iter().filter(|l| l.status() == status).count();
    let [done, failed, left] = ["done", "failed", "to do"].map(count);
    let heads = ["points", "fit error", "between", "energy", "time s", "CPU s", "MB"];
    let heads = heads.map(|h| format!(r#"<th class="n">{h}</th>"#)).concat();
    let rows: String = lines.iter().map(row).collect();
    format!(
        r#"<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'">
<title>{done} of {} materials</title>
<style>{STYLE}</style>
</head>
<body>
<h1>{done} done, {failed} failed, {left} to do</h1>
<p>Errors are shares of the scattered light in a wrong place: at the incidences, and to expect between them. Energy: the largest share of
light that goes on, of either side at 0, 30 and 60 degrees from the normal.</p>
<table>
<thead><tr><th>material</th><th>status</th>{heads}<th>files</th></tr></thead>
<tbody>
{rows}</tbody>
</table>
<footer><p>Made by bsdfkit {}.</p></footer>
</body>
</html>
"#,
        lines.len(),
        env!("CARGO_PKG_VERSION")
    )
}

fn row(line: &Line<'_>) -> String {
    let f = line.figures();
    let name = &line.job.name;
    let link = |file: &str, text: &str| {
        let [folder, file] = [name, file].map(|t| utf8_percent_encode(t, NON_ALPHANUMERIC));
        format!(r#"<a href="{folder}/{file}">{}</a>"#, escape(text))
    };
    let short =
        |file: &str| file.strip_prefix(&**name).unwrap_or(file).trim_start_matches('.').to_owned();
    let mut files: Vec<String> = line.files().map(|file| link(file, &short(file))).collect();
    if line.state.is_some() {
        files.push(link(&line.job.log(), "log"));
    }
    let numbers = [
        f.points.map(|n| n.to_string()).unwrap_or_default(),
        digits(f.fit_error, 4),
        digits(f.between, 4),
        digits(f.energy, 4),
        digits(f.seconds, 1),
        digits(f.cpu_seconds, 1),
        digits(f.peak_bytes.map(|b| b / 1e6), 0),
    ];
    let numbers = numbers.map(|n| format!(r#"<td class="n">{n}</td>"#)).concat();
    let status = line.status();
    let mut said = escape(status).into_owned();
    if !line.error().is_empty() {
        let _ = write!(said, r#"<div class="error">{}</div>"#, escape(line.error()));
    }
    format!(
        "<tr class=\"{}\"><td>{}</td><td>{said}</td>{numbers}<td>{}</td></tr>\n",
        status.replace(' ', ""),
        escape(&**name),
        files.join(" ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::job::Job;
    use crate::batch::state::{State, Status};
    use serde_json::Value;

    #[test]
    fn nothing_of_a_text_is_markup() {
        let evil = "<script>alert(\"x\")</script>' onload='";
        let job = Job::new("a b+(é)".into(), Vec::new(), Vec::new(), Vec::new(), String::new());
        let state = State {
            key: String::new(),
            status: Status::Failed,
            error: evil.into(),
            outputs: vec![(evil.into(), 1, String::new())],
            seconds: 1.0,
            report: Value::Null,
        };
        let page = page(&[Line { job: &job, state: Some(state) }]);
        assert!(!page.contains("<script") && !page.contains("onload='"), "{page}");
        assert!(page.contains("href=\"a%20b%2B%28%C3%A9%29/a%20b"), "{page}");
        assert!(page.contains("&lt;script&gt;"));
    }
}
