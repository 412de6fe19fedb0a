//! A corrected copy: read, mended and written anew.

use super::blocks::{self, Outline};
use super::catalogue::KINDS;
use super::examine::{Examination, Finding, examine};
use super::kind::Mends;
use super::light::exchanged_reflection;
use super::remedy;
use crate::xml::decode::decode;
use crate::xml::document::Document;
use crate::xml::read::read_document;
use crate::xml::report::Report;
use crate::xml::{Limits, WriteOptions, write_to};
use crate::{Bsdf, Component, Error, Lambertian, Result};

/// What came of mending a file.
#[derive(Debug)]
pub struct Mended {
    /// The corrected copy; the file itself where there was nothing to mend.
    pub bytes: Vec<u8>,
    /// What is no longer there, each with how it was mended.
    pub changes: Vec<(Finding, &'static str)>,
    /// What is found in the copy.
    pub left: Vec<Finding>,
}

/// Digits that keep every bit of an f32.
const DIGITS: usize = 9;

/// Mending one thing can show another that was hidden behind it.
const PASSES: usize = 4;

/// Mends what can be mended for every program; of what is [`Mends::Asked`] the codes in `also`.
///
/// Where there is nothing to mend the copy is the file, byte by byte; so mending twice changes nothing. What is not
/// known is not made up, but for placeholders in the description. Values stay as they are unless a change says otherwise.
///
/// Errors: argument, for a code that cannot be asked for; format and limit, for a file that cannot be read.
/// Cost: some readings of the file.
pub fn mend(bytes: &[u8], also: &[&str], limits: &Limits) -> Result<Mended> {
    let askable =
        |code: &str| KINDS.iter().any(|k| k.code == code && matches!(k.mends, Mends::Asked(_)));
    if let Some(other) = also.iter().find(|code| !askable(code)) {
        let codes = KINDS.iter().map(|k| k.code).filter(|code| askable(code));
        let codes = codes.collect::<Vec<_>>().join(", ");
        return Err(Error::argument(format!("also: expected one of {codes}, found {other:?}")));
    }
    let mut bytes = bytes.to_vec();
    let mut changes = Vec::new();
    let mut seen = examine(&bytes, limits);
    for _ in 0..PASSES {
        let todo = |f: &Finding| how(f, also).is_some();
        if !seen.findings.iter().any(todo) {
            break;
        }
        let Some(next) = pass(&bytes, &seen, also, limits)? else { break };
        let after = examine(&next, limits);
        let gone = |f: &&Finding| !after.findings.iter().any(|a| is_same(a, f));
        let mended =
            seen.findings.iter().filter(gone).filter_map(|f| Some((f.clone(), how(f, also)?)));
        let mended: Vec<_> = mended.collect();
        if mended.is_empty() {
            break;
        }
        changes.extend(mended);
        (bytes, seen) = (next, after);
    }
    match seen.error {
        Some(error) => Err(error),
        None => Ok(Mended { bytes, changes, left: seen.findings }),
    }
}

/// How a finding is mended, if it is.
fn how(finding: &Finding, also: &[&str]) -> Option<&'static str> {
    match finding.kind.mends {
        Mends::Always(how) => Some(how),
        Mends::Asked(how) if also.contains(&finding.kind.code) => Some(how),
        _ => None,
    }
}

/// Whether it is the same finding: lines move when a file is written anew, sides do not.
fn is_same(a: &Finding, b: &Finding) -> bool {
    a.kind.code == b.kind.code && (a.place == b.place || b.place.starts_with("line"))
}

/// The file written anew; `None` where it cannot be read.
fn pass(
    bytes: &[u8],
    seen: &Examination,
    also: &[&str],
    limits: &Limits,
) -> Result<Option<Vec<u8>>> {
    let has = |code: &str| seen.findings.iter().any(|f| f.kind.code == code);
    let mut report = Report::without_warnings(1);
    let text = decode(bytes, &mut report)?;
    let Some(document) = Document::parse(&text, limits, &mut report) else { return Ok(None) };
    let outline = Outline::of(&document);
    let shares = blocks::fractional(&outline);
    let bsdf = match blocks::as_values(&text, &outline) {
        None => read_document(&document, limits, &mut report),
        Some(text) => Document::parse(&text, limits, &mut report)
            .and_then(|document| read_document(&document, limits, &mut report)),
    };
    let Some(bsdf) = bsdf else { return Ok(None) };

    let mut metadata = bsdf.metadata().clone();
    if has("rows") {
        // Blocks that nothing read hold in the structure that they came in.
        metadata = metadata.unbound();
    }
    let mended = |band: &str, components: &[Component]| -> Option<Vec<Component>> {
        let in_band = |b: &blocks::OutlineBlock<'_, '_>| match band {
            "" => blocks::is_visible(&b.band),
            _ => b.band.eq_ignore_ascii_case(band),
        };
        let mut list = components.to_vec();
        for c in &mut list {
            if shares.contains(&(band.to_ascii_lowercase(), (c.incident, c.scattered))) {
                *c = remedy::from_shares(c)?;
            }
        }
        let sides = outline.blocks.iter().filter(|b| in_band(b)).filter_map(|b| b.sides);
        remedy::fill(&mut list, &sides.collect::<Vec<_>>());
        if has("exchanged-sides") {
            list = exchanged_reflection(&list);
        }
        if has("reflects-outside") && also.contains(&"reflects-outside") {
            for c in &mut list {
                (c.incident, c.scattered) = (c.incident.opposite(), c.scattered.opposite());
            }
        }
        if has("not-reciprocal") && also.contains(&"not-reciprocal") {
            list = remedy::averaged(&list);
        }
        if has("energy") || has("band-energy") {
            list = remedy::scaled(list);
        }
        Some(list)
    };
    let Some(components) = mended("", bsdf.components()) else { return Ok(None) };
    let mut bands = bsdf.bands().to_vec();
    for band in &mut bands {
        let Some(components) = mended(&band.name, &band.components) else { return Ok(None) };
        band.components = components;
    }
    let bsdf = Bsdf::new(metadata, components, Lambertian::default()).with_bands(bands);
    let mut written = Vec::new();
    let options = WriteOptions { digits: DIGITS, ..WriteOptions::default() };
    write_to(&bsdf, &mut written, &options)?;
    Ok(Some(written))
}
