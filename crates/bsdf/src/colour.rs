//! CIE colour of scattered light: tristimulus values and the two encodings that files use.

use std::ops::{Add, AddAssign, Mul, Sub};

/// CIE 1931 tristimulus values X, Y, Z; Y is photopic.
///
/// Units: those of the quantity coloured (1/sr for a BSDF, none for a reflectance).
/// Layout: three consecutive f64, so that a slice is an array of shape (n, 3).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Xyz {
    /// X.
    pub x: f64,
    /// Y, the photopic value.
    pub y: f64,
    /// Z.
    pub z: f64,
}

/// XYZ → "sharp" RGB, in which Radiance takes the diffuse minimum of coloured data.
/// Source: the library's description §3.4; another basis would move colour between parts.
const XYZ_TO_SHARP: [[f64; 3]; 3] =
    [[1.2694, -0.0988, -0.1706], [-0.8364, 1.8006, 0.0357], [0.0297, -0.0315, 1.0018]];

/// Inverse of [`XYZ_TO_SHARP`] to the four digits of its source.
const SHARP_TO_XYZ: [[f64; 3]; 3] =
    [[0.8156, 0.0472, 0.1372], [0.3791, 0.5769, 0.0440], [-0.0123, 0.0167, 0.9955]];

/// X, Y, Z of D65, the white of sRGB.
const WHITE: [f64; 3] = [0.950_456, 1.0, 1.088_754];

/// XYZ → linear RGB of sRGB's primaries. Source: the inverse of the standard's primaries and white point.
const XYZ_TO_RGB: [[f64; 3]; 3] = [
    [3.240_479, -1.537_15, -0.498_535],
    [-0.969_256, 1.875_991, 0.041_556],
    [0.055_648, -0.204_043, 1.057_311],
];

/// Linear RGB of sRGB's primaries → XYZ. Source: the standard, whose inverse is above.
const RGB_TO_XYZ: [[f64; 3]; 3] = [
    [0.412_453, 0.357_58, 0.180_423],
    [0.212_671, 0.715_16, 0.072_169],
    [0.019_334, 0.119_193, 0.950_227],
];

fn transform(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

impl Xyz {
    /// No light.
    pub const ZERO: Self = Self { x: 0.0, y: 0.0, z: 0.0 };

    /// The three tristimulus values.
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }

    /// Colourless: X = Y = Z (equal energy, chromaticity ⅓, ⅓).
    pub const fn grey(y: f64) -> Self {
        Self { x: y, y, z: y }
    }

    /// From luminance Y and CIE 1976 u′, v′: X = Y 9u′/4v′, Z = Y (12 − 3u′ − 20v′)/4v′.
    ///
    /// v′ ≤ 0 is no colour: the result is grey.
    pub fn from_yuv(y: f64, u: f64, v: f64) -> Self {
        if v > 0.0 {
            let s = y / (4.0 * v);
            Self::new(9.0 * u * s, y, (12.0 - 3.0 * u - 20.0 * v) * s)
        } else {
            Self::grey(y)
        }
    }

    /// CIE 1976 u′ = 4X/(X + 15Y + 3Z), v′ = 9Y/(X + 15Y + 3Z); (4/19, 9/19) for black.
    pub fn uv(self) -> (f64, f64) {
        let sum = self.x + 15.0 * self.y + 3.0 * self.z;
        if sum > 0.0 { (4.0 * self.x / sum, 9.0 * self.y / sum) } else { (4.0 / 19.0, 9.0 / 19.0) }
    }

    /// CIE 1931 chromaticity x, y; (⅓, ⅓) for black.
    pub fn chromaticity(self) -> (f64, f64) {
        let sum = self.x + self.y + self.z;
        if sum > 0.0 { (self.x / sum, self.y / sum) } else { (1.0 / 3.0, 1.0 / 3.0) }
    }

    /// Linear RGB of sRGB's primaries (IEC 61966-2-1): grey, X = Y = Z, has R = G = B.
    pub fn to_linear_rgb(self) -> [f64; 3] {
        transform(&XYZ_TO_RGB, [self.x * WHITE[0], self.y * WHITE[1], self.z * WHITE[2]])
    }

    /// From linear RGB of sRGB's primaries: white has X = Y = Z.
    pub fn from_linear_rgb(rgb: [f64; 3]) -> Self {
        let [x, y, z] = transform(&RGB_TO_XYZ, rgb);
        Self::new(x / WHITE[0], y / WHITE[1], z / WHITE[2])
    }

    /// "Sharp" RGB, the basis in which the minimum of several colours is taken.
    pub fn to_sharp_rgb(self) -> [f64; 3] {
        transform(&XYZ_TO_SHARP, [self.x, self.y, self.z])
    }

    /// From "sharp" RGB. Accuracy: inverse of [`Xyz::to_sharp_rgb`] to 3e-4 relative.
    pub fn from_sharp_rgb(rgb: [f64; 3]) -> Self {
        let [x, y, z] = transform(&SHARP_TO_XYZ, rgb);
        Self { x, y, z }
    }
}

impl Add for Xyz {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl AddAssign for Xyz {
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Sub for Xyz {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

impl Mul<f64> for Xyz {
    type Output = Self;
    fn mul(self, s: f64) -> Self {
        Self::new(self.x * s, self.y * s, self.z * s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uv_and_back() {
        let c = Xyz::new(0.3, 0.2, 0.1);
        let (u, v) = c.uv();
        let d = Xyz::from_yuv(c.y, u, v);
        assert!((c.x - d.x).abs() < 1e-15 && (c.z - d.z).abs() < 1e-15, "{d:?}");
        // CIE: equal energy has u′ = 4/19, v′ = 9/19.
        assert_eq!(Xyz::grey(1.0).uv(), (4.0 / 19.0, 9.0 / 19.0));
    }

    #[test]
    fn sharp_and_back() {
        let c = Xyz::new(0.3, 0.2, 0.1);
        let d = Xyz::from_sharp_rgb(c.to_sharp_rgb());
        for (a, b) in [(c.x, d.x), (c.y, d.y), (c.z, d.z)] {
            assert!((a - b).abs() < 3e-4 * a, "{a} {b}");
        }
    }
}
