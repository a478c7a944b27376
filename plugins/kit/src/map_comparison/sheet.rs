//! A map as something that can be asked at points of the common frame.

use rumbo_core::frames::{Point2, Pose2, pose2};

use super::MapComparisonError;
use crate::GridSize;
use crate::distance_field::{LONGEST_SIDE, squared_distance_field};
use crate::map_file::{DEFAULT_MAX_CELLS, MapImage};

/// The most cells of a distance field: those of the largest map, and as many again beside it.
const MOST_CELLS: usize = 2 * DEFAULT_MAX_CELLS as usize;

/// What a map says of a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Opinion {
    Free,
    Occupied,
    Unknown,
}

/// A map where it lies.
pub(super) struct Sheet<'a> {
    image: &'a MapImage,
    map_from_sheet: Pose2,
}

impl<'a> Sheet<'a> {
    pub fn of(image: &'a MapImage) -> Sheet<'a> {
        let [x, y, yaw] = image.origin;
        Sheet { image, map_from_sheet: pose2(x, y, yaw) }
    }

    /// Column and row of a point, with fractions; a cell's center is at a half.
    fn cells_from_map(&self, point: &Point2) -> [f64; 2] {
        let place = self.map_from_sheet.inverse_transform_point(point) / self.image.resolution_m;
        [place.x, place.y]
    }

    /// Center of a cell in the common frame.
    fn center(&self, col: usize, row: usize) -> Point2 {
        self.map_from_sheet * (Point2::new(col as f64 + 0.5, row as f64 + 0.5) * self.image.resolution_m)
    }

    /// Every cell with its center.
    pub fn cells(&self) -> impl Iterator<Item = (Point2, Opinion)> + '_ {
        let width = self.image.width;
        let cells = self.image.cells.iter().enumerate();
        cells.map(move |(idx, percent)| (self.center(idx % width, idx / width), opinion(*percent)))
    }

    /// Centers of the occupied cells.
    pub fn walls(&self) -> Vec<Point2> {
        self.cells().filter(|(_, opinion)| *opinion == Opinion::Occupied).map(|(center, _)| center).collect()
    }

    /// What the map says of a place; unknown outside.
    pub fn opinion_at(&self, point: &Point2) -> Opinion {
        let [col, row] = self.cells_from_map(point).map(f64::floor);
        let is_inside =
            col >= 0.0 && row >= 0.0 && col < self.image.width as f64 && row < self.image.height as f64;
        if !is_inside {
            return Opinion::Unknown;
        }
        opinion(self.image.occupancy(col as usize, row as usize))
    }
}

fn opinion(percent: i8) -> Opinion {
    match percent {
        51.. => Opinion::Occupied,
        // Even odds say nothing.
        ..0 | 50 => Opinion::Unknown,
        0..50 => Opinion::Free,
    }
}

/// The distance to the nearest wall of a map, at every place of that map and of another one.
pub(super) struct WallField<'a> {
    sheet: Sheet<'a>,
    /// Column and row of the sheet at which the field begins.
    start: [f64; 2],
    size: GridSize,
    squared: Vec<u32>,
}

impl<'a> WallField<'a> {
    /// The distances to the walls of `sheet`, also where only `other` lies.
    pub fn over(sheet: &Sheet<'a>, other: &Sheet<'_>) -> Result<WallField<'a>, MapComparisonError> {
        let image = sheet.image;
        let (mut low, mut high) = ([0.0_f64; 2], [image.width as f64, image.height as f64]);
        let [width_m, height_m] =
            [other.image.width, other.image.height].map(|n| n as f64 * other.image.resolution_m);
        for corner in [[0.0, 0.0], [width_m, 0.0], [0.0, height_m], [width_m, height_m]] {
            let corner = sheet.cells_from_map(&(other.map_from_sheet * Point2::from(corner)));
            for ((low, high), at) in low.iter_mut().zip(&mut high).zip(corner) {
                (*low, *high) = (low.min(at.floor()), high.max(at.ceil()));
            }
        }
        let [width, height] = [high[0] - low[0], high[1] - low[1]];
        // Written so that what is not a number is refused as well.
        let fits = width <= LONGEST_SIDE as f64
            && height <= LONGEST_SIDE as f64
            && width * height <= MOST_CELLS as f64;
        if !fits {
            let (most, longest) = (MOST_CELLS, LONGEST_SIDE);
            return Err(MapComparisonError::TooFarApart { width, height, most, longest });
        }
        let size = GridSize::new(width as usize, height as usize);
        let mut marked = vec![0_u8; size.n_cells()];
        let (right, up) = (-low[0] as usize, -low[1] as usize);
        let lines = marked.chunks_exact_mut(size.width).skip(up).zip(image.cells.chunks_exact(image.width));
        for (marks, cells) in lines {
            for (mark, percent) in marks.iter_mut().skip(right).zip(cells) {
                *mark = u8::from(opinion(*percent) == Opinion::Occupied);
            }
        }
        let squared = squared_distance_field(size, &marked);
        Ok(WallField { sheet: Sheet::of(image), start: low, size, squared })
    }

    /// From the center of the cell at a point to that of the nearest wall, meters.
    pub fn distance_m(&self, point: &Point2) -> f64 {
        let [col, row] = self.sheet.cells_from_map(point);
        let [col, row] = [col - self.start[0], row - self.start[1]].map(|at| at.max(0.0) as usize);
        let idx = row.min(self.size.height - 1) * self.size.width + col.min(self.size.width - 1);
        let squared = self.squared.get(idx).copied().unwrap_or(u32::MAX);
        f64::from(squared).sqrt() * self.sheet.image.resolution_m
    }
}
