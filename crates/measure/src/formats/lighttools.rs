//! LightTools' tables: angles about the normal, both sides.

use bsdfkit::Result;

use super::Whole;
use super::words::Words;
use crate::Colorimetry;
use crate::block::{FileContent, Remark};
use crate::gather::Gathered;

/// More wavelengths than a spectrum of ours can have.
const MOST_CHANNELS: usize = 512;

/// One table as the file has it.
struct Table {
    /// Degrees.
    incidence: f64,
    plane: f64,
    back: bool,
    transmitted: bool,
    /// Wavelength in nm, or which of X, Y, Z.
    channel: Channel,
    values: Vec<f32>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Channel {
    Wavelength(f64),
    /// 0 is X.
    Tristimulus(usize),
}

impl Channel {
    fn key(self) -> f64 {
        match self {
            Self::Wavelength(nm) => nm,
            Self::Tristimulus(k) => k as f64,
        }
    }
}

/// Reads such a file.
///
/// Convention: of a file with one plane of incidence, light comes from azimuth 90°, whatever `POI` says; of several, from
/// 90° + `POI`. Radial angles count from the normal of the side that light goes to. Back is the front with z reversed.
/// Source: how libbsdf reads these files; not held against LightTools itself, which is told.
/// Errors: class format, naming line, expected and found; class limit.
pub(super) fn read(whole: &Whole<'_>) -> Result<FileContent> {
    let mut words = Words::of(whole);
    let (mut azimuths, mut radials) = (Vec::new(), Vec::new());
    let (mut mirrored, mut tristimulus) = (false, false);
    loop {
        let Some(word) = words.next()? else {
            return Err(words.error("expected DataBegin, found the end of the file"));
        };
        match word.to_ascii_lowercase().as_str() {
            "symmetry" => {
                let found = words.word("Symmetry")?;
                mirrored = match found.to_ascii_lowercase().as_str() {
                    "planesymmetrical" => true,
                    "asymmetric" | "asymmetrical" => false,
                    _ => {
                        return Err(words.unknown(
                            "Symmetry",
                            "PlaneSymmetrical or Asymmetric",
                            &found,
                        ));
                    }
                };
            }
            "spectralcontent" => {
                let found = words.word("SpectralContent")?;
                tristimulus = match found.to_ascii_lowercase().as_str() {
                    "monochrome" => false,
                    "xyz" => true,
                    _ => return Err(words.unknown("SpectralContent", "Monochrome or XYZ", &found)),
                };
            }
            "scatterazimuth" => azimuths = words.angles("ScatterAzimuth", -360.0, 360.0)?,
            "scatterradial" => radials = words.angles("ScatterRadial", 0.0, 90.0)?,
            "databegin" => break,
            // Other words of the header say nothing about values.
            _ => {}
        }
    }
    if azimuths.is_empty() || radials.is_empty() {
        let text =
            "expected ScatterAzimuth and ScatterRadial before the data, found neither or one";
        return Err(words.error(text));
    }
    let count = words.expect_room(&[azimuths.len(), radials.len()], "DataBegin")?;
    let tables = tables(&mut words, count, tristimulus)?;
    whole.budget.spend_all((tables.len() * count) as u64, 1, whole.path)?;
    let channels = channels(&tables).map_err(|m| whole.error(m))?;
    let mut gathered = Gathered::default();
    let one_plane = tables.iter().all(|t| t.plane == tables[0].plane);
    for group in tables.chunks_exact(channels.len()) {
        let t = &group[0];
        let plane = 90.0 + if one_plane { 0.0 } else { t.plane };
        let from_normal = |theta: f64, back: bool| if back { 180.0 - theta } else { theta };
        let incident = (from_normal(t.incidence, t.back), plane);
        for (a, azimuth) in azimuths.iter().enumerate() {
            for (r, radial) in radials.iter().enumerate() {
                if *radial == 0.0 && a > 0 {
                    continue;
                }
                let theta = from_normal(*radial, t.back != t.transmitted);
                let place = a * radials.len() + r;
                let values: Vec<f32> = group.iter().map(|t| t.values[place]).collect();
                // About the plane of incidence, azimuths 90 and 270.
                let image = (2.0 * plane - azimuth).rem_euclid(360.0);
                let known = azimuths.iter().any(|b| turned(image - b) < 1e-6);
                let images = if mirrored && !known && *radial > 0.0 { 2 } else { 1 };
                for azimuth in [*azimuth, image].into_iter().take(images) {
                    gathered
                        .take(incident, (theta, azimuth), &values)
                        .map_err(|m| whole.error(m))?;
                }
            }
        }
    }
    let mut remarks: Vec<Remark> = words.remark().into_iter().collect();
    remarks.push(Remark::of_file(
        "azimuths as libbsdf takes them: light comes from 90 degrees".to_owned(),
    ));
    let blocks = gathered.finish(&mut remarks);
    let colorimetry = match channels[..] {
        [_] => Colorimetry::Luminance,
        [Channel::Tristimulus(_), ..] => Colorimetry::Xyz,
        _ => Colorimetry::Named(channels.iter().map(|c| format!("{}nm", c.key())).collect()),
    };
    let path = whole.path.to_owned();
    Ok(FileContent { path, sample_name: None, colorimetry, blocks, remarks, wavelength: None })
}

/// How far an angle is from a whole turn.
fn turned(angle: f64) -> f64 {
    let rest = angle.rem_euclid(360.0);
    rest.min(360.0 - rest)
}

/// All tables, those of one incidence together, by channel.
fn tables(words: &mut Words<'_>, count: usize, tristimulus: bool) -> Result<Vec<Table>> {
    let mut tables: Vec<Table> = Vec::new();
    let (mut incidence, mut plane, mut back, mut transmitted) = (None, 0.0, false, None);
    let mut channel = if tristimulus { None } else { Some(Channel::Wavelength(0.0)) };
    loop {
        let Some(word) = words.next()? else {
            return Err(words.error("expected DataEnd, found the end of the file"));
        };
        match word.to_ascii_lowercase().as_str() {
            "aoi" => {
                let angle = words.number("AOI")?;
                if !(0.0..90.0).contains(&angle) {
                    let text = format!("AOI: expected degrees from 0 to below 90, found {angle}");
                    return Err(words.error(text));
                }
                incidence = Some(angle);
            }
            "poi" => {
                plane = words.number("POI")?;
                if plane.abs() > 360.0 {
                    let text = format!("POI: expected degrees from -360 to 360, found {plane}");
                    return Err(words.error(text));
                }
            }
            "side" => {
                let found = words.word("Side")?;
                back = match found.to_ascii_lowercase().as_str() {
                    "front" => false,
                    "back" => true,
                    _ => return Err(words.unknown("Side", "Front or Back", &found)),
                };
            }
            "wavelength" => {
                let nm = words.number("Wavelength")?;
                if !tristimulus {
                    channel = Some(Channel::Wavelength(nm));
                }
            }
            "scattertype" => {
                let found = words.word("ScatterType")?;
                transmitted = match found.to_ascii_lowercase().as_str() {
                    "brdf" => Some(false),
                    "btdf" => Some(true),
                    _ => return Err(words.unknown("ScatterType", "BRDF or BTDF", &found)),
                };
            }
            "tristimulusvalue" => {
                let found = words.word("TristimulusValue")?;
                let known = ["trisx", "trisy", "trisz"];
                let k = known.iter().position(|k| found.eq_ignore_ascii_case(k));
                let k = k.ok_or_else(|| {
                    words.unknown("TristimulusValue", "TrisX, TrisY or TrisZ", &found)
                })?;
                channel = Some(Channel::Tristimulus(k));
            }
            "tis" => {
                words.number("TIS")?;
                let missing = |what| format!("expected {what} before TIS, found none");
                let incidence = incidence.ok_or_else(|| words.error(missing("AOI")))?;
                let channel = channel.ok_or_else(|| words.error(missing("TristimulusValue")))?;
                let transmitted = transmitted.unwrap_or(false);
                let mut values = Vec::with_capacity(count);
                for _ in 0..count {
                    values.push(words.value()?);
                }
                tables.push(Table { incidence, plane, back, transmitted, channel, values });
            }
            "dataend" => break,
            other => return Err(words.unknown("keyword", "one of LightTools' tables", other)),
        }
    }
    if tables.is_empty() {
        return Err(words.error("expected tables before DataEnd, found none"));
    }
    let key = |t: &Table| (t.back, t.transmitted);
    tables.sort_by(|a, b| {
        let angles = a.incidence.total_cmp(&b.incidence).then(a.plane.total_cmp(&b.plane));
        key(a).cmp(&key(b)).then(angles).then(a.channel.key().total_cmp(&b.channel.key()))
    });
    Ok(tables)
}

/// The channels, of which each incidence has all.
fn channels(tables: &[Table]) -> std::result::Result<Vec<Channel>, String> {
    let mut channels: Vec<Channel> = Vec::new();
    for table in tables {
        if !channels.contains(&table.channel) {
            if channels.len() == MOST_CHANNELS {
                return Err(format!("expected at most {MOST_CHANNELS} wavelengths, found more"));
            }
            channels.push(table.channel);
        }
    }
    channels.sort_by(|a, b| a.key().total_cmp(&b.key()));
    for group in tables.chunks(channels.len()) {
        let same = |t: &Table| {
            let first = &group[0];
            let of = |t: &Table| (t.back, t.transmitted, t.incidence, t.plane);
            of(t) == of(first)
        };
        let complete = group.iter().map(|t| t.channel).eq(channels.iter().copied());
        if !complete || !group.iter().all(same) {
            let found: Vec<String> = group.iter().map(|t| t.channel.key().to_string()).collect();
            return Err(format!(
                "AOI {} POI {}: expected {} tables, one a wavelength or one each of X, Y and Z, found {}",
                group[0].incidence,
                group[0].plane,
                channels.len(),
                found.join(", ")
            ));
        }
    }
    match channels[..] {
        [Channel::Tristimulus(_)] | [Channel::Tristimulus(_), _] => {
            Err(format!("expected X, Y and Z, found {} of them", channels.len()))
        }
        _ => Ok(channels),
    }
}
