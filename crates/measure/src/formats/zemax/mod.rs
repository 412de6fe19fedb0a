//! Zemax' tables: angles about the specular direction.

use std::sync::Arc;

use bsdfkit::{DVec3, Result, Side};
use bsdfkit_sphere::direction::from_degrees;

use super::Whole;
use super::words::Words;
use crate::Colorimetry;
use crate::DenseFile;
use crate::block::{Block, FileContent, HORIZON_COSINE, Remark};
use crate::gather::MOST_INCIDENCES;

mod function;

/// A file.
///
/// Convention: `AngleOfIncidence` is the polar angle of the specular direction, which light goes on to. About it, radial
/// angles count from it, azimuths counter-clockwise, seen from outside, from the direction of the normal. Turning the
/// specimen by ρ is turning the light by −ρ: it comes from 180° − ρ. Transmitted light is seen in a mirror.
#[derive(Debug)]
struct Zemax {
    transmitted: bool,
    /// Degrees, rising; a last one that is the first again is left out.
    rotations: Vec<f64>,
    incidences: Vec<f64>,
    azimuths: Vec<f64>,
    radials: Vec<f64>,
    /// Azimuths end at 180 and mean both sides of the plane of incidence.
    mirrored: bool,
    /// One (luminance) or three (Y, X, Z), each by rotation, incidence, azimuth, radial angle.
    channels: Vec<Vec<f32>>,
}

/// What a block of values is.
const CONTENTS: [(&str, usize); 4] =
    [("monochrome", 0), ("tristimulusy", 0), ("tristimulusx", 1), ("tristimulusz", 2)];

impl Zemax {
    fn read(whole: &Whole<'_>) -> Result<(Self, Vec<Remark>)> {
        let mut words = Words::of(whole);
        let mut lists: [Vec<f64>; 4] = Default::default();
        let (mut mirrored, mut channels, mut transmitted) = (false, 1, None);
        let mut content = 0;
        let mut values: Vec<Option<Vec<f32>>> = Vec::new();
        while let Some(word) = words.next()? {
            let word = word.to_ascii_lowercase();
            match word.as_str() {
                "source" => {
                    words.word("Source")?;
                }
                "symmetry" => {
                    let symmetry = words.word("Symmetry")?;
                    mirrored = match symmetry.to_ascii_lowercase().as_str() {
                        "planesymmetrical" => true,
                        "asymmetrical" | "asymmetrical4d" => false,
                        _ => {
                            let known = "PlaneSymmetrical, Asymmetrical or Asymmetrical4D";
                            return Err(words.unknown("Symmetry", known, &symmetry));
                        }
                    };
                }
                "spectralcontent" => {
                    let found = words.word("SpectralContent")?;
                    channels = match found.to_ascii_lowercase().as_str() {
                        "monochrome" => 1,
                        "xyz" => 3,
                        _ => {
                            return Err(words.unknown(
                                "SpectralContent",
                                "Monochrome or XYZ",
                                &found,
                            ));
                        }
                    };
                }
                "scattertype" => {
                    let found = words.word("ScatterType")?;
                    transmitted = match found.to_ascii_lowercase().as_str() {
                        "brdf" => Some(false),
                        "btdf" => Some(true),
                        _ => return Err(words.unknown("ScatterType", "BRDF or BTDF", &found)),
                    };
                }
                "samplerotation" => lists[0] = words.angles("SampleRotation", -360.0, 360.0)?,
                "angleofincidence" => lists[1] = words.angles("AngleOfIncidence", 0.0, 89.99)?,
                "scatterazimuth" => lists[2] = words.angles("ScatterAzimuth", -360.0, 360.0)?,
                "scatterradial" => lists[3] = words.angles("ScatterRadial", 0.0, 180.0)?,
                "databegin" => {
                    if let Some(k) = lists.iter().position(Vec::is_empty) {
                        let names = [
                            "SampleRotation",
                            "AngleOfIncidence",
                            "ScatterAzimuth",
                            "ScatterRadial",
                        ];
                        let text = format!("expected {} before the data, found none", names[k]);
                        return Err(words.error(text));
                    }
                    values.resize(channels, None);
                    let known = values.get(content).ok_or_else(|| {
                        words.error("SpectralContent: expected XYZ, found Monochrome")
                    })?;
                    if known.is_some() {
                        return Err(words.error("expected each block once, found one twice"));
                    }
                    values[content] = Some(block(&mut words, &lists)?);
                }
                other => match CONTENTS.iter().find(|(name, _)| *name == other) {
                    Some((_, k)) => content = *k,
                    None => return Err(words.unknown("keyword", "one of Zemax' tables", other)),
                },
            }
        }
        let found = values.iter().flatten().count();
        if found != channels {
            let text = format!("expected {channels} blocks of values, found {found}");
            return Err(words.error(text));
        }
        let channels = values.into_iter().flatten().collect();
        let [rotations, incidences, azimuths, radials] = lists;
        let mut remarks: Vec<Remark> = words.remark().into_iter().collect();
        if transmitted.is_none() {
            let text = "no line ScatterType: taken as reflection".to_owned();
            remarks.push(Remark::of_file(text));
        }
        let transmitted = transmitted.unwrap_or(false);
        let mut zemax =
            Self { transmitted, rotations, incidences, azimuths, radials, mirrored, channels };
        zemax.drop_what_comes_again();
        Ok((zemax, remarks))
    }

