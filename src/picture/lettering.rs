//! Letters as outlines, from a font inside the program: pictures look the same on every machine.

use tiny_skia::{Path, PathBuilder, Transform};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

const REGULAR: &[u8] = include_bytes!("font/DejaVuSans-subset.ttf");
const BOLD: &[u8] = include_bytes!("font/DejaVuSans-Bold-subset.ttf");

/// The two weights of the font.
pub struct Letters {
    regular: Face<'static>,
    bold: Face<'static>,
}

/// A line of letters, ready to be filled.
pub struct Line {
    /// The outline, base line at zero, starting at zero.
    pub outline: Option<Path>,
    /// Its length.
    pub width: f32,
}

impl Letters {
    /// Reads the font; it is part of the program, so this fails only in a program that was damaged.
    pub fn new() -> Result<Letters, ttf_parser::FaceParsingError> {
        Ok(Letters { regular: Face::parse(REGULAR, 0)?, bold: Face::parse(BOLD, 0)? })
    }

    /// The outline of a text; letters that the font lacks become a question mark.
    pub fn line(&self, text: &str, size: f32, bold: bool) -> Line {
        let face = if bold { &self.bold } else { &self.regular };
        let scale = size / f32::from(face.units_per_em());
        let mut pen = Pen { builder: PathBuilder::new(), scale, x: 0.0 };
        for letter in text.chars() {
            let glyph = face.glyph_index(letter).or_else(|| face.glyph_index('?')).unwrap_or(GlyphId(0));
            // A glyph without an outline is a space.
            let _ = face.outline_glyph(glyph, &mut pen);
            pen.x += f32::from(face.glyph_hor_advance(glyph).unwrap_or(0)) * scale;
        }
        let width = pen.x;
        Line { outline: pen.builder.finish(), width }
    }
}

/// Turns font units (y up) into picture units (y down).
struct Pen {
    builder: PathBuilder,
    scale: f32,
    x: f32,
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + x * self.scale, -y * self.scale)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.builder.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.builder.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.builder.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.builder.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.builder.close();
    }
}

impl Line {
    /// The outline moved to its place.
    pub fn moved(self, x: f32, y: f32) -> Option<Path> {
        self.outline.and_then(|path| path.transform(Transform::from_translate(x, y)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_have_outlines_and_lengths_that_add_up() {
        let letters = Letters::new().unwrap();
        let whole = letters.line("Año α", 20.0, false);
        let parts: f32 = ["Año", " ", "α"].map(|part| letters.line(part, 20.0, false).width).iter().sum();
        assert!(whole.outline.is_some() && (whole.width - parts).abs() < 1e-3);
        assert!(letters.line("Año", 20.0, true).width > letters.line("Año", 20.0, false).width);
    }

    #[test]
    fn a_letter_that_the_font_lacks_is_still_visible() {
        let letters = Letters::new().unwrap();
        let missing = letters.line("漢", 20.0, false);
        assert_eq!(missing.width, letters.line("?", 20.0, false).width);
        assert!(missing.outline.is_some());
        assert!(letters.line("", 20.0, false).outline.is_none());
    }
}
