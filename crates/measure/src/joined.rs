//! Files of one wavelength each as one spectral measurement.

use std::collections::HashMap;

use bsdfkit::{DVec3, Error, Result};
use bsdfkit_sphere::direction::to_degrees;

use super::block::{Block, FileContent, Remark};
use super::{Colorimetry, Directions, MERGE_DEGREES};

/// Points of the shortest wavelength that another one may lack, as a share.
const LACKING: f64 = 0.1;

/// Contents of which each has a wavelength put together, point by point; contents of which none has one as they are.
///
/// Every wavelength must have been measured at the same incident directions and, but for a tenth, at the same scattered
/// ones, within 0.05 degrees: those of the shortest one that all have are kept. A lone wavelength is a measurement
/// of luminance.
///
/// Errors: format for contents with and without a wavelength, with more than one value a point, or of other directions.
pub(super) fn joined(contents: Vec<FileContent>) -> Result<Vec<FileContent>> {
    let Some(one) = contents.iter().find(|c| c.wavelength.is_some()) else { return Ok(contents) };
    let place = one.path.display().to_string();
    let mut bands: Vec<Band> = Vec::new();
    for content in contents {
        let Some(nanometres) = content.wavelength else {
            let message = format!(
                "expected a wavelength as in {place} (\"#lambda 550\" in the file, or 550nm=FILE), found none"
            );
            return Err(Error::format(message).context(content.path.display()));
        };
        if content.colorimetry != Colorimetry::Luminance {
            let found = &content.colorimetry;
            let message = format!("{nanometres} nm: expected one value a point, found {found}");
            return Err(Error::format(message).context(content.path.display()));
        }
        match bands.iter_mut().find(|b| b.nanometres == nanometres) {
            Some(band) => band.add(content),
            None => {
                let mut band = Band { nanometres, scans: Vec::new(), files: Vec::new() };
                band.add(content);
                bands.push(band);
            }
        }
    }
    bands.sort_by(|a, b| a.nanometres.total_cmp(&b.nanometres));
    if let [band] = &mut bands[..] {
        let text = format!("{} nm alone: taken as luminance", band.nanometres);
        band.files[0].remarks.push(Remark::of_file(text));
        let scans = std::mem::take(&mut band.scans);
        let mut files = std::mem::take(&mut band.files);
        for scan in scans {
            files[scan.file].blocks.push(scan.block);
        }
        return Ok(files);
    }
    together(bands)
}

/// One incident direction at one wavelength.
struct Scan {
    block: Block,
    /// Which of the band's files it is from.
    file: usize,
}

/// All that was measured at one wavelength.
struct Band {
    nanometres: f64,
    /// No two of the same incident direction.
    scans: Vec<Scan>,
    /// The files, without their blocks.
    files: Vec<FileContent>,
}

impl Band {
    fn add(&mut self, mut content: FileContent) {
        for mut block in std::mem::take(&mut content.blocks) {
            match self.scans.iter_mut().find(|s| same(s.block.wi, block.wi)) {
                Some(scan) => {
                    scan.block.wo.append(&mut block.wo);
                    scan.block.values.append(&mut block.values);
                }
                None => self.scans.push(Scan { block, file: self.files.len() }),
            }
        }
        self.files.push(content);
    }

    /// The files, for messages.
    fn place(&self) -> String {
        let first = self.files[0].path.display();
        match self.files.len() {
            1 => first.to_string(),
            n => format!("{first} and {} more", n - 1),
        }
    }
}

fn same(a: DVec3, b: DVec3) -> bool {
    a.dot(b) >= MERGE_DEGREES.to_radians().cos()
}

