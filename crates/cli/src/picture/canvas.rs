//! A picture in memory: disks, captions, a colour bar, PNG.

use std::io::Write;
use std::path::Path;

use bsdfkit::{Error, Result};

use crate::picture::font::Line;
use crate::picture::raster::Raster;

/// Colours are linear light, so that averaging pixels is averaging light.
pub(crate) type Colour = [f32; 3];

/// Pixels of the picture are averages of this many squared: smooth edges.
pub(crate) const SUPER: usize = 2;

/// Behind everything.
const BACKGROUND: Colour = [0.006, 0.006, 0.008];
/// A direction without a value.
const UNKNOWN: Colour = [0.016, 0.016, 0.02];
/// Rims and rings.
const LINE: Colour = [0.25, 0.25, 0.27];
/// Captions.
pub(crate) const TEXT: Colour = [0.7, 0.7, 0.72];
/// Radius of the ring round a direction.
const MARK: f64 = 5.0 * SUPER as f64;
/// Height of a line of type, in pixels.
pub(crate) const CAPTION: f32 = 18.0;
/// Where that is too wide, and beside scales.
pub(crate) const SMALL: f32 = 14.0;
/// Captions of lesser weight.
pub(crate) const FAINT: Colour = [0.36, 0.36, 0.38];

/// Values to colours: logarithmic between `low` and `high`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Scale {
    /// Where a value lies, 0 to 1.
    fn position(&self, value: f64) -> f64 {
        ((value.max(f64::MIN_POSITIVE) / self.low).ln() / (self.high / self.low).ln())
            .clamp(0.0, 1.0)
    }

    fn colour(&self, value: f64) -> Colour {
        if value.is_nan() { UNKNOWN } else { heat(self.position(value)) }
    }
}

/// From dark violet through red and orange to pale yellow, in even steps of perceived lightness.
///
/// Source: a path through Oklab with lightness linear in `t`.
fn heat(t: f64) -> Colour {
    let lightness = 0.10 + 0.86 * t;
    let chroma = 0.02 + 0.165 * (std::f64::consts::PI * t).sin().max(0.0).powf(0.8);
    let (sin, cos) = (280.0 + 185.0 * t).to_radians().sin_cos();
    let (a, b) = (chroma * cos, chroma * sin);
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548 * b).powi(3);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701 * s,
    ]
    .map(|c| c.clamp(0.0, 1.0) as f32)
}

/// A picture; sizes and places are in its final pixels.
pub(crate) struct Canvas {
    width: usize,
    height: usize,
    /// `SUPER` times as many pixels along each side.
    pixels: Vec<Colour>,
}