    /// Takes off a last rotation and a last azimuth that are the first again, a turn later.
    fn drop_what_comes_again(&mut self) {
        let again =
            |list: &[f64]| list.len() > 1 && (list[list.len() - 1] - list[0] - 360.0).abs() < 1e-6;
        let (azimuths, radials) = (self.azimuths.len(), self.radials.len());
        if again(&self.rotations) {
            self.rotations.pop();
            let count = self.rotations.len() * self.incidences.len() * azimuths * radials;
            self.channels.iter_mut().for_each(|c| c.truncate(count));
        }
        if again(&self.azimuths) {
            self.azimuths.pop();
            for channel in &mut self.channels {
                let tables = channel.chunks_exact(azimuths * radials);
                *channel = tables.flat_map(|t| &t[..(azimuths - 1) * radials]).copied().collect();
            }
        }
    }

    /// The values of all channels at one place.
    fn at(&self, rotation: usize, incidence: usize, azimuth: usize, radial: usize) -> usize {
        let row = (rotation * self.incidences.len() + incidence) * self.azimuths.len() + azimuth;
        row * self.radials.len() + radial
    }

    /// The incident direction of a rotation and an angle.
    fn incident(&self, rotation: usize, incidence: usize) -> DVec3 {
        from_degrees(self.incidences[incidence], 180.0 - self.rotations[rotation])
    }

    fn side(&self) -> Side {
        if self.transmitted { Side::Back } else { Side::Front }
    }
}

/// TIS and values, by rotation, incidence, azimuth and radial angle.
fn block(words: &mut Words<'_>, lists: &[Vec<f64>; 4]) -> Result<Vec<f32>> {
    let [rotations, incidences, azimuths, radials] = lists.each_ref().map(Vec::len);
    if rotations * incidences > MOST_INCIDENCES {
        let text = format!("expected at most {MOST_INCIDENCES} incident directions, found more");
        return Err(words.error(text));
    }
    let count = words.expect_room(&[rotations, incidences, azimuths, radials], "DataBegin")?;
    let mut values = Vec::with_capacity(count);
    for _ in 0..rotations * incidences {
        let word = words.word("TIS")?;
        if !word.eq_ignore_ascii_case("TIS") {
            return Err(words.unknown("values", "TIS before each table", &word));
        }
        words.number("TIS")?;
        for _ in 0..azimuths * radials {
            values.push(words.value()?);
        }
    }
    let end = words.word("DataEnd")?;
    if !end.eq_ignore_ascii_case("DataEnd") {
        return Err(words.unknown("values", "DataEnd after the last", &end));
    }
    Ok(values)
}

