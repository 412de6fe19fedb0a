//! Pictures of materials: a lit sphere.

use std::f64::consts::PI;

use bsdfkit::{Bsdf, Components, DVec3, Error, Result, Xyz};

/// Pixels are averages of this many squared.
const SUPER: usize = 2;

/// Where light comes from and how strong it is: a white diffuser that faces it has that luminance.
const KEY: (DVec3, f64) = (DVec3::new(-0.48, 0.62, 0.62), 0.85);
/// Light from behind, for what lets light through.
const BACK: (DVec3, f64) = (DVec3::new(0.42, 0.50, -0.76), 0.85);
/// Light from all around.
const AROUND: f64 = 0.25;
/// Half the width of the two lights, radians: highlights of mirrors are not points.
const WIDTH: f64 = 0.05;

/// X, Y, Z of equal energy (grey data have X = Y = Z) → linear light of sRGB: scaled to D65, then the inverse of the
/// standard's primaries and white point. [IEC 61966-2-1]
const WHITE: [f64; 3] = [0.950_456, 1.0, 1.088_754];
const XYZ_TO_RGB: [[f64; 3]; 3] = [
    [3.240_479, -1.537_15, -0.498_535],
    [-0.969_256, 1.875_991, 0.041_556],
    [0.055_648, -0.204_043, 1.057_311],
];

/// A sphere of `size` pixels as PNG, transparent around it: lit from the upper left before it, from the upper right behind
/// it and a little from all around, in orthographic view. The front is outside, +Y up, +X round the vertical axis. What
/// lets light through is seen as if the far half of the sphere were not there.
///
/// Exposure is the same for all materials: a white diffuser is nearly white.
/// Cost: 6 values and one total for each of 4 size² directions.
///
/// Errors: argument: a size of 0 or more than 2048; format, for a damaged compiled file.
pub fn sphere(bsdf: &Bsdf, size: usize) -> Result<Vec<u8>> {
    if !(1..=2048).contains(&size) {
        return Err(Error::argument(format!("picture: expected 1 to 2048 pixels, found {size}")));
    }
    let points = points(size);
    let mut light = vec![Xyz::ZERO; points.len()];
    let views: Vec<DVec3> = points.iter().map(|p| p.local(DVec3::Z)).collect();
    let mut values = vec![Xyz::ZERO; points.len()];
    for (towards, strength) in [KEY, BACK] {
        for k in 0..3 {
            let (sin, cos) = (2.0 * PI * f64::from(k) / 3.0).sin_cos();
            let towards = (towards.normalize() + WIDTH * DVec3::new(cos, sin, 0.0)).normalize();
            let lit: Vec<DVec3> = points.iter().map(|p| p.local(towards)).collect();
            bsdf.eval_xyz_many(&lit, &views, &mut values)?;
            for ((sum, value), wi) in light.iter_mut().zip(&values).zip(&lit) {
                *sum += *value * (PI * strength * wi.z.abs() / 3.0);
            }
        }
    }
    // Reciprocal: what the viewer sees of light from all around is what would be scattered of light from the viewer.
    let mut around = vec![0.0; points.len()];
    bsdf.directional_hemispherical_many(&views, Components::ALL, &mut around)?;
    for (sum, total) in light.iter_mut().zip(&around) {
        let tint = if sum.y > 1e-6 { *sum * (1.0 / sum.y) } else { Xyz::grey(1.0) };
        *sum += tint * (AROUND * total);
    }
    encode(size, &points, &light)
}

/// A point of the sphere's visible half.
struct Point {
    pixel: usize,
    normal: DVec3,
}

impl Point {
    /// A direction in the frame of the surface.
    fn local(&self, w: DVec3) -> DVec3 {
        let n = self.normal;
        let right = DVec3::Y.cross(n);
        let right = if right.length() > 1e-9 { right.normalize() } else { DVec3::X };
        DVec3::new(w.dot(right), w.dot(n.cross(right)), w.dot(n))
    }
}