impl Canvas {
    /// An empty picture.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![BACKGROUND; width * height * SUPER * SUPER] }
    }

    fn mix(&mut self, x: usize, y: usize, colour: Colour, share: f64) {
        let pixel = &mut self.pixels[y * self.width * SUPER + x];
        for (have, want) in pixel.iter_mut().zip(colour) {
            *have += (want - *have) * share as f32;
        }
    }

    /// A disk of directions, its square's upper left corner at (left, top); `raster` has `SUPER`
    /// pixels to one of the picture.
    pub(crate) fn disk(&mut self, raster: &Raster, scale: &Scale, left: usize, top: usize) {
        let size = raster.size();
        let radius = size as f64 / 2.0;
        // Past the horizon by a pixel: the rim covers what has no value there.
        let reach = radius - 1.0;
        for y in 0..size {
            for x in 0..size {
                let (dx, dy) = (x as f64 + 0.5 - radius, y as f64 + 0.5 - radius);
                let r = dx.hypot(dy);
                let cover = |edge: f64| (edge - r + 0.5).clamp(0.0, 1.0);
                let (px, py) = (left * SUPER + x, top * SUPER + y);
                self.mix(px, py, scale.colour(raster.at(x, y)), cover(reach));
                let ring = |at: f64, width: f64| (width - (r - at).abs() + 0.5).clamp(0.0, 1.0);
                self.mix(px, py, LINE, ring(reach, 0.8));
                for degrees in [30.0f64, 60.0] {
                    let at = degrees.to_radians().sin() * radius;
                    self.mix(px, py, LINE, 0.16 * ring(at, 0.4));
                }
            }
        }
    }

    /// A small ring round a direction of a disk of `size` at (left, top): (x, y) of the vector.
    pub(crate) fn mark(&mut self, at: (f64, f64), size: usize, left: usize, top: usize) {
        self.around(at, size, left, top, |canvas, px, py, r| {
            let ring = (1.2 - (r - MARK).abs() + 0.5).clamp(0.0, 1.0);
            canvas.mix(px, py, TEXT, ring);
        });
    }

    /// The same ring, filled with the colour of a value.
    pub(crate) fn spot(
        &mut self,
        at: (f64, f64),
        (size, left, top): (usize, usize, usize),
        value: f64,
        scale: &Scale,
    ) {
        self.around(at, size, left, top, |canvas, px, py, r| {
            canvas.mix(px, py, scale.colour(value), (MARK - r + 0.5).clamp(0.0, 1.0));
        });
        self.mark(at, size, left, top);
    }

    /// Calls `draw` with every pixel about a direction of a disk, and its distance.
    fn around(
        &mut self,
        (x, y): (f64, f64),
        size: usize,
        left: usize,
        top: usize,
        mut draw: impl FnMut(&mut Self, usize, usize, f64),
    ) {
        let radius = (SUPER * size) as f64 / 2.0;
        let centre =
            ((SUPER * left) as f64 + radius * (1.0 + x), (SUPER * top) as f64 + radius * (1.0 - y));
        let span = |c: f64, most: usize| {
            ((c - MARK - 2.0).max(0.0) as usize)..(((c + MARK + 2.0).max(0.0) as usize).min(most))
        };
        for py in span(centre.1, self.height * SUPER) {
            for px in span(centre.0, self.width * SUPER) {
                let r = (px as f64 + 0.5 - centre.0).hypot(py as f64 + 0.5 - centre.1);
                draw(self, px, py, r);
            }
        }
    }

    /// A line of text centred on `middle`, `size` pixels high.
    pub(crate) fn text(
        &mut self,
        text: &str,
        middle: usize,
        top: usize,
        size: f32,
        colour: Colour,
    ) {
        let line = Line::new(text, size * SUPER as f32);
        let left = (middle * SUPER) as i32 - (0.5 * line.width) as i32;
        line.draw(|x, y, cover| {
            let (x, y) = (left + x, (top * SUPER) as i32 + y);
            let inside = |at: i32, most: usize| (0..(most * SUPER) as i32).contains(&at);
            if inside(x, self.width) && inside(y, self.height) {
                self.mix(x as usize, y as usize, colour, f64::from(cover));
            }
        });
    }

    /// The colours of a scale from left to right, with a number under each decade.
    pub(crate) fn bar(
        &mut self,
        scale: &Scale,
        left: usize,
        top: usize,
        width: usize,
        height: usize,
    ) {
        for y in top * SUPER..(top + height) * SUPER {
            for x in 0..width * SUPER {
                let t = (x as f64 + 0.5) / (width * SUPER) as f64;
                self.mix(left * SUPER + x, y, heat(t), 1.0);
            }
        }
        let first = scale.low.log10().ceil() as i32;
        for decade in first..=scale.high.log10().floor() as i32 {
            let value = 10f64.powi(decade);
            let at = left + (scale.position(value) * width as f64) as usize;
            for y in (top + height) * SUPER..(top + height + 4) * SUPER {
                for x in at * SUPER..(at + 1) * SUPER {
                    self.mix(x, y, FAINT, 1.0);
                }
            }
            self.text(&value.to_string(), at, top + height + 7, SMALL, FAINT);
        }
    }

    /// Writes a PNG: into a temporary file beside it, then renamed.
    ///
    /// Errors: io.
    pub(crate) fn save(&self, path: &Path) -> Result<()> {
        let io = |e: std::io::Error| Error::io(path.display(), &e);
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        let written = encoder.write_header().and_then(|mut w| w.write_image_data(&self.bytes()));
        written.map_err(|e| io(std::io::Error::other(e)))?;
        bsdfkit::replace_file(path, |out| {
            out.write_all(&bytes).map_err(|e| Error::io("writing", &e))
        })
    }

    /// Averages of `SUPER`² pixels in sRGB.
    fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(3 * self.width * self.height);
        for y in 0..self.height {
            for x in 0..self.width {
                let parts = (0..SUPER * SUPER).map(|k| {
                    let (px, py) = (x * SUPER + k % SUPER, y * SUPER + k / SUPER);
                    self.pixels[py * self.width * SUPER + px]
                });
                let sum =
                    parts.fold([0.0; 3], |s: Colour, c| [s[0] + c[0], s[1] + c[1], s[2] + c[2]]);
                bytes.extend(sum.map(|c| srgb(c / (SUPER * SUPER) as f32)));
            }
        }
        bytes
    }
}

/// The larger of two sizes of type that leaves a line within `width` pixels.
pub(crate) fn type_size(text: &str, width: usize) -> f32 {
    if Line::new(text, CAPTION).width <= width as f32 { CAPTION } else { SMALL }
}

/// Linear light → the byte that shows it. [IEC 61966-2-1]
fn srgb(c: f32) -> u8 {
    let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brighter_values_have_brighter_colours() {
        let scale = Scale { low: 0.01, high: 10.0 };
        let light = |v: f64| {
            let [r, g, b] = scale.colour(v);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let mut last = 0.0;
        for k in 0..=100 {
            let now = light(0.01 * 10f64.powf(0.03 * f64::from(k)));
            assert!(now >= last, "{k}: {now} after {last}");
            last = now;
        }
        assert_eq!(light(0.0), light(0.005));
        assert_eq!(light(10.0), light(1e9));
    }
}
