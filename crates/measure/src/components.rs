//! Components of a specimen one after the other: what a laboratory measured need not fit into memory.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use bsdfkit::component::name_of_sides;
use bsdfkit::{Error, Result, Side};
use rayon::prelude::*;

use super::Measurement;
use super::block::{Block, Budget, FileContent, Remark, bytes_of_point, too_much};
use super::listing::{Listed, list};
use super::scan::{ReadOptions, by_side, nothing, order, read, sorted};

/// Files that together have no more bytes are read once, and held at once.
const AT_ONCE: u64 = 256 << 20;

/// The side that the light comes from and the one that it is scattered to.
type Sides = (Side, Side);

/// Hears how many files were read, of how many; its error stops the reading.
pub type Heard<'a> = &'a (dyn Fn(usize, usize) -> Result<()> + Sync);

/// The components of a specimen, read when they are asked for.
pub struct Components<'a> {
    heard: Heard<'a>,
    files: Vec<Seen>,
    notes: Vec<String>,
    options: ReadOptions,
    /// Which are still to come, last first.
    left: Vec<Sides>,
    /// Those that were read at once, last first.
    held: Vec<Measurement>,
}

/// A file, and what it was found to hold.
struct Seen {
    file: Listed,
    holds: Vec<Sides>,
}

/// As [`read()`](crate::read), but one component at a time: no more is held than the one that was asked for last, and what its caller keeps.
///
/// Files of more than 256 MB in all are read twice, first to see which sides each has; one with points on both sides once for each.
///
/// Errors: as [`read()`](crate::read); limit, before anything is held, where the points of one component take more than
/// [`ReadOptions::most_bytes`]; those of `heard`, which hears only of files that are read twice.
pub fn components<'a>(
    paths: &[PathBuf],
    options: &ReadOptions,
    heard: Heard<'a>,
) -> Result<Components<'a>> {
    components_beyond(AT_ONCE, paths, options, heard)
}

fn components_beyond<'a>(
    at_once: u64,
    paths: &[PathBuf],
    options: &ReadOptions,
    heard: Heard<'a>,
) -> Result<Components<'a>> {
    let mut notes = Vec::new();
    let listed = list(paths, &mut notes)?;
    let mut all = Components {
        heard,
        files: Vec::new(),
        notes,
        options: options.clone(),
        left: Vec::new(),
        held: Vec::new(),
    };
    let sizes = listed
        .iter()
        .map(|l| Ok(l.path.metadata().map_err(|e| Error::io(l.path.display(), &e))?.len()));
    if sizes.sum::<Result<u64>>()? <= at_once {
        all.held = read(paths, options)?;
        all.held.reverse();
        return Ok(all);
    }
    let mut bytes: BTreeMap<(Side, bool), (Sides, u64)> = BTreeMap::new();
    let (done, total) = (AtomicUsize::new(0), listed.len());
    let look = |file: Listed| {
        // Of each file alone: what others hold is dropped, too.
        let content = file.read(&Budget::new(options.most_bytes))?;
        let found = count(&content, options.reversed);
        heard(1 + done.fetch_add(1, Ordering::Relaxed), total)?;
        Ok((file, content.colorimetry.channels(), found))
    };
    let seen: Vec<_> = listed.into_par_iter().map(look).collect::<Result<_>>()?;
    for (file, channels, found) in seen {
        for (sides, points) in &found {
            bytes.entry(order(*sides)).or_insert((*sides, 0)).1 +=
                points * bytes_of_point(channels);
        }
        all.files.push(Seen { file, holds: found.into_iter().map(|(sides, _)| sides).collect() });
    }
    if bytes.is_empty() {
        return Err(nothing());
    }
    for ((incident, scattered), bytes) in bytes.values() {
        if *bytes > options.most_bytes {
            let place = name_of_sides(*incident, *scattered);
            return Err(too_much(options.most_bytes, Some(*bytes)).context(place));
        }
    }
    all.left = bytes.into_values().map(|(sides, _)| sides).rev().collect();
    Ok(all)
}

/// How many points of which sides the content has.
fn count(content: &FileContent, reversed: bool) -> Vec<(Sides, u64)> {
    let mut found: Vec<(Sides, u64)> = Vec::new();
    for block in &content.blocks {
        for w in block.wo.iter() {
            let sides = sides(block, Side::of(w), reversed);
            match found.iter_mut().find(|(s, _)| *s == sides) {
                Some((_, points)) => *points += 1,
                None => found.push((sides, 1)),
            }
        }
    }
    found
}

/// The sides of a component with points of `block` on side `scattered`, as the specimen lies.
fn sides(block: &Block, scattered: Side, reversed: bool) -> Sides {
    let side = |side: Side| if reversed { side.opposite() } else { side };
    (side(Side::of(block.wi)), side(scattered))
}

