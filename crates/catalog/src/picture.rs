//! Pictures of materials: a lit sphere.

use std::f64::consts::PI;

use bsdfkit::{Bsdf, Components, DVec3, Error, Result, SpecularPeak, Xyz};

/// Of what is drawn: pictures that were kept of another version are drawn anew.
pub(crate) const VERSION: u32 = 3;

/// Of a pixel at the edge this many squared places tell how much of it is covered.
const SUPER: usize = 4;

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
/// Peaks of no width show the two lights as the disks that they are, and what is around. Exposure is the same for all
/// materials: a white diffuser is nearly white.
/// Cost: 6 values and one total for each pixel.
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
    for (((sum, total), point), view) in light.iter_mut().zip(&around).zip(&points).zip(&views) {
        let tint = if sum.y > 1e-6 { *sum * (1.0 / sum.y) } else { Xyz::grey(1.0) };
        *sum += tint * (AROUND * total);
        // Of light from all around the total has the peaks already.
        for peak in bsdf.specular_peaks(*view, Components::ALL) {
            *sum += disks(point, &peak);
        }
    }
    encode(size, &points, &light)
}

/// What a peak of no width lets see of the two lights: disks of [`WIDTH`], as bright as gives their illuminance.
fn disks(point: &Point, peak: &SpecularPeak) -> Xyz {
    let solid_angle = PI * WIDTH * WIDTH;
    let seen = |&(towards, strength): &(DVec3, f64)| {
        let within = point.local(towards.normalize()).dot(peak.wo) > WIDTH.cos();
        if within { PI * strength / solid_angle } else { 0.0 }
    };
    peak.coefficient * [KEY, BACK].iter().map(seen).sum::<f64>()
}

/// The part of a pixel that the sphere covers.
struct Point {
    pixel: usize,
    /// In its middle.
    normal: DVec3,
    /// Of `SUPER²` places.
    covered: usize,
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
    let fine = (size * SUPER) as f64;
    let at = |pixel: usize, k: usize| ((pixel * SUPER + k) as f64 + 0.5) / fine * 2.0 - 1.0;
    let point = |pixel: usize| {
        let places = (0..SUPER * SUPER)
            .map(|k| (at(pixel % size, k % SUPER), -at(pixel / size, k / SUPER)))
            .filter(|(x, y)| x * x + y * y < 1.0 - 1e-4);
        let (x, y, covered) = places.fold((0.0, 0.0, 0), |(x, y, n), p| (x + p.0, y + p.1, n + 1));
        let (x, y) = (x / covered as f64, y / covered as f64);
        let normal = || DVec3::new(x, y, (1.0 - x * x - y * y).sqrt());
        (covered > 0).then(|| Point { pixel, normal: normal(), covered })
    };
    (0..size * size).filter_map(point).collect()
}

fn encode(size: usize, points: &[Point], light: &[Xyz]) -> Result<Vec<u8>> {
    let mut bytes = vec![0; 4 * size * size];
    for (point, light) in points.iter().zip(light) {
        let [r, g, b] = shown(*light).map(srgb);
        let alpha = (255 * point.covered / (SUPER * SUPER)) as u8;
        bytes[4 * point.pixel..][..4].copy_from_slice(&[r, g, b, alpha]);
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
    fn a_mirror_shows_the_light_as_a_disk() {
        use bsdfkit::specular::{Curve, Law};
        use bsdfkit::{Side, Specular};
        let mirror = |share| {
            let sides = (Side::Front, Side::Front);
            Specular::new(sides, Law::OPPOSITE, Curve::constant(Xyz::grey(share)).unwrap())
        };
        let dark = Bsdf::new(Metadata::default(), Vec::new(), Lambertian::default());
        let bsdf = dark.with_specular(vec![mirror(0.9)]);
        let size = 64;
        let pixels = pixels(&bsdf, size);
        // Where the normal is halfway between the eye and the light.
        let half = (KEY.0.normalize() + DVec3::Z).normalize();
        let at = |v: f64| ((v + 1.0) / 2.0 * size as f64) as usize;
        let highlight = pixels[at(-half.y) * size + at(half.x)];
        // All around is seen everywhere: 1 − exp(−1.5 · 0.25 · 0.9).
        let around = srgb(1.0 - (-1.5f64 * AROUND * 0.9).exp());
        assert!(highlight[1] > 250, "{highlight:?}");
        assert!(pixels[32 * size + 20][1].abs_diff(around) <= 1, "{:?}", pixels[32 * size + 20]);
        let bright = pixels.iter().filter(|p| p[1] > 250).count();
        assert!((1..40).contains(&bright), "{bright}");
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
