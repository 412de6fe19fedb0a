//! The page of one material.

use std::collections::HashMap;
use std::fmt::Write;

use super::html::{doi, licence, page, percent, size, text};
use super::{SiteEntry, SiteIndex, VIEWER};
use crate::entry::StoredFile;
use crate::exchange::bed::Total;

/// `materials/ID.html`; `all` are the site's entries by id, `viewer` tells whether the site has one.
pub(super) fn material_html(
    index: &SiteIndex,
    entry: &SiteEntry,
    all: &HashMap<&str, &SiteEntry>,
    viewer: bool,
) -> String {
    let title = entry.entry.title();
    let mut body = format!(
        "<header><p><a href=\"../index.html\">{}</a></p><h1>{}</h1></header>\n<main class=\"material\">\n\
         <figure><img src=\"../{}\" alt=\"A sphere of the material, lit from the upper left and from behind\" width=\"240\" height=\"240\">\
         <figcaption>Lit from the upper left, from behind on the right, and a little from all around. The same exposure for all.</figcaption></figure>\n",
        text(&index.title),
        text(title),
        text(&entry.picture),
    );
    body += &description(entry);
    body += &stated(&entry.entry.totals);
    body += &files(entry, viewer);
    body += &similar(entry, all);
    body += "</main>";
    page(&format!("{title} – {}", index.title), "../", &body)
}

fn description(entry: &SiteEntry) -> String {
    let (record, facts) = (&entry.entry.record, &entry.entry.facts);
    let plain = |value: &str| text(value).into_owned();
    let rows = [
        ("Maker", plain(&record.maker)),
        ("Class", plain(&record.class)),
        ("Instrument", plain(&record.instrument)),
        ("Date", plain(&record.date)),
        (
            "Licence",
            match &*record.licence {
                "" => "not stated: ask before you use it".to_owned(),
                known => licence(known),
            },
        ),
        ("DOI", if record.doi.is_empty() { String::new() } else { doi(&record.doi) }),
        ("Symmetry", plain(&facts.symmetry)),
        ("Components", plain(&facts.components.join(", "))),
        ("Colour", if facts.coloured { "yes" } else { "no, luminance" }.to_owned()),
        ("Reflectance along the normal", percent(facts.reflectance)),
        ("Transmittance along the normal", percent(facts.transmittance)),
        ("Notes", plain(&record.notes)),
    ];
    let mut list = "<dl>\n".to_owned();
    for (name, value) in rows.iter().filter(|(_, value)| !value.is_empty()) {
        writeln!(list, "<dt>{name}</dt><dd>{value}</dd>").expect("a string takes all");
    }
    list + "</dl>\n"
}

/// Totals as the record has them, beside those that are computed of the file.
fn stated(totals: &[Total]) -> String {
    if totals.is_empty() {
        return String::new();
    }
    let mut section = "<section><h2>As the maker or the laboratory states it</h2>\n<details open><summary>Directional-hemispherical \
                       reflectance and transmittance of the record, not computed of the files below</summary>\n\
                       <table><thead><tr><th>light falls on</th><th>of the band</th><th>polar angle</th><th>azimuth</th>\
                       <th>reflectance</th><th>transmittance</th></tr></thead><tbody>\n"
        .to_owned();
    let share = |share: Option<f64>| share.map_or(String::new(), |s| format!("{s:.3}"));
    for total in totals {
        let surface = match &*total.surface {
            "prime" => "the prime surface",
            "nonPrime" => "the other surface",
            _ => "",
        };
        writeln!(
            section,
            "<tr><td>{surface}</td><td>{}</td><td>{}°</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            text(&total.band),
            total.polar,
            total.azimuth.map_or(String::new(), |a| format!("{a}°")),
            share(total.reflectance),
            share(total.transmittance),
        )
        .expect("a string takes all");
    }
    section + "</tbody></table></details></section>\n"
}

fn files(entry: &SiteEntry, viewer: bool) -> String {
    let mut section =
        "<section><h2>Files</h2>\n<table><thead><tr><th>file</th><th>what it is</th><th>size</th>\
                       <th>SHA-256</th></tr></thead><tbody>\n"
            .to_owned();
    for file in &entry.entry.files {
        let what = match (&*file.content, &*file.form) {
            (content, form) if content == form => content.to_owned(),
            (content, form) => format!("{content}, {form}"),
        };
        writeln!(
            section,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td><code class=\"hash\">{}</code></td></tr>",
            actions(file, viewer),
            text(&what),
            size(file.bytes),
            file.sha256,
        )
        .expect("a string takes all");
    }
    section
        + "</tbody></table>\n<p>Fetch and verify: <code id=\"get\">bsdf catalog get ADDRESS-OF-THIS-PAGE</code></p></section>\n"
}

/// What can be done with a file. The viewer fetches it, which browsers forbid to pages from a disk: the script hides it there.
fn actions(file: &StoredFile, viewer: bool) -> String {
    let (path, name) = (text(&file.path), text(&file.name));
    let download = format!("<a href=\"../{path}\" download>{name}</a>");
    if !viewer {
        return download;
    }
    // Names within a site are plain ones: nothing in them means anything in an address.
    format!("{download} <a class=\"view\" href=\"../{VIEWER}#open={path}\">look at it</a>")
}

fn similar(entry: &SiteEntry, all: &HashMap<&str, &SiteEntry>) -> String {
    if entry.similar.is_empty() {
        return String::new();
    }
    let mut section = "<section><h2>Looks like</h2>\n<ol class=\"similar\">\n".to_owned();
    for near in &entry.similar {
        let Some(other) = all.get(&*near.id) else { continue };
        writeln!(
            section,
            "<li><a href=\"../{}\"><img src=\"../{}\" alt=\"\" width=\"80\" height=\"80\" loading=\"lazy\">{}</a> \
             <span title=\"distance\">{:.2}</span></li>",
            text(&other.page),
            text(&other.picture),
            text(other.entry.title()),
            near.distance,
        )
        .expect("a string takes all");
    }
    section
        + "</ol>\n<p class=\"light\">The numbers are distances: the share of light that goes elsewhere, from 0 (alike) to 2, \
           a mean over five incident directions.</p></section>\n"
}
