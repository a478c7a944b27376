//! A sketch as pixels.

use super::lettering::Letters;
use super::map_image::MapImage;
use super::sketch::{Anchor, Role, Shape, Sketch};
use image::ImageEncoder as _;
use tiny_skia::{
    Color, FillRule, FilterQuality, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, PixmapPaint,
    PremultipliedColorU8, Stroke, StrokeDash, Transform,
};

/// Why a picture cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum RasterError {
    /// No pixels, or too many.
    #[error("a picture of {width} x {height} pixels cannot be drawn")]
    Size {
        /// From left to right.
        width: u32,
        /// From top to bottom.
        height: u32,
    },
    /// The program is damaged.
    #[error("the built-in font cannot be read: {0}")]
    Font(#[from] ttf_parser::FaceParsingError),
    /// The file format's own trouble.
    #[error(transparent)]
    Encode(#[from] image::ImageError),
}

/// A drawn picture.
pub struct Raster {
    pixels: Pixmap,
    scale: f32,
    letters: Letters,
}

impl Raster {
    /// Draws a sketch on light paper, `scale` pixels for each of its units.
    pub fn draw(sketch: &Sketch, scale: f64) -> Result<Raster, RasterError> {
        let (width, height) = ((sketch.width * scale).ceil() as u32, (sketch.height * scale).ceil() as u32);
        let mut pixels = Pixmap::new(width, height).ok_or(RasterError::Size { width, height })?;
        pixels.fill(Color::WHITE);
        let mut raster = Raster { pixels, scale: scale as f32, letters: Letters::new()? };
        for shape in &sketch.shapes {
            raster.shape(shape);
        }
        Ok(raster)
    }

    /// The picture as a PNG file.
    pub fn png(&self) -> Result<Vec<u8>, RasterError> {
        // The paper is opaque, so premultiplied colors are plain colors.
        let rgb: Vec<u8> = self.pixels.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
        let mut bytes = Vec::new();
        let encoder = image::codecs::png::PngEncoder::new_with_quality(
            &mut bytes,
            image::codecs::png::CompressionType::Best,
            image::codecs::png::FilterType::Adaptive,
        );
        encoder.write_image(
            &rgb,
            self.pixels.width(),
            self.pixels.height(),
            image::ExtendedColorType::Rgb8,
        )?;
        Ok(bytes)
    }

    fn shape(&mut self, shape: &Shape) {
        match shape {
            Shape::Image { image, matrix } => self.image(image, matrix),
            Shape::Chain { role, points, closed } => {
                if let Some(path) = chain(points, *closed) {
                    self.path(*role, &path);
                }
            }
            Shape::Circle { role, center: [x, y], radius } => {
                if let Some(path) = PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32) {
                    self.path(*role, &path);
                }
            }
            Shape::Text { role, at: [x, y], size, anchor, bold, text } => {
                let line = self.letters.line(text, *size as f32, *bold);
                let share = match anchor {
                    Anchor::Start => 0.0,
                    Anchor::Middle => 0.5,
                    Anchor::End => 1.0,
                };
                let left = *x as f32 - share * line.width;
                if let Some(path) = line.moved(left, *y as f32) {
                    self.path(*role, &path);
                }
            }
        }
    }

    fn path(&mut self, role: Role, path: &Path) {
        let style = role.style();
        let transform = Transform::from_scale(self.scale, self.scale);
        if let Some((light, _, opacity)) = style.fill {
            let paint = paint(light, opacity as f32);
            self.pixels.fill_path(path, &paint, FillRule::Winding, transform, None);
        }
        if let Some((light, _)) = style.stroke {
            let stroke = Stroke {
                width: style.width as f32,
                line_cap: if style.dash.is_some() { LineCap::Butt } else { LineCap::Round },
                line_join: LineJoin::Round,
                dash: style.dash.and_then(|(dash, gap)| StrokeDash::new(vec![dash as f32, gap as f32], 0.0)),
                ..Stroke::default()
            };
            self.pixels.stroke_path(path, &paint(light, 1.0), &stroke, transform, None);
        }
    }

    fn image(&mut self, image: &MapImage, [a, b, c, d, e, f]: &[f64; 6]) {
        let Some(mut source) = Pixmap::new(image.width, image.height) else { return };
        for (pixel, gray) in source.pixels_mut().iter_mut().zip(image.gray.iter()) {
            // An opaque color is its own premultiplied form, so there always is one.
            *pixel = PremultipliedColorU8::from_rgba(*gray, *gray, *gray, 255).unwrap_or(*pixel);
        }
        let matrix = [a, b, c, d, e, f].map(|v| *v as f32 * self.scale);
        let transform = Transform::from_row(matrix[0], matrix[1], matrix[2], matrix[3], matrix[4], matrix[5]);
        let enlarged = matrix[0].hypot(matrix[1]) >= 1.0;
        let quality = if enlarged { FilterQuality::Nearest } else { FilterQuality::Bilinear };
        let paint = PixmapPaint { quality, ..PixmapPaint::default() };
        self.pixels.draw_pixmap(0, 0, source.as_ref(), &paint, transform, None);
    }
}

fn chain(points: &[[f64; 2]], closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (idx, [x, y]) in points.iter().enumerate() {
        let (x, y) = (*x as f32, *y as f32);
        if idx == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
    }
    if closed {
        builder.close();
    }
    builder.finish()
}

fn paint(rgb: u32, opacity: f32) -> Paint<'static> {
    let [_, red, green, blue] = rgb.to_be_bytes();
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, (opacity * 255.0).round() as u8);
    paint.anti_alias = true;
    paint
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(raster: &Raster, x: u32, y: u32) -> [u8; 3] {
        let pixel = raster.pixels.pixel(x, y).unwrap();
        [pixel.red(), pixel.green(), pixel.blue()]
    }

    #[test]
    fn shapes_and_letters_leave_their_color_where_they_are() {
        let mut sketch = Sketch::sheet(100.0, 50.0);
        sketch.chain(Role::Truth, vec![[0.0, 10.0], [50.0, 10.0]]);
        sketch.text(Role::Text, [60.0, 40.0], 30.0, Anchor::Start, "I");
        let raster = Raster::draw(&sketch, 2.0).unwrap();
        assert_eq!(at(&raster, 40, 20), [0x00, 0x72, 0xb2]);
        assert_eq!(at(&raster, 150, 20), [255, 255, 255]);
        let dark = (120..140).filter(|x| at(&raster, *x, 60)[0] < 100).count();
        assert!((2..10).contains(&dark), "{dark}");
    }

    #[test]
    fn a_map_is_drawn_with_its_top_row_on_top() {
        let image = MapImage { width: 1, height: 2, pixel_m: 1.0, origin: [0.0; 3], gray: [0, 255].into() };
        let mut sketch = Sketch::sheet(20.0, 20.0);
        let matrix = [10.0, 0.0, 0.0, 10.0, 0.0, 0.0];
        sketch.shapes.push(Shape::Image { image, matrix });
        let raster = Raster::draw(&sketch, 1.0).unwrap();
        assert_eq!((at(&raster, 5, 5)[0], at(&raster, 5, 15)[0]), (0, 255));
    }

    #[test]
    fn an_empty_picture_is_refused() {
        assert!(matches!(Raster::draw(&Sketch::default(), 1.0), Err(RasterError::Size { .. })));
    }
}
