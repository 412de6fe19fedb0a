//! RGL's tensors: reflection at nodes that crowd where light is.

use std::sync::Arc;

use bsdfkit::Result;

use super::Whole;
use crate::Colorimetry;
use crate::DenseFile;
use crate::block::{Block, FileContent, Remark};
use crate::gather::MOST_INCIDENCES;
use bsdfkit_represent::rgl::material::{Bands, Left, Material};
use bsdfkit_represent::rgl::reflection::Reflection;

/// Reads such a file: f at the nodes of its tables, at each incident direction off the horizon.
///
/// Values of `rgb` become CIE XYZ, those of `spectra` a channel a wavelength. What the file calls invalid is left out, as
/// is what is negative as a whole; single channels below 0 are 0. All is counted and told.
/// Errors: class format, naming tensor, expected and found; class limit.
pub(super) fn read(whole: &Whole<'_>) -> Result<FileContent> {
    let material = Material::from_bytes(whole.bytes).map_err(|m| whole.error(m))?;
    if material.slices() > MOST_INCIDENCES {
        let text = format!(
            "expected at most {MOST_INCIDENCES} incident directions, found {}",
            material.slices()
        );
        return Err(whole.error(text));
    }
    let mut left = Left { inverted: material.mask_is_inverted(), ..Left::default() };
    let mut blocks = Vec::new();
    for (slice, wi) in material.incidences() {
        let points = material.points(slice, wi, &mut left);
        let channels = match &material.bands {
            Bands::Rgb => 3,
            Bands::Wavelengths(all) => all.len(),
        };
        whole.budget.spend_all(points.len() as u64, channels, whole.path)?;
        let mut block = Block::new(wi);
        for point in points {
            block.wo.push(point.wo);
            block.values.extend(point.values);
        }
        blocks.push(block);
    }
    let colorimetry = match &material.bands {
        Bands::Rgb => Colorimetry::Xyz,
        Bands::Wavelengths(all) => {
            Colorimetry::Named(all.iter().map(|nm| format!("{nm}nm")).collect())
        }
    };
    let Left { invalid, negative, outside, cut, below, inverted } = left;
    let told = [
        (below, "nodes along or below the horizon left out"),
        (invalid, "nodes left out that the file calls invalid"),
        (negative, "nodes left out that are negative"),
        (outside, "nodes with R, G or B below 0, colours outside of sRGB's gamut, kept as CIE XYZ"),
        (cut, "X, Y, Z or bands below 0 of other nodes taken as 0"),
    ];
    let told = told.into_iter().filter(|(n, _)| *n > 0);
    let mut remarks: Vec<Remark> =
        told.map(|(n, text)| Remark::of_file(format!("{n} {text}"))).collect();
    if inverted {
        let text = "its mask says 1 for what is invalid: what is below the horizon tells";
        remarks.push(Remark::of_file(text.to_owned()));
    }
    let sample_name = name_in(&material.description);
    Ok(FileContent {
        path: whole.path.to_owned(),
        sample_name,
        colorimetry,
        blocks,
        remarks,
        wavelength: None,
    })
}

/// The first line.
fn name_in(description: &str) -> Option<String> {
    let name = description.lines().next().unwrap_or_default();
    Some(name.trim().to_owned()).filter(|n| !n.is_empty())
}

/// The function of a file, spectra as they are seen in daylight.
///
/// Errors: as [`read`], and for spectra that do not cover the visible.
pub(super) fn dense(whole: &Whole<'_>) -> Result<DenseFile> {
    let material = Material::from_bytes(whole.bytes).map_err(|m| whole.error(m))?;
    let reflection = Reflection::new(material).map_err(|m| whole.error(m))?;
    let name = name_in(reflection.description());
    Ok(DenseFile { name, functions: vec![Arc::new(reflection)] })
}
