//! Where the pixels of a depth picture look.

use rumbo_core::messages::Intrinsics;

/// Directions of the columns and rows of a camera: the pixel `(column, row)` of depth Z is the point
/// `(Z, Z * left[column], Z * up[row])`, x ahead, y left, z up.
#[derive(Debug, Clone, PartialEq)]
pub struct Rays {
    left: Vec<f64>,
    up: Vec<f64>,
    pub(super) left_f32: Vec<f32>,
    pub(super) up_f32: Vec<f32>,
}

/// How the columns and rows of the camera with evenly spaced angles are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Counting {
    /// From 0: the picture is symmetric around its axis.
    #[default]
    FromZero,
    /// As printed by Valverde Moreno (2015), equations (4.1) and (4.2): columns and rows count from 1 in formulas that are
    /// right for counts from 0, so that everything lies one pixel to the right and one up.
    OneOff,
}

/// Why there are no rays.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RaysError {
    /// No pixels, or more than a picture may have.
    #[error("a picture of {columns} columns and {rows} rows, expected 1 to {most} of each", most = Rays::MOST)]
    Size {
        /// Columns of the picture.
        columns: usize,
        /// Rows of the picture.
        rows: usize,
    },
    /// A focal length that is not above zero, or a center that is no number.
    #[error(
        "focal lengths of {focal_px:?} pixels around {center_px:?}, expected finite numbers, lengths above 0"
    )]
    Camera {
        /// Focal lengths, pixels.
        focal_px: [f64; 2],
        /// Where the axis meets the picture, pixels.
        center_px: [f64; 2],
    },
    /// An angle that no flat picture has.
    #[error("half angles of view of {half_angles_rad:?} rad, expected more than 0 and less than 1.57")]
    View {
        /// From the axis to the picture's edges, radians.
        half_angles_rad: [f64; 2],
    },
}

/// The camera of a picture whose edges lie at these angles from its axis (half angles of view: horizontal, vertical), with
/// evenly spaced tangents: `f = (W / 2) / tan a`, the axis in the middle.
pub fn pinhole_of_view(columns: u32, rows: u32, half_angles_rad: [f64; 2]) -> Intrinsics {
    let size = [columns, rows].map(f64::from);
    Intrinsics {
        width: columns,
        height: rows,
        focal_px: [0, 1].map(|k| size[k] / 2.0 / half_angles_rad[k].tan()),
        center_px: size.map(|n| (n - 1.0) / 2.0),
    }
}

impl Rays {
    /// Most columns and most rows of a picture.
    pub const MOST: usize = 16_384;

    /// Of a calibrated camera without distortion.
    pub fn pinhole(camera: &Intrinsics) -> Result<Rays, RaysError> {
        let Intrinsics { width, height, focal_px, center_px } = *camera;
        let (columns, rows) = (width as usize, height as usize);
        check_size(columns, rows)?;
        let is_sound = focal_px.iter().all(|f| *f > 0.0 && (1.0 / f).is_finite() && f.is_finite())
            && center_px.iter().all(|c| c.is_finite());
        if !is_sound {
            return Err(RaysError::Camera { focal_px, center_px });
        }
        let tangents = |n: usize, axis: usize| {
            (0..n).map(|k| (center_px[axis] - k as f64) / focal_px[axis]).collect::<Vec<f64>>()
        };
        Ok(Rays::of_tangents(tangents(columns, 0), tangents(rows, 1)))
    }

    /// Of a camera whose pixels are evenly spaced in *angle*: Valverde Moreno (2015), equations (4.1) to (4.5). No flat
    /// picture is like that; near half of the half width the angles are wrong by up to a degree.
    pub fn linear_angle(
        columns: usize,
        rows: usize,
        half_angles_rad: [f64; 2],
        counting: Counting,
    ) -> Result<Rays, RaysError> {
        check_size(columns, rows)?;
        if !half_angles_rad.iter().all(|a| *a > 0.0 && *a < std::f64::consts::FRAC_PI_2) {
            return Err(RaysError::View { half_angles_rad });
        }
        let off = if counting == Counting::OneOff { 1.0 } else { 0.0 };
        // Distance from the middle of the picture in half sizes, times the half angle.
        let tangent = |pixels: f64, n: usize, axis: usize| {
            let half = n as f64 / 2.0;
            (pixels / half * half_angles_rad[axis]).tan()
        };
        let (half_columns, half_rows) = (columns as f64 / 2.0, rows as f64 / 2.0);
        let left = |u: usize| tangent(half_columns - (u as f64 + off) - 0.5, columns, 0);
        // The source's rows count from the bottom.
        let up = |row: usize| tangent((rows - 1 - row) as f64 + off - half_rows + 0.5, rows, 1);
        Ok(Rays::of_tangents((0..columns).map(left).collect(), (0..rows).map(up).collect()))
    }

    fn of_tangents(left: Vec<f64>, up: Vec<f64>) -> Rays {
        let single = |tangents: &[f64]| tangents.iter().map(|t| *t as f32).collect();
        Rays { left_f32: single(&left), up_f32: single(&up), left, up }
    }

    /// Columns of the picture.
    pub fn n_columns(&self) -> usize {
        self.left.len()
    }

    /// Rows of the picture.
    pub fn n_rows(&self) -> usize {
        self.up.len()
    }

    /// Pixels of the picture.
    pub fn n_pixels(&self) -> usize {
        self.left.len() * self.up.len()
    }

    /// Tangent of the angle to the left of the axis, of each column.
    pub fn left(&self) -> &[f64] {
        &self.left
    }

    /// Tangent of the angle above the axis, of each row from the top.
    pub fn up(&self) -> &[f64] {
        &self.up
    }

    /// Bearing of a column, radians, left of the axis positive; none where the picture has no such column.
    pub fn bearing_rad(&self, column: usize) -> Option<f64> {
        self.left.get(column).map(|tangent| tangent.atan())
    }

    /// The point of a pixel, meters; none where the picture has no such pixel.
    pub fn point(&self, column: usize, row: usize, depth_m: f64) -> Option<[f64; 3]> {
        let (left, up) = (self.left.get(column)?, self.up.get(row)?);
        Some([depth_m, depth_m * left, depth_m * up])
    }
}

fn check_size(columns: usize, rows: usize) -> Result<(), RaysError> {
    let is_sound = |n: usize| (1..=Rays::MOST).contains(&n);
    if is_sound(columns) && is_sound(rows) { Ok(()) } else { Err(RaysError::Size { columns, rows }) }
}