fn points(size: usize) -> Vec<Point> {
    let fine = size * SUPER;
    let at = |k: usize| (k as f64 + 0.5) / fine as f64 * 2.0 - 1.0;
    let point = |k: usize| {
        let (x, y) = (at(k % fine), -at(k / fine));
        let z2 = 1.0 - x * x - y * y;
        let pixel = (k / fine / SUPER) * size + k % fine / SUPER;
        (z2 > 1e-4).then(|| Point { pixel, normal: DVec3::new(x, y, z2.sqrt()) })
    };
    (0..fine * fine).filter_map(point).collect()
}

fn encode(size: usize, points: &[Point], light: &[Xyz]) -> Result<Vec<u8>> {
    let mut sums = vec![([0.0; 3], 0u32); size * size];
    for (point, light) in points.iter().zip(light) {
        let (sum, count) = &mut sums[point.pixel];
        *count += 1;
        for (sum, c) in sum.iter_mut().zip(shown(*light)) {
            *sum += c;
        }
    }
    let mut bytes = Vec::with_capacity(4 * size * size);
    for (sum, count) in sums {
        let mean = sum.map(|c| c / f64::from(count.max(1)));
        bytes.extend(mean.map(srgb));
        bytes.push((255 * count as usize / (SUPER * SUPER)) as u8);
    }
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, size as u32, size as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    let written = encoder.write_header().and_then(|mut w| w.write_image_data(&bytes));
    written.map_err(|e| Error::io("picture", &std::io::Error::other(e)))?;
    Ok(png)
}

/// Linear RGB, 0 to 1, however bright: luminances go to 1 as film does.
fn shown(light: Xyz) -> [f64; 3] {
    if !light.y.is_finite() || light.y <= 0.0 {
        return [0.0; 3];
    }
    let xyz = [light.x * WHITE[0], light.y * WHITE[1], light.z * WHITE[2]];
    let scale = (1.0 - (-1.5 * light.y).exp()) / light.y;
    XYZ_TO_RGB.map(|row| {
        let c = row.iter().zip(xyz).map(|(a, b)| a * b).sum::<f64>() * scale;
        if c.is_finite() { c.clamp(0.0, 1.0) } else { 0.0 }
    })
}

/// Linear light → the byte that shows it.
fn srgb(c: f64) -> u8 {
    let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use bsdfkit::{Lambertian, Metadata};

    use super::*;

    fn pixels(bsdf: &Bsdf, size: usize) -> Vec<[u8; 4]> {
        let png = sphere(bsdf, size).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        bytes.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect()
    }

    #[test]
    fn a_white_sphere_is_bright_towards_the_light_and_grey() {
        let parts = Lambertian { reflection_front: Xyz::grey(1.0), ..Lambertian::default() };
        let bsdf = Bsdf::new(Metadata::default(), Vec::new(), parts);
        let size = 32;
        let pixels = pixels(&bsdf, size);
        let at = |x: usize, y: usize| pixels[y * size + x];
        assert_eq!((at(0, 0)[3], at(16, 16)[3]), (0, 255));
        let ([r, g, b, _], dark) = (at(9, 7), at(24, 24));
        assert!(r > 220 && r.abs_diff(g) <= 1 && g.abs_diff(b) <= 1, "{r} {g} {b}");
        assert!(dark[0] < 180, "{dark:?}");
        // Luminance where the key light is along the normal: 1 − exp(−1.5 · (0.85 + 0.25)).
        let expected = srgb(1.0 - (-1.5f64 * 1.1).exp());
        let brightest = at(8, 6)[1];
        assert!(brightest.abs_diff(expected) <= 1, "{brightest} {expected}");
    }

    #[test]
    fn light_comes_through_from_behind() {
        let parts = Lambertian { transmission_back: Xyz::grey(0.8), ..Lambertian::default() };
        let bsdf = Bsdf::new(Metadata::default(), Vec::new(), parts);
        let pixels = pixels(&bsdf, 32);
        let (left, right) = (pixels[24 * 32 + 6], pixels[16 * 32 + 26]);
        assert!(left[1] > 60 && right[1] < left[1], "{left:?} {right:?}");
        assert!(sphere(&bsdf, 0).is_err());
    }
}
