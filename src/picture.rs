//! Pictures of runs: one [`Sketch`] of shapes with roles, written as SVG (for reports, light or dark) or as PNG.

mod lettering;
mod map_image;
mod map_view;
mod poster;
mod raster;
mod sketch;
mod svg;

pub use map_image::MapImage;
pub use map_view::{MapView, SIGNS, Sign};
pub use poster::{poster, scale_bar};
pub use raster::{Raster, RasterError};
pub use sketch::{Anchor, Role, Shape, Sketch, Style};
pub use svg::{SVG_STYLE, escape, role_rules, svg};
