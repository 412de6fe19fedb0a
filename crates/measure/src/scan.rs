//! From any list of files and folders to at most four components.

use std::fmt;
use std::path::{Path, PathBuf};

use bsdfkit::component::name_of_sides;
use bsdfkit::{DVec3, Error, Result, Side};
use bsdfkit_sphere::direction;
use rayon::prelude::*;

use super::block::{Block, Budget, FileContent, Remark};
use super::joined::joined;
use super::listing::list;
use super::{Incidence, MERGE_DEGREES, Measurement, Symmetry, SymmetryKind};
use super::{detect, fold};

/// How to read.
#[derive(Clone, Debug)]
pub struct ReadOptions {
    /// Given instead of detected; refused where the data contradict it.
    pub symmetry: Option<SymmetryKind>,
    /// Allows incidences that cover less than the symmetry needs (to look at a measurement, not to
    /// fit it); the reason becomes a note.
    pub incomplete: bool,
    /// The specimen was mounted back to front: turn every direction by 180° about the up axis, (x,
    /// y, z) → (−x, y, −z).
    pub reversed: bool,
    /// Bytes that the points held at once may take; one takes 12 bytes and 4 a channel.
    pub most_bytes: u64,
}

impl Default for ReadOptions {
    /// Symmetry detected, complete, as mounted, 2 GB of points: 125 million of one value.
    fn default() -> Self {
        Self { symmetry: None, incomplete: false, reversed: false, most_bytes: 2_000_000_000 }
    }
}

impl ReadOptions {
    /// What a fit takes beside its points, in bytes: 0.15 GB were seen.
    const WORK: u64 = 300_000_000;

    /// So many points that reading and fitting a component stays within `memory` bytes in all: a quarter more than the points take, and 0.3 GB.
    ///
    /// Errors: argument for less than 0.4 GB.
    pub fn within(self, memory: u64) -> Result<Self> {
        match memory.checked_sub(Self::WORK) {
            Some(left) if left >= Self::WORK / 3 => Ok(Self { most_bytes: left / 5 * 4, ..self }),
            _ => {
                let found = memory as f64 * 1e-9;
                Err(Error::argument(format!("memory: expected at least 0.4 GB, found {found:.3}")))
            }
        }
    }
}

/// The same remark about one file or many.
struct Note {
    /// Of the file that has it first.
    place: String,
    text: String,
    files: usize,
}

impl Note {
    /// Counts `remark` about the file at `path` among `notes`.
    fn add(remark: Remark, path: &Path, notes: &mut Vec<Note>) {
        if let Some(same) = notes.iter_mut().find(|n| n.text == remark.text) {
            same.files += 1;
            return;
        }
        let line = remark.line.map(|line| format!(":{line}")).unwrap_or_default();
        notes.push(Note {
            place: format!("{}{line}", path.display()),
            text: remark.text,
            files: 1,
        });
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { place, text, files } = self;
        match files {
            1 => write!(f, "{place}: {text}"),
            2 => write!(f, "{place} and 1 file more: {text}"),
            _ => write!(f, "{place} and {} files more: {text}", files - 1),
        }
    }
}

/// Reads measurement files, and folders of them, into components: front and back, reflection and
/// transmission.
///
/// Files are told apart by content; `550nm=PATH` gives all that is there one wavelength, as a line
/// `#lambda 550` in a file does, and files of one wavelength each become one spectrum. Several files (or rows) of one incident direction are merged; a
/// file with points on both sides is split; incidences are folded into the symmetry's fundamental
/// domain. Front comes before back, reflection before transmission.
///
/// Errors: class io or format naming file, line, expected and found, also where the incidences
/// cover less than the symmetry needs; class argument where nothing was given or the given symmetry
/// contradicts the data; class limit.
///
/// Cost: 10⁷ rows take a few seconds and 0.2 GB. [`components`](crate::components) holds one component at a time.
pub fn read(paths: &[PathBuf], options: &ReadOptions) -> Result<Vec<Measurement>> {
    let mut notes = Vec::new();
    let files = list(paths, &mut notes)?;
    let budget = Budget::new(options.most_bytes);
    let read = files.par_iter().map(|file| file.read(&budget)).collect::<Result<_>>()?;
    sorted(read, &notes, options)
}

/// Components of what files hold, in order; `notes` of the list of files are each one's.
pub(super) fn sorted(
    contents: Vec<FileContent>,
    notes: &[String],
    options: &ReadOptions,
) -> Result<Vec<Measurement>> {
    let contents = joined(contents)?;
    let mut components: Vec<Measurement> = Vec::new();
    let mut remarks: Vec<Vec<Note>> = Vec::new();
    for mut content in contents {
        let about = std::mem::take(&mut content.remarks);
        let path = content.path.clone();
        let Some(first) = sort_in(content, options.reversed, &mut components)? else { continue };
        remarks.resize_with(components.len(), Vec::new);
        about.into_iter().for_each(|remark| Note::add(remark, &path, &mut remarks[first]));
    }
    for (component, remarks) in components.iter_mut().zip(remarks) {
        component.notes.splice(0..0, remarks.iter().map(ToString::to_string));
    }
    components.sort_by_key(|c| order((c.incident, c.scattered)));
    if components.is_empty() {
        return Err(nothing());
    }
    for component in &mut components {
        component.incidences.sort_by_key(|i| milli_degrees(i.wi));
        let place = name_of_sides(component.incident, component.scattered);
        detect::settle(component, options.symmetry, options.incomplete)
            .map_err(|e| e.context(place))?;
        fold::fold(component);
        component.incidences.iter_mut().for_each(Incidence::shrink_to_fit);
        component.incidences.sort_by_key(|i| milli_degrees(i.wi));
        component.notes.splice(0..0, notes.iter().cloned());
    }
    Ok(components)
}