impl Components<'_> {
    /// How many are still to come.
    pub fn len(&self) -> usize {
        self.left.len() + self.held.len()
    }

    /// Whether none is.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Reads one again, and keeps nothing of the others.
    fn one(&self, wanted: Sides) -> Result<Measurement> {
        let budget = Budget::new(self.options.most_bytes);
        let having: Vec<&Seen> =
            self.files.iter().filter(|seen| seen.holds.contains(&wanted)).collect();
        let (done, total) = (AtomicUsize::new(0), having.len());
        let part = |seen: &Seen| {
            let mut content = seen.file.read(&budget)?;
            let dropped = only(&mut content, wanted, self.options.reversed);
            budget.give_back(dropped, content.colorimetry.channels());
            (self.heard)(1 + done.fetch_add(1, Ordering::Relaxed), total)?;
            Ok(content)
        };
        let contents = having.into_par_iter().map(part).collect::<Result<_>>()?;
        // Files may have changed since they were looked at.
        sorted(contents, &self.notes, &self.options)?.pop().ok_or_else(nothing)
    }
}

/// Drops the points of other sides; how many.
fn only(content: &mut FileContent, wanted: Sides, reversed: bool) -> u64 {
    let channels = content.colorimetry.channels();
    let mut dropped = 0;
    let mut kept = Vec::new();
    for block in std::mem::take(&mut content.blocks) {
        for (scattered, part) in by_side(block, channels) {
            if sides(&part, scattered, reversed) == wanted {
                kept.push(part);
            } else {
                dropped += part.wo.len() as u64;
            }
        }
    }
    content.blocks = kept;
    if dropped > 0 {
        content.remarks.push(Remark::of_file("points of several components, split".to_owned()));
    }
    dropped
}

impl Iterator for Components<'_> {
    type Item = Result<Measurement>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Some(held) = self.held.pop() {
            return Some(Ok(held));
        }
        self.left.pop().map(|sides| self.one(sides))
    }
}

#[cfg(test)]
mod tests {
    use bsdfkit::ErrorClass;

    use super::*;

    /// `rows` points of an incidence on each of these sides.
    fn mountain(theta_i: f64, thetas: &[f64], rows: usize) -> String {
        let mut text = format!("#intheta {theta_i}\n#inphi 0\n#format: theta phi BSDF\n");
        for k in 0..rows {
            for theta in thetas {
                text += &format!("{theta} {} {}\n", k % 360, 1 + k % 7);
            }
        }
        text
    }

    fn folder(rows: usize) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let files = [
            ("a.txt", mountain(10.0, &[20.0, 160.0], rows)),
            ("b.txt", mountain(30.0, &[40.0], rows)),
            ("c.txt", mountain(170.0, &[150.0], rows)),
        ];
        files
            .iter()
            .for_each(|(name, text)| std::fs::write(folder.path().join(name), text).unwrap());
        folder
    }

    #[test]
    fn one_after_the_other_are_those_that_are_read_at_once() {
        let folder = folder(5000);
        let paths = [folder.path().to_owned()];
        for reversed in [false, true] {
            let options = ReadOptions { incomplete: true, reversed, ..ReadOptions::default() };
            let at_once = read(&paths, &options).unwrap();
            let streamed = components_beyond(0, &paths, &options, &|_, _| Ok(())).unwrap();
            assert_eq!(streamed.len(), 3);
            let streamed: Vec<Measurement> = streamed.collect::<Result<_>>().unwrap();
            for (a, b) in at_once.iter().zip(&streamed) {
                assert_eq!((a.incident, a.scattered), (b.incident, b.scattered));
                assert_eq!(a.incidences.len(), b.incidences.len());
                for (a, b) in a.incidences.iter().zip(&b.incidences) {
                    assert_eq!(
                        (a.wi, &a.wo, &a.values, &a.files),
                        (b.wi, &b.wo, &b.values, &b.files)
                    );
                }
            }
        }
    }

    #[test]
    fn what_does_not_fit_at_once_fits_one_after_the_other() {
        let folder = folder(5000);
        let paths = [folder.path().to_owned()];
        // The largest component has two files of 5000 points of 16 bytes; 5000 of another are dropped once they are read.
        let options =
            |most_bytes| ReadOptions { incomplete: true, most_bytes, ..ReadOptions::default() };
        let within = options(15_000 * 16);
        assert_eq!(read(&paths, &within).unwrap_err().class(), ErrorClass::Limit);
        let streamed = |o: &ReadOptions| {
            components_beyond(0, &paths, o, &|_, _| Ok(()))
                .map(|all| all.filter(Result::is_ok).count())
        };
        assert_eq!(streamed(&within).unwrap(), 3);
        let error = streamed(&options(9_999 * 16)).unwrap_err();
        assert_eq!(error.class(), ErrorClass::Limit);
        let text = error.to_string();
        assert!(text.contains("front reflection") && text.contains("found 0.16 MB"), "{text}");
    }

    #[test]
    fn who_hears_of_files_may_stop_the_reading() {
        let folder = folder(50);
        let paths = [folder.path().to_owned()];
        let options = ReadOptions { incomplete: true, ..ReadOptions::default() };
        let heard = AtomicUsize::new(0);
        let count = |_, total| {
            heard.fetch_add(1, Ordering::Relaxed);
            assert!(total <= 3);
            Ok(())
        };
        assert_eq!(components_beyond(0, &paths, &options, &count).unwrap().count(), 3);
        // Three files, of which one has two components.
        assert_eq!(heard.into_inner(), 3 + 4);
        let stop = |_, _| Err(Error::limit("cancelled"));
        assert!(components_beyond(0, &paths, &options, &stop).is_err());
    }
}
