//! From any list of files and folders to at most four components.

use std::path::{Path, PathBuf};

use bsdfkit::{DVec3, Error, Result, Side};
use bsdfkit_sphere::direction;
use rayon::prelude::*;

use super::{Colorimetry, Incidence, MERGE_DEGREES, Measurement, Symmetry, SymmetryKind, mountain};

/// How to read.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// Given instead of detected; refused where the data contradict it.
    pub symmetry: Option<SymmetryKind>,
    /// The specimen was mounted back to front: turn every direction by 180° about the up axis, (x, y, z) → (−x, y, −z).
    pub reversed: bool,
}

/// What one file holds.
pub(super) struct FileContent {
    pub(super) path: PathBuf,
    pub(super) sample_name: Option<String>,
    pub(super) colorimetry: Colorimetry,
    pub(super) blocks: Vec<Block>,
    pub(super) notes: Vec<String>,
}

/// One incident direction in one file; its points may lie on both sides.
pub(super) struct Block {
    pub(super) wi: DVec3,
    pub(super) wo: Vec<DVec3>,
    pub(super) values: Vec<f64>,
}

/// Reads measurement files, and folders of them, into components: front and back, reflection and transmission.
///
/// Errors: class io or format naming file, line, expected and found; class argument where nothing was given or the
/// given symmetry contradicts the data.
pub fn read(paths: &[PathBuf], options: &ReadOptions) -> Result<Vec<Measurement>> {
    let mut notes = Vec::new();
    let files = list(paths, &mut notes)?;
    let contents: Vec<FileContent> =
        files.par_iter().map(|p| mountain::read(p)).collect::<Result<_>>()?;
    let mut components: Vec<Measurement> = Vec::new();
    for content in contents {
        sort_in(content, options.reversed, &mut components)?;
    }
    for component in &mut components {
        component.notes.splice(0..0, notes.iter().cloned());
        component.incidences.sort_by(|a, b| key(a.wi).partial_cmp(&key(b.wi)).expect("finite"));
    }
    Ok(components)
}

fn key(wi: DVec3) -> (i64, i64) {
    let (theta, phi) = direction::to_degrees(wi);
    ((theta * 1000.0).round() as i64, (phi * 1000.0).round() as i64)
}

/// The files that `paths` name, folders opened (not their folders), in order of name.
fn list(paths: &[PathBuf], notes: &mut Vec<String>) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in paths {
        let io = |e: std::io::Error| Error::io(path.display(), &e);
        if path.is_dir() {
            let mut inside: Vec<PathBuf> = path
                .read_dir()
                .map_err(io)?
                .map(|e| e.map(|e| e.path()))
                .collect::<std::io::Result<_>>()
                .map_err(io)?;
            inside.sort();
            for p in inside {
                if p.is_file() && p.extension().is_none_or(|e| e != "json") {
                    files.push(p);
                } else {
                    notes.push(format!("{}: skipped", p.display()));
                }
            }
        } else {
            files.push(path.clone());
        }
    }
    if files.is_empty() {
        return Err(Error::argument("expected at least one measurement file, found none"));
    }
    Ok(files)
}

/// Puts the content of one file where it belongs.
fn sort_in(content: FileContent, reversed: bool, components: &mut Vec<Measurement>) -> Result<()> {
    let channels = content.colorimetry.channels();
    for block in content.blocks {
        let turn = |w: DVec3| if reversed { DVec3::new(-w.x, w.y, -w.z) } else { w };
        let wi = turn(block.wi);
        for side in [Side::Front, Side::Back] {
            let mut wo = Vec::new();
            let mut values = Vec::new();
            for (w, v) in block.wo.iter().zip(block.values.chunks_exact(channels)) {
                if Side::of(turn(*w)) == side {
                    wo.push(turn(*w));
                    values.extend_from_slice(v);
                }
            }
            if wo.is_empty() {
                continue;
            }
            let incident = Side::of(wi);
            let at = components.iter().position(|c| c.incident == incident && c.scattered == side);
            let at = at.unwrap_or_else(|| {
                components.push(Measurement {
                    incident,
                    scattered: side,
                    colorimetry: content.colorimetry.clone(),
                    symmetry: Symmetry::None,
                    incidences: Vec::new(),
                    sample_name: content.sample_name.clone(),
                    notes: content.notes.clone(),
                });
                components.len() - 1
            });
            let component = &mut components[at];
            check_channels(component, &content.colorimetry, &content.path)?;
            let merge = (MERGE_DEGREES.to_radians()).cos();
            match component.incidences.iter_mut().find(|i| i.wi.dot(wi) >= merge) {
                Some(i) => {
                    i.wo.extend(wo);
                    i.values.extend(values);
                    i.files.push(content.path.clone());
                }
                None => component.incidences.push(Incidence {
                    wi,
                    wo,
                    values,
                    files: vec![content.path.clone()],
                }),
            }
        }
    }
    Ok(())
}

fn check_channels(component: &Measurement, found: &Colorimetry, path: &Path) -> Result<()> {
    if component.colorimetry == *found {
        return Ok(());
    }
    Err(Error::format(format!(
        "colorimetry: expected {:?} as in the files before, found {found:?}",
        component.colorimetry
    ))
    .context(path.display()))
}