/// Front before back, reflection before transmission.
pub(super) fn order((incident, scattered): (Side, Side)) -> (Side, bool) {
    (incident, incident != scattered)
}

pub(super) fn nothing() -> Error {
    Error::format("expected points off the horizon, found none")
}

fn milli_degrees(wi: DVec3) -> (i64, i64) {
    let (theta, phi) = direction::to_degrees(wi);
    ((theta * 1000.0).round() as i64, (phi * 1000.0).round() as i64)
}

/// `wi` with the rounding of sines and cosines on the axes taken off, so that folding finds it on
/// its mirror plane.
fn snapped(wi: DVec3) -> DVec3 {
    let snap = |x: f64| if x.abs() < 1e-14 { 0.0 } else { x };
    DVec3::new(snap(wi.x), snap(wi.y), wi.z)
}

/// `w` of a specimen mounted back to front: half a turn about the up axis.
fn turned(w: DVec3) -> DVec3 {
    DVec3::new(-w.x, w.y, -w.z)
}

/// Puts the content of one file where it belongs; the first component that got some of it.
fn sort_in(
    content: FileContent,
    reversed: bool,
    components: &mut Vec<Measurement>,
) -> Result<Option<usize>> {
    let FileContent { path, sample_name, colorimetry, blocks, remarks: _, wavelength: _ } = content;
    let mut first = None;
    let mut split = false;
    for mut block in blocks {
        if reversed {
            block.wi = turned(block.wi);
            block.wo.change(turned);
        }
        let incident = Side::of(block.wi);
        let parts = by_side(block, colorimetry.channels());
        split |= parts.len() > 1;
        for (scattered, block) in parts {
            let found =
                components.iter().position(|c| c.incident == incident && c.scattered == scattered);
            let at = found.unwrap_or_else(|| {
                components.push(Measurement {
                    incident,
                    scattered,
                    colorimetry: colorimetry.clone(),
                    symmetry: Symmetry::None,
                    incidences: Vec::new(),
                    sample_name: None,
                    notes: Vec::new(),
                });
                components.len() - 1
            });
            let component = &mut components[at];
            if component.colorimetry != colorimetry {
                let message = format!(
                    "expected {} as in the files before, found {colorimetry}",
                    component.colorimetry
                );
                return Err(Error::format(message).context(path.display()));
            }
            if component.sample_name.is_none() {
                component.sample_name.clone_from(&sample_name);
            }
            first.get_or_insert(at);
            merge_in(component, block, &path);
        }
    }
    if split {
        let note = format!("{}: points on both sides, split", path.display());
        components.iter_mut().for_each(|c| c.notes.push(note.clone()));
    }
    Ok(first)
}

/// The block's points, those on one side apart from those on the other.
pub(super) fn by_side(block: Block, channels: usize) -> Vec<(Side, Block)> {
    let Some(first) = block.wo.first() else { return Vec::new() };
    let side = Side::of(first);
    if block.wo.iter().all(|w| Side::of(w) == side) {
        return vec![(side, block)];
    }
    [Side::Front, Side::Back]
        .map(|side| {
            let mut part = Block::new(block.wi);
            for (w, v) in block.wo.iter().zip(block.values.chunks_exact(channels)) {
                if Side::of(w) == side {
                    part.wo.push(w);
                    part.values.extend_from_slice(v);
                }
            }
            part.shrink_to_fit();
            (side, part)
        })
        .into()
}

/// Adds `block` to the incidence of its direction, or as a new one.
fn merge_in(component: &mut Measurement, block: Block, path: &Path) {
    let near = MERGE_DEGREES.to_radians().cos();
    let Block { wi, mut wo, mut values } = block;
    let wi = snapped(wi);
    let Some(same) = component.incidences.iter_mut().find(|i| i.wi.dot(wi) >= near) else {
        component.incidences.push(Incidence { wi, wo, values, files: vec![path.to_owned()] });
        return;
    };
    let (theta, phi) = direction::to_degrees(same.wi);
    let first = same.files[0].display().to_string();
    component.notes.push(format!(
        "{}: merged with {first}, incidence theta {theta:.2} phi {phi:.2}",
        path.display()
    ));
    same.wo.append(&mut wo);
    same.values.append(&mut values);
    if same.files.last().is_none_or(|f| f != path) {
        same.files.push(path.to_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_leaves_room_for_the_work() {
        let most = |memory| ReadOptions::default().within(memory).map(|o| o.most_bytes);
        // 0.3 GB of work; of the rest four fifths.
        assert_eq!(most(4_000_000_000).unwrap(), 2_960_000_000);
        assert_eq!(most(400_000_000).unwrap(), 80_000_000);
        for too_little in [0, 399_999_999] {
            let text = most(too_little).unwrap_err().to_string();
            assert!(text.contains("expected at least 0.4 GB"), "{text}");
        }
    }
}
