//! What bands are seen as: photopic, coloured, by the sun, one wavelength.

use std::fmt;
use std::str::FromStr;

use super::bands::Bands;
use super::sampled::Sampled;
use super::tables::{CIE_X, CIE_Y, CIE_Z, D65, MELANOPIC, SUN};
use crate::{Error, Result, Xyz};

/// What light falls on the specimen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Illuminant {
    /// Daylight: CIE D65.
    D65,
    /// Incandescent lamps: CIE A.
    A,
    /// Equal energy at all wavelengths.
    E,
}

impl Illuminant {
    const ALL: [(&'static str, Self); 3] = [("d65", Self::D65), ("a", Self::A), ("e", Self::E)];

    /// Relative power.
    fn at(self, nanometres: f64) -> f64 {
        match self {
            Self::D65 => D65.at(nanometres),
            Self::E => 1.0,
            // ISO 11664-2: a Planckian radiator of 2848 K with c₂ = 1.435e-2 m K, normalised at 560 nm.
            Self::A => {
                let planck = |w: f64| (1.435e7 / (2848.0 * w)).exp_m1();
                (560.0 / nanometres).powi(5) * planck(560.0) / planck(nanometres)
            }
        }
    }
}

/// What is made of bands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// Photopic luminance under an illuminant.
    Photopic(Illuminant),
    /// What light that sets the body's clock becomes under an illuminant: CIE S 026's melanopic action spectrum.
    Melanopic(Illuminant),
    /// CIE 1931 X, Y, Z under an illuminant; white has Y = 1 and the illuminant's chromaticity.
    Tristimulus(Illuminant),
    /// The same, adapted to equal energy (Bradford): what is neutral has X = Y = Z, as BSDF files have it.
    Colour(Illuminant),
    /// The same in linear RGB of sRGB's primaries (IEC 61966-2-1), white 1, 1, 1; colours outside of them have negative values. Weights
    /// alone: no table has it.
    Rgb(Illuminant),
    /// The sun's energy from 300 to 2500 nm.
    Solar,
    /// Its part above 780 nm.
    NearInfrared,
    /// One wavelength in nanometres.
    Wavelength(f64),
    /// The mean of all bands.
    Mean,
}

/// Weights of bands: one row for a value, or three for X, Y, Z.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    rows: Vec<Vec<f64>>,
}

impl Weights {
    /// One row a value, one weight a band.
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// What bands of these values are seen as: one value a row.
    pub fn apply<'a>(&'a self, bands: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.rows.iter().map(move |row| row.iter().zip(bands).map(|(w, v)| w * v).sum())
    }
}

/// Least share of what a view weighs that must lie near bands.
const COVERED: f64 = 0.95;

/// Cone responses of the Bradford transform. Source: Lam 1985, as in CIE 160:2004.
const BRADFORD: [[f64; 3]; 3] =
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];
/// Their inverse.
const BRADFORD_BACK: [[f64; 3]; 3] = [
    [0.986_992_9, -0.147_054_3, 0.159_962_7],
    [0.432_305_3, 0.518_360_3, 0.049_291_2],
    [-0.008_528_7, 0.040_042_8, 0.968_486_7],
];

impl View {
    /// Weights of `bands`.
    ///
    /// Errors: argument where less than 95 % of what the view weighs lies between bands, or a step beyond the last.
    /// Accuracy: spectra are taken for linear between bands; bands of 10 nm are within 0.2 ΔE00 of 5 nm.
    pub fn weights(self, bands: &Bands) -> Result<Weights> {
        let rows = match self {
            Self::Photopic(lit) => vec![self.row(bands, 380..=780, |w| CIE_Y.at(w) * lit.at(w))?],
            Self::Melanopic(lit) => {
                vec![self.row(bands, 380..=780, |w| MELANOPIC.at(w) * lit.at(w))?]
            }
            Self::Tristimulus(lit) => self.tristimulus(bands, lit)?,
            Self::Colour(lit) => {
                let rows = self.tristimulus(bands, lit)?;
                let white: Vec<f64> = rows.iter().map(|row| row.iter().sum()).collect();
                let to_equal = adaptation([white[0], white[1], white[2]]);
                let adapted = |m: &[f64; 3]| {
                    let band = |k: usize| (0..3).map(|c| m[c] * rows[c][k]).sum();
                    (0..bands.count()).map(band).collect()
                };
                to_equal.iter().map(adapted).collect()
            }
            Self::Rgb(lit) => {
                let colour = Self::Colour(lit).weights(bands).map_err(|e| e.context(self))?.rows;
                let rgb =
                    |k: usize| Xyz::new(colour[0][k], colour[1][k], colour[2][k]).to_linear_rgb();
                (0..3).map(|c| (0..bands.count()).map(|k| rgb(k)[c]).collect()).collect()
            }
            Self::Solar => vec![self.row(bands, 300..=2500, |w| SUN.at(w))?],
            Self::NearInfrared => vec![self.row(bands, 780..=2500, |w| SUN.at(w))?],
            Self::Wavelength(w) => {
                let [first, last] = [bands.nanometres()[0], bands.nanometres()[bands.count() - 1]];
                if !(first..=last).contains(&w) {
                    return Err(Error::argument(format!(
                        "wavelength: expected {first} to {last} nm, found {w}"
                    )));
                }
                let mut row = vec![0.0; bands.count()];
                bands.shares(w).iter().for_each(|(band, share)| row[*band] += share);
                vec![row]
            }
            Self::Mean => vec![vec![1.0 / bands.count() as f64; bands.count()]],
        };
        Ok(Weights { rows })
    }

