//! Type for captions: DejaVu Sans, its Latin and Greek letters. `type/LICENSE` says under which terms.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};

/// `pyftsubset DejaVuSans.ttf` of DejaVu 2.37.
static FONT: LazyLock<FontRef<'static>> = LazyLock::new(|| {
    FontRef::try_from_slice(include_bytes!("type/DejaVuSans-Latin.ttf")).expect("a font")
});

/// A line of text laid out from the left, its baseline at the ascent of the font.
pub(crate) struct Line {
    glyphs: Vec<Glyph>,
    /// How far it goes, in pixels.
    pub(crate) width: f32,
}

impl Line {
    /// `size` is the height of the line in pixels. Not kerned; a letter that the font lacks shows as an empty box.
    pub(crate) fn new(text: &str, size: f32) -> Self {
        let font = FONT.as_scaled(PxScale::from(size));
        let mut glyphs: Vec<Glyph> = Vec::new();
        let mut x = 0.0;
        for letter in text.chars() {
            let id = font.glyph_id(letter);
            glyphs.push(id.with_scale_and_position(size, point(x, font.ascent())));
            x += font.h_advance(id);
        }
        Self { glyphs, width: x }
    }

    /// Calls `draw` with every pixel, and the share of it that is covered.
    pub(crate) fn draw(&self, mut draw: impl FnMut(i32, i32, f32)) {
        for glyph in &self.glyphs {
            let Some(outline) = FONT.outline_glyph(glyph.clone()) else { continue };
            let corner = outline.px_bounds().min;
            outline.draw(|x, y, cover| {
                draw(corner.x as i32 + x as i32, corner.y as i32 + y as i32, cover);
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ink(text: &str) -> f32 {
        let mut sum = 0.0;
        Line::new(text, 40.0).draw(|_, _, cover| sum += cover);
        sum
    }

    #[test]
    fn letters_have_ink_and_lines_their_width() {
        for letter in ('!'..='~').chain("°θφäé−".chars()) {
            assert!(ink(&letter.to_string()) > 5.0, "{letter}");
        }
        assert_eq!(ink(" "), 0.0);
        let width = |text: &str| Line::new(text, 40.0).width;
        assert!(width("iii") < width("mmm"));
        assert!((width("AV") - width("A") - width("V")).abs() < 1e-3);
    }
}
