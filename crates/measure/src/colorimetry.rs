//! What the values of a point mean.

use std::fmt;

use bsdfkit::Result;
use bsdfkit::spectrum::{Bands, Illuminant, View};

use super::block::Block;

/// What the values of a point mean.
#[derive(Clone, Debug, PartialEq)]
pub enum Colorimetry {
    /// One value: CIE-Y, or not stated.
    Luminance,
    /// Three values: CIE X, Y, Z.
    Xyz,
    /// The guide, then one value a band. The guide steers lobes and plans: photopic in daylight, or the mean of bands that do not cover the
    /// visible.
    Spectral(Bands),
    /// One value a column, named as in the table's header.
    Named(Vec<String>),
}

impl Colorimetry {
    /// Values a point.
    pub fn channels(&self) -> usize {
        match self {
            Colorimetry::Luminance => 1,
            Colorimetry::Xyz => 3,
            Colorimetry::Spectral(bands) => 1 + bands.count(),
            Colorimetry::Named(names) => names.len(),
        }
    }

    /// Which channel stands for luminance: Y of XYZ, the guide of a spectrum, a column named `y`, else the first.
    pub fn luminance_channel(&self) -> usize {
        match self {
            Colorimetry::Luminance | Colorimetry::Spectral(_) => 0,
            Colorimetry::Xyz => 1,
            Colorimetry::Named(names) => {
                names.iter().position(|n| n.eq_ignore_ascii_case("y")).unwrap_or(0)
            }
        }
    }

    /// A spectrum where all names are wavelengths, in any order: the values of `blocks` are sorted, and led by the guide.
    ///
    /// Errors: as [`Sorted::of`].
    pub(super) fn spectral(self, blocks: &mut [Block]) -> Result<Self> {
        let Some(sorted) = Sorted::of(&self)? else { return Ok(self) };
        for block in blocks {
            let mut values = Vec::with_capacity(block.wo.len() * (1 + sorted.order.len()));
            for point in block.values.chunks_exact(sorted.order.len()) {
                sorted.add(point, &mut values);
            }
            block.values = values;
        }
        Ok(sorted.colorimetry())
    }
}

/// Columns of wavelengths, and what makes points of a spectrum of them.
pub(super) struct Sorted {
    bands: Bands,
    /// Columns, that of the shortest wavelength first.
    order: Vec<usize>,
    /// Of bands in the guide.
    weights: Vec<f64>,
}

impl Sorted {
    /// Of columns that are all named after wavelengths, in any order; `None` of others.
    ///
    /// Errors: argument for wavelengths that are no [`Bands`], with both that are the same.
    pub(super) fn of(columns: &Colorimetry) -> Result<Option<Self>> {
        let Colorimetry::Named(names) = columns else { return Ok(None) };
        let Some(found) = names.iter().map(|n| nanometres(n)).collect::<Option<Vec<f64>>>() else {
            return Ok(None);
        };
        let mut order: Vec<usize> = (0..found.len()).collect();
        order.sort_by(|a, b| found[*a].total_cmp(&found[*b]));
        let bands = Bands::new(order.iter().map(|k| found[*k]).collect())?;
        let weights = guide(&bands).weights(&bands)?.rows()[0].clone();
        Ok(Some(Self { bands, order, weights }))
    }

    /// What points are then.
    pub(super) fn colorimetry(&self) -> Colorimetry {
        Colorimetry::Spectral(self.bands.clone())
    }

    /// Adds a point: the guide, then its bands in order.
    pub(super) fn add(&self, columns: &[f32], points: &mut Vec<f32>) {
        let bands = self.order.iter().map(|k| columns[*k]);
        let guide: f64 = bands.clone().zip(&self.weights).map(|(v, w)| f64::from(v) * w).sum();
        points.push(guide as f32);
        points.extend(bands);
    }
}

/// What steers the fit to a spectrum.
fn guide(bands: &Bands) -> View {
    let photopic = View::Photopic(Illuminant::D65);
    if photopic.weights(bands).is_ok() { photopic } else { View::Mean }
}

/// The wavelength that a column is named after: `450nm`, `450`, `f_450`, `bsdf 0.45 um`.
fn nanometres(name: &str) -> Option<f64> {
    let name = name.trim().to_lowercase();
    let first = name.find(|c: char| c.is_ascii_digit())?;
    let (before, number) = name.split_at(first);
    let end = number.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(number.len());
    let (number, unit) = number.split_at(end);
    let word = |text: &str| text.chars().filter(|c| c.is_alphabetic()).collect::<String>();
    let known = ["", "f", "bsdf", "brdf", "btdf", "lambda", "λ", "wl", "w", "nm", "wavelength"];
    if !known.contains(&word(before).as_str()) {
        return None;
    }
    let value: f64 = number.parse().ok()?;
    let scale = match word(unit).as_str() {
        "" | "nm" => 1.0,
        "um" | "µm" | "μm" => 1000.0,
        _ => return None,
    };
    let nanometres = value * scale;
    let [least, most] = Bands::RANGE;
    (least..=most).contains(&nanometres).then_some(nanometres)
}

impl fmt::Display for Colorimetry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Colorimetry::Luminance => f.write_str("luminance"),
            Colorimetry::Xyz => f.write_str("CIE XYZ"),
            Colorimetry::Spectral(bands) => write!(f, "spectrum of {bands}"),
            Colorimetry::Named(names) => write!(f, "channels {}", names.join(", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit::DVec3;

    #[test]
    fn wavelengths_are_known_in_their_spellings() {
        for name in ["450nm", "450", "f_450", "BSDF 450 nm", "0.45um", "lambda=450", "w450"] {
            assert_eq!(nanometres(name), Some(450.0), "{name}");
        }
        for name in ["value", "x", "t3", "450 deg", "channel 450", "5", "90000"] {
            assert_eq!(nanometres(name), None, "{name}");
        }
    }

    #[test]
    fn bands_are_sorted_and_led_by_what_the_eye_sees() {
        let names: Vec<String> = (0..41).rev().map(|k| format!("{}nm", 380 + 10 * k)).collect();
        let mut block = Block::new(DVec3::Z);
        block.wo.push(DVec3::Z);
        block.values = (0..41).rev().map(|k| k as f32).collect();
        let mut blocks = [block];
        let found = Colorimetry::Named(names).spectral(&mut blocks).expect("bands");
        assert_eq!((found.channels(), found.luminance_channel()), (42, 0));
        let values = &blocks[0].values;
        assert!(values[1..].windows(2).all(|v| v[0] + 1.0 == v[1]));
        // Daylight's centre of gravity for the eye, 557 nm, is band 17.7.
        assert!((values[0] - 17.7).abs() < 0.2, "{}", values[0]);
    }

    #[test]
    fn the_same_wavelength_twice_is_refused() {
        let twice = Colorimetry::Named(vec!["450nm".into(), "0.45um".into()]);
        let message = twice.spectral(&mut []).expect_err("twice").to_string();
        assert!(message.contains("found 450 after 450"), "{message}");
    }
}