    fn tristimulus(self, bands: &Bands, lit: Illuminant) -> Result<Vec<Vec<f64>>> {
        let [mut x, y, mut z] = [&CIE_X, &CIE_Y, &CIE_Z]
            .map(|observer: &Sampled| self.row(bands, 380..=780, |w| observer.at(w) * lit.at(w)));
        // A row sums to 1; against Y, the others as much as white has of them.
        let whole = |observer: &Sampled| -> f64 {
            (380..=780).map(f64::from).map(|w| observer.at(w) * lit.at(w)).sum()
        };
        for (row, observer) in [(&mut x, &CIE_X), (&mut z, &CIE_Z)] {
            let white = whole(observer) / whole(&CIE_Y);
            row.iter_mut().flatten().for_each(|v| *v *= white);
        }
        Ok(vec![x?, y?, z?])
    }

    /// The shares of bands in the mean by `weight`, at every nanometre.
    fn row(
        self,
        bands: &Bands,
        nanometres: std::ops::RangeInclusive<u32>,
        weight: impl Fn(f64) -> f64,
    ) -> Result<Vec<f64>> {
        let mut row = vec![0.0; bands.count()];
        let (mut near, mut all) = (0.0, 0.0);
        for w in nanometres.map(f64::from) {
            let weight = weight(w);
            bands.shares(w).iter().for_each(|(band, share)| row[*band] += share * weight);
            all += weight;
            near += if bands.reach(w) { weight } else { 0.0 };
        }
        if near < COVERED * all {
            return Err(Error::argument(format!(
                "{self}: expected bands near at least {:.0} % of what it weighs, found {:.1} % ({bands})",
                100.0 * COVERED,
                100.0 * near / all
            )));
        }
        row.iter_mut().for_each(|v| *v /= all);
        Ok(row)
    }
}

/// From tristimulus values under `white` to those of the same colour under equal energy.
fn adaptation(white: [f64; 3]) -> [[f64; 3]; 3] {
    let cones = |v: [f64; 3]| BRADFORD.map(|row| (0..3).map(|c| row[c] * v[c]).sum::<f64>());
    let (to, from) = (cones([1.0; 3]), cones(white));
    BRADFORD_BACK.map(|row| {
        [0, 1, 2].map(|c| (0..3).map(|k| row[k] * to[k] / from[k] * BRADFORD[k][c]).sum())
    })
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |lit: &Illuminant| {
            Illuminant::ALL.iter().find(|(_, other)| other == lit).map_or("", |(name, _)| *name)
        };
        match self {
            Self::Photopic(lit) => write!(f, "photopic-{}", name(lit)),
            Self::Melanopic(lit) => write!(f, "melanopic-{}", name(lit)),
            Self::Tristimulus(lit) => write!(f, "xyz-{}", name(lit)),
            Self::Colour(lit) => write!(f, "colour-{}", name(lit)),
            Self::Rgb(lit) => write!(f, "rgb-{}", name(lit)),
            Self::Solar => f.write_str("solar"),
            Self::NearInfrared => f.write_str("nir"),
            Self::Wavelength(w) => write!(f, "{w}nm"),
            Self::Mean => f.write_str("mean"),
        }
    }
}

impl FromStr for View {
    type Err = Error;

