//! The first page: a card for each material, and filters.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::html::{page, percent, text};
use super::{INDEX, SiteEntry, SiteIndex};

/// Cards can be filtered by the values of these.
const FILTERS: [(&str, &str); 5] = [
    ("class", "Class"),
    ("maker", "Maker"),
    ("symmetry", "Symmetry"),
    ("scatters", "Scatters"),
    ("licence", "Licence"),
];

/// `index.html`.
pub(super) fn index_html(index: &SiteIndex) -> String {
    let title = text(&index.title);
    let count = index.entries.len();
    let mut body = format!(
        "<header><h1>{title}</h1>\n<p>{count} materials; for programs: <a href=\"{INDEX}\">{INDEX}</a></p></header>\n<main>\n"
    );
    body += &filters(&index.entries);
    body += "<ol id=\"cards\" class=\"cards\">\n";
    for entry in &index.entries {
        card(&mut body, entry);
    }
    body += "</ol>\n</main>";
    page(&index.title, "", &body)
}

/// The form that the script shows.
fn filters(entries: &[SiteEntry]) -> String {
    let mut form = "<form id=\"filters\" role=\"search\" hidden>\n<label>Search <input type=\"search\" name=\"words\" \
                    placeholder=\"name, maker, notes …\" autocomplete=\"off\"></label>\n"
        .to_owned();
    for (field, label) in FILTERS {
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        for entry in entries {
            *counts.entry(value(entry, field)).or_default() += 1;
        }
        counts.remove("");
        if counts.is_empty() {
            continue;
        }
        write!(form, "<label>{label} <select name=\"{field}\"><option value=\"\">any</option>")
            .expect("a string takes all");
        for (value, count) in counts {
            let value = text(&value);
            write!(form, "<option value=\"{value}\">{value} ({count})</option>")
                .expect("a string takes all");
        }
        form += "</select></label>\n";
    }
    form += "<label>Sort by <select name=\"sort\"><option value=\"\">file</option><option value=\"name\">name</option>\
             <option value=\"reflectance\">reflectance</option><option value=\"transmittance\">transmittance</option></select></label>\n\
             <output id=\"count\"></output>\n</form>\n";
    form
}

/// What a card is filtered by.
fn value(entry: &SiteEntry, field: &str) -> String {
    let (record, facts) = (&entry.entry.record, &entry.entry.facts);
    match field {
        "class" => record.class.clone(),
        "maker" => record.maker.clone(),
        "symmetry" => facts.symmetry.clone(),
        "licence" => record.licence.clone(),
        _ => {
            let any = |word: &str| facts.components.iter().any(|c| c.contains(word));
            match (any("reflection"), any("transmission")) {
                (true, true) => "both ways",
                (true, false) => "reflects",
                (false, true) => "transmits",
                (false, false) => "",
            }
            .to_owned()
        }
    }
}

fn card(out: &mut String, entry: &SiteEntry) {
    let (record, facts) = (&entry.entry.record, &entry.entry.facts);
    let (id, title) = (text(&entry.entry.id), text(entry.entry.title()));
    let words: Vec<&str> = record
        .fields()
        .into_iter()
        .map(|(_, value)| value)
        .chain([&*entry.entry.id, &*facts.symmetry])
        .filter(|value| !value.is_empty())
        .collect();
    let words = words.join(" ").to_lowercase();
    let mut data = String::new();
    for (field, _) in FILTERS {
        let value = value(entry, field);
        if !value.is_empty() {
            write!(data, " data-{field}=\"{}\"", text(&value)).expect("a string takes all");
        }
    }
    let known = [&record.maker, &record.class].into_iter().filter(|s| !s.is_empty());
    let about: Vec<String> = known.map(|s| text(s).into_owned()).collect();
    let (reflects, transmits) = (facts.reflectance, facts.transmittance);
    let light: Vec<String> = [("R", reflects), ("T", transmits)]
        .into_iter()
        .filter(|(_, share)| *share > 0.0005)
        .map(|(name, share)| format!("{name} {}", percent(share)))
        .chain((!facts.symmetry.is_empty()).then(|| text(&facts.symmetry).into_owned()))
        .collect();
    writeln!(
        out,
        "<li id=\"card-{id}\" data-words=\"{}\" data-reflectance=\"{reflects:.4}\" data-transmittance=\"{transmits:.4}\"{data}>\
         <a href=\"{}\"><img src=\"{}\" alt=\"\" width=\"120\" height=\"120\" loading=\"lazy\" decoding=\"async\">\
         <h2>{title}</h2></a><p>{}</p><p class=\"light\">{}</p></li>",
        text(&words),
        text(&entry.page),
        text(&entry.picture),
        about.join(", "),
        light.join(" · "),
    )
    .expect("a string takes all");
}
