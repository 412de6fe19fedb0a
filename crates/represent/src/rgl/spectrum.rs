//! What a table holds of a colour: linear RGB, or a spectrum.

use bsdfkit::Xyz;

/// The channels of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
    /// Linear RGB of sRGB's primaries: for RGB renderers.
    Rgb,
    /// Wavelengths: for spectral renderers.
    Spectral,
}

/// Wavelengths of grey data, nm: what is linear between two is the same everywhere.
const GREY: [f32; 2] = [360.0, 830.0];

/// First of [`PRIMARIES`] and the step between them, nm.
const FIRST: f32 = 380.0;
const STEP: f32 = 20.0;

/// The smoothest spectra (least Σ of squared steps of 5 nm) that under D65 have the colours of sRGB's primaries; they add
/// up to 1. The plugin for Mitsuba takes the same.
const PRIMARIES: [[f64; 3]; 21] = [
    [0.0941, -0.1757, 1.0816],
    [0.0940, -0.1753, 1.0813],
    [0.0917, -0.1676, 1.0760],
    [0.0723, -0.1032, 1.0309],
    [0.0145, 0.0987, 0.8868],
    [-0.0695, 0.4237, 0.6458],
    [-0.1376, 0.7628, 0.3749],
    [-0.1435, 1.0051, 0.1384],
    [-0.0420, 1.0540, -0.0120],
    [0.1642, 0.8970, -0.0612],
    [0.4214, 0.6134, -0.0348],
    [0.6541, 0.3245, 0.0214],
    [0.8066, 0.1261, 0.0674],
    [0.8777, 0.0316, 0.0907],
    [0.9025, -0.0016, 0.0991],
    [0.9093, -0.0108, 0.1015],
    [0.9109, -0.0129, 0.1020],
    [0.9113, -0.0135, 0.1022],
    [0.9114, -0.0136, 0.1022],
    [0.9114, -0.0136, 0.1022],
    [0.9114, -0.0136, 0.1022],
];

impl Channels {
    /// Wavelengths in nm; none of RGB.
    pub(super) fn wavelengths(self, coloured: bool) -> Vec<f32> {
        match self {
            Self::Rgb => Vec::new(),
            Self::Spectral if coloured => {
                (0..PRIMARIES.len()).map(|k| FIRST + STEP * k as f32).collect()
            }
            Self::Spectral => GREY.to_vec(),
        }
    }

    /// One value a channel of a colour, none below 0.
    pub(super) fn values(self, colour: Xyz, coloured: bool) -> Vec<f32> {
        let cut = |v: f64| v.max(0.0) as f32;
        if !coloured {
            let count = if self == Self::Rgb { 3 } else { GREY.len() };
            return vec![cut(colour.y); count];
        }
        let sum = |row: &[f64; 3], v: [f64; 3]| row[0] * v[0] + row[1] * v[1] + row[2] * v[2];
        let rgb = colour.to_linear_rgb();
        match self {
            Self::Rgb => rgb.into_iter().map(cut).collect(),
            Self::Spectral => PRIMARIES.iter().map(|row| cut(sum(row, rgb))).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_stays_grey() {
        for channels in [Channels::Rgb, Channels::Spectral] {
            for coloured in [false, true] {
                let values = channels.values(Xyz::grey(0.25), coloured);
                assert!(values.iter().all(|v| (v - 0.25).abs() < 2e-4), "{values:?}");
                if channels == Channels::Spectral {
                    assert_eq!(values.len(), channels.wavelengths(coloured).len());
                }
            }
        }
    }

    #[test]
    fn colours_come_back() {
        for colour in [Xyz::new(0.3, 0.28, 0.2), Xyz::grey(0.7)] {
            let rgb = Channels::Rgb.values(colour, true);
            let back = Xyz::from_linear_rgb([rgb[0], rgb[1], rgb[2]].map(f64::from));
            let off = [back.x - colour.x, back.y - colour.y, back.z - colour.z];
            assert!(off.iter().all(|d| d.abs() < 2e-5), "{back:?}");
        }
    }

    #[test]
    fn luminance_is_that_of_the_rgb() {
        let rgb = Channels::Rgb.values(Xyz::new(0.3, 0.28, 0.2), true);
        let y = 0.212_671 * rgb[0] + 0.715_16 * rgb[1] + 0.072_169 * rgb[2];
        assert!((y - 0.28).abs() < 1e-4, "{y}");
    }
}