fn together(mut bands: Vec<Band>) -> Result<Vec<FileContent>> {
    let names: Vec<String> = bands.iter().map(|b| format!("{}nm", b.nanometres)).collect();
    let (first, others) = bands.split_at_mut(1);
    let first = &mut first[0];
    let mut files = std::mem::take(&mut first.files);
    let colorimetry = Colorimetry::Named(names);
    for band in &*others {
        if band.scans.len() != first.scans.len() {
            let message = format!(
                "{} nm: expected the {} incident directions of {} nm, found {}",
                band.nanometres,
                first.scans.len(),
                first.nanometres,
                band.scans.len()
            );
            return Err(Error::format(message).context(band.place()));
        }
    }
    let mut dropped = 0;
    for scan in &mut first.scans {
        let (theta, phi) = to_degrees(scan.block.wi);
        let mut of_others = Vec::with_capacity(others.len());
        for band in &*others {
            let about = |what: String| {
                let message = format!(
                    "{} nm, incidence theta {theta:.1} phi {phi:.1}: {what}",
                    band.nanometres
                );
                Error::format(message).context(band.place())
            };
            let Some(other) = band.scans.iter().find(|s| same(s.block.wi, scan.block.wi)) else {
                let expected = format!("expected it as at {} nm, found none", first.nanometres);
                return Err(about(expected));
            };
            let values = matched(&scan.block.wo, &other.block);
            let lacking = values.iter().filter(|v| v.is_none()).count();
            if lacking as f64 > LACKING * values.len() as f64 {
                return Err(about(format!(
                    "expected the scattered directions of {} nm, found {lacking} of {} elsewhere: all wavelengths need the same scan",
                    first.nanometres,
                    values.len()
                )));
            }
            of_others.push(values);
        }
        let mut block = Block::new(scan.block.wi);
        for (k, w) in scan.block.wo.iter().enumerate() {
            let rest: Option<Vec<f32>> = of_others.iter().map(|values| values[k]).collect();
            let Some(rest) = rest else {
                dropped += 1;
                continue;
            };
            block.wo.push(w);
            block.values.push(scan.block.values[k]);
            block.values.extend(rest);
        }
        block.shrink_to_fit();
        files[scan.file].blocks.push(block);
    }
    let text = format!("{} wavelengths put together", others.len() + 1);
    files[0].remarks.push(Remark::of_file(text));
    if dropped > 0 {
        let text = format!("{dropped} points dropped that some wavelengths lack");
        files[0].remarks.push(Remark::of_file(text));
    }
    files[0]
        .remarks
        .extend(others.iter_mut().flat_map(|b| &mut b.files).flat_map(|f| f.remarks.drain(..)));
    for file in &mut files {
        file.colorimetry = colorimetry.clone().spectral(&mut file.blocks)?;
    }
    Ok(files)
}

/// The value of `from` at each of `wo`, where it has one: of the same number, or the nearest.
fn matched(wo: &Directions, from: &Block) -> Vec<Option<f32>> {
    let alike = wo.len() == from.wo.len() && wo.iter().zip(from.wo.iter()).all(|(a, b)| same(a, b));
    if alike {
        return from.values.iter().map(|v| Some(*v)).collect();
    }
    let size = MERGE_DEGREES.to_radians();
    let cell = |w: DVec3| w.to_array().map(|x| (x / size).floor() as i64);
    let mut cells: HashMap<_, Vec<usize>> = HashMap::new();
    for (k, w) in from.wo.iter().enumerate() {
        cells.entry(cell(w)).or_default().push(k);
    }
    let nearest = |w: DVec3| {
        let own = cell(w);
        // The 27 cells about it, in three digits to the base of 3.
        let about = (0..27).filter_map(|n| {
            let step = [n / 9, n / 3 % 3, n % 3].map(|digit: i64| digit - 1);
            cells.get(&[0, 1, 2].map(|k| own[k] + step[k]))
        });
        let near = about.flatten().map(|k| (from.wo.at(*k).distance(w), *k));
        let near = near.filter(|(distance, _)| *distance <= size);
        near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, k)| from.values[k])
    };
    wo.iter().map(nearest).collect()
}