/// The specular direction and, across it, those of azimuth 0 and 90.
fn frame(wi: DVec3) -> [DVec3; 3] {
    let specular = DVec3::new(-wi.x, -wi.y, wi.z);
    // Across the plane of incidence; toward the normal is where light comes from, as seen from the specular direction.
    let along = wi.truncate().try_normalize().unwrap_or(bsdfkit_sphere::DVec2::X);
    let across = DVec3::new(along.y, -along.x, 0.0);
    let toward = specular.cross(across);
    [specular, toward, specular.cross(toward)]
}

/// Reads such a file: f at every node of every incidence, those below the horizon left out.
///
/// Errors: class format, naming line, expected and found; class limit.
pub(super) fn read(whole: &Whole<'_>) -> Result<FileContent> {
    let (zemax, mut remarks) = Zemax::read(whole)?;
    let tables = zemax.rotations.len() * zemax.incidences.len();
    let nodes = tables * zemax.azimuths.len() * zemax.radials.len();
    let points = nodes as u64 * if zemax.mirrored { 2 } else { 1 };
    whole.budget.spend_all(points, zemax.channels.len(), whole.path)?;
    // f at X, Y, Z as CIE XYZ has them.
    let order: &[usize] = if zemax.channels.len() == 3 { &[1, 0, 2] } else { &[0] };
    let (mut blocks, mut below) = (Vec::new(), 0_usize);
    for rotation in 0..zemax.rotations.len() {
        for incidence in 0..zemax.incidences.len() {
            // Along the normal turning the specimen is turning what is seen.
            let wi = zemax.incident(rotation, incidence);
            let [specular, toward, left] = match zemax.incidences[incidence] {
                0.0 => frame(from_degrees(1e-9, 180.0 - zemax.rotations[rotation])),
                _ => frame(wi),
            };
            let mut block = Block::new(wi);
            for (a, azimuth) in zemax.azimuths.iter().enumerate() {
                for (r, radial) in zemax.radials.iter().enumerate() {
                    // In the middle all azimuths are one direction.
                    if *radial == 0.0 && a > 0 {
                        continue;
                    }
                    let place = zemax.at(rotation, incidence, a, r);
                    let image = zemax.mirrored && *radial > 0.0 && azimuth.rem_euclid(180.0) > 1e-9;
                    let signs: &[f64] = if image { &[1.0, -1.0] } else { &[1.0] };
                    for sign in signs {
                        let (sin, cos) = radial.to_radians().sin_cos();
                        let (y, x) = azimuth.to_radians().sin_cos();
                        let mut wo = cos * specular + sin * (x * toward + sign * y * left);
                        if wo.z < HORIZON_COSINE {
                            below += 1;
                            continue;
                        }
                        if zemax.transmitted {
                            wo.z = -wo.z;
                        }
                        block.wo.push(wo);
                        block.values.extend(order.iter().map(|c| zemax.channels[*c][place]));
                    }
                }
            }
            blocks.push(block);
        }
    }
    if below > 0 {
        remarks.push(Remark::of_file(format!("{below} nodes along or below the horizon left out")));
    }
    let colorimetry = match zemax.channels.len() {
        3 => Colorimetry::Xyz,
        _ => Colorimetry::Luminance,
    };
    let path = whole.path.to_owned();
    Ok(FileContent { path, sample_name: None, colorimetry, blocks, remarks, wavelength: None })
}

/// The function of a file: linear between its nodes, about the specular direction that there is; past the last radial
/// angle 0, past the last incidence as there.
///
/// Errors: as [`read`].
pub(super) fn dense(whole: &Whole<'_>) -> Result<DenseFile> {
    let (zemax, _) = Zemax::read(whole)?;
    Ok(DenseFile { name: None, functions: vec![Arc::new(zemax)] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_is_about_the_specular_direction() {
        for (theta, phi) in [(30.0, 0.0), (50.0, 140.0), (70.0, 260.0)] {
            let [specular, toward, left] = frame(from_degrees(theta, phi));
            assert!((specular - from_degrees(theta, phi + 180.0)).length() < 1e-12);
            let (sin, cos) = f64::to_radians(theta).sin_cos();
            assert!((cos * specular + sin * toward - DVec3::Z).length() < 1e-12, "normal");
            // Counter-clockwise, seen from outside.
            assert!((specular.cross(toward) - left).length() < 1e-12);
        }
    }
}