    /// `photopic`, `melanopic`, `xyz`, `colour`, `rgb` (each alone, for daylight, or with `-d65`, `-a`, `-e`), `solar`, `nir`, `mean`, or a
    /// wavelength as `550nm`.
    ///
    /// Errors: argument, for any other name.
    fn from_str(text: &str) -> Result<Self> {
        let expected = || {
            Error::argument(format!(
                "view: expected photopic, melanopic, xyz, colour or rgb (with -d65, -a or -e), solar, nir, mean or a wavelength as 550nm, found {text:?}"
            ))
        };
        match text {
            "solar" => return Ok(Self::Solar),
            "nir" => return Ok(Self::NearInfrared),
            "mean" => return Ok(Self::Mean),
            _ => {}
        }
        if let Some(number) = text.strip_suffix("nm") {
            let w: f64 = number.trim().parse().map_err(|_| expected())?;
            return if w.is_finite() { Ok(Self::Wavelength(w)) } else { Err(expected()) };
        }
        let (kind, lit) = text.split_once('-').unwrap_or((text, "d65"));
        let lit = Illuminant::ALL.iter().find(|(name, _)| *name == lit).ok_or_else(expected)?.1;
        match kind {
            "photopic" => Ok(Self::Photopic(lit)),
            "melanopic" => Ok(Self::Melanopic(lit)),
            "xyz" => Ok(Self::Tristimulus(lit)),
            "colour" | "color" => Ok(Self::Colour(lit)),
            "rgb" => Ok(Self::Rgb(lit)),
            _ => Err(expected()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn every(first: u32, last: u32, step: usize) -> Bands {
        Bands::new((first..=last).step_by(step).map(f64::from).collect()).expect("bands")
    }

    #[test]
    fn white_has_the_illuminants_chromaticity_and_neutral_is_neutral_in_files() {
        let bands = every(380, 780, 5);
        for (lit, x, y) in [(Illuminant::D65, 0.3127, 0.3290), (Illuminant::A, 0.4476, 0.4074)] {
            let weights = View::Tristimulus(lit).weights(&bands).expect("covered");
            let ones = vec![1.0; bands.count()];
            let white: Vec<f64> = weights.apply(&ones).collect();
            let sum: f64 = white.iter().sum();
            assert!((white[1] - 1.0).abs() < 1e-12);
            assert!((white[0] / sum - x).abs() < 1e-4 && (white[1] / sum - y).abs() < 1e-4);
            let weights = View::Colour(lit).weights(&bands).expect("covered");
            let rgb = View::Rgb(lit).weights(&bands).expect("covered");
            for v in weights.apply(&ones).chain(rgb.apply(&ones)) {
                assert!((v - 1.0).abs() < 2e-6, "{v}");
            }
        }
    }

    /// CIE S 026's efficacy ratio of illuminant A is .496 of daylight's: melanopic over photopic light, both of white.
    #[test]
    fn lamps_are_half_as_melanopic_as_daylight() {
        let ratio = |lit: Illuminant| {
            let sum = |seen: &Sampled| {
                (380..=780).map(f64::from).map(|w| seen.at(w) * lit.at(w)).sum::<f64>()
            };
            sum(&MELANOPIC) / sum(&CIE_Y)
        };
        let found = ratio(Illuminant::A) / ratio(Illuminant::D65);
        assert!((found - 0.496).abs() < 1e-3, "{found}");
        // What reflects blue alone is brighter for the clock than for the eye.
        let bands = every(380, 780, 5);
        let blue: Vec<f64> =
            bands.nanometres().iter().map(|w| f64::from(u8::from(*w < 500.0))).collect();
        let seen = |view: View| view.weights(&bands).expect("covered").apply(&blue).sum::<f64>();
        let lit = Illuminant::D65;
        assert!(seen(View::Melanopic(lit)) > 4.0 * seen(View::Photopic(lit)));
    }

    #[test]
    fn what_bands_do_not_cover_is_refused_and_ten_nanometres_tell_what_five_do() {
        let visible = every(400, 700, 10);
        let message = View::Solar.weights(&visible).expect_err("sun").to_string();
        assert!(message.contains("solar") && message.contains("400 to 700 nm"), "{message}");
        let spectrum = |w: &f64| 0.4 + 0.3 * (w / 40.0).sin();
        let seen = |bands: &Bands| -> Vec<f64> {
            let values: Vec<f64> = bands.nanometres().iter().map(spectrum).collect();
            let weights = View::Tristimulus(Illuminant::A).weights(bands).expect("covered");
            weights.apply(&values).collect()
        };
        let (coarse, fine) = (seen(&every(380, 780, 10)), seen(&every(380, 780, 1)));
        for (a, b) in coarse.iter().zip(&fine) {
            assert!((a - b).abs() < 2e-3, "{coarse:?} {fine:?}");
        }
    }

    #[test]
    fn names_come_back() {
        for name in [
            "photopic-d65",
            "melanopic-a",
            "xyz-a",
            "colour-e",
            "rgb-d65",
            "solar",
            "nir",
            "mean",
            "550nm",
        ] {
            assert_eq!(name.parse::<View>().expect(name).to_string(), name);
        }
        assert_eq!("xyz".parse::<View>().expect("xyz"), View::Tristimulus(Illuminant::D65));
        assert!("xyz-d50".parse::<View>().is_err() && "NaNnm".parse::<View>().is_err());
    }
}
