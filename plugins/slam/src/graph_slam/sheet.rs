//! The map as a grid: drawn key frame by key frame, and drawn anew, a few frames at a time, when they have moved.

use super::atlas::Atlas;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::Pose2;
use rumbo_core::map::{Grid, GridHeader};
use rumbo_kit::GridSize;
use rumbo_kit::occupancy::{BeamEnds, BeamLimits, Evidence, FreeSpace, Mount2, ScanPainter};

/// How the map is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SheetSettings {
    pub resolution_m: f64,
    pub evidence: Evidence,
    pub limits: BeamLimits,
    /// Key frames drawn anew at one update at most.
    pub redrawn_at_once: usize,
}

/// The grid, and at which poses its frames were drawn.
#[derive(Debug)]
pub(super) struct Sheet {
    settings: SheetSettings,
    drawn: Vec<Pose2>,
    n_moves: u64,
    redrawing: Option<Redrawing>,
    painter: ScanPainter,
    ends: BeamEnds,
}

/// A new grid in the making.
#[derive(Debug)]
struct Redrawing {
    grid: Grid,
    drawn: Vec<Pose2>,
}

/// Room around what was seen, so that the grid need not grow with every frame, meters.
const MARGIN_M: f64 = 10.0;
/// Neighboring beams farther apart than this bound no free space, radians.
const WIDEST_WEDGE_RAD: f64 = 0.03;
/// A frame whose drawing has moved by so many cells is drawn anew.
const MOST_OFF_CELLS: f64 = 0.5;
/// How far away what a frame shows may lie when it turns, meters.
const LEVER_M: f64 = 5.0;

impl Sheet {
    pub fn new(settings: SheetSettings) -> Sheet {
        Sheet {
            settings,
            drawn: Vec::new(),
            n_moves: 0,
            redrawing: None,
            painter: ScanPainter::default(),
            ends: BeamEnds::default(),
        }
    }

    /// An empty grid around a place, before anything was seen.
    pub fn empty(&self, place: &Pose2) -> Option<Grid> {
        let at = [place.translation.x, place.translation.y];
        self.grid_of(at, at)
    }

    /// Draws what is new and goes on with what is drawn anew; whether the grid has changed.
    pub fn keep_up(&mut self, atlas: &Atlas, n_moves: u64, layer: &mut Option<Grid>) -> bool {
        let n_frames = atlas.frames.len();
        if n_frames == 0 {
            return false;
        }
        if self.redrawing.is_none() && n_moves != self.n_moves {
            self.n_moves = n_moves;
            if self.is_off(atlas) {
                self.redrawing = self.blank(atlas).map(|grid| Redrawing { grid, drawn: Vec::new() });
            }
        }
        let mut has_changed = false;
        if let Some(mut new) = self.redrawing.take() {
            let end = (new.drawn.len() + self.settings.redrawn_at_once).min(n_frames);
            self.draw(atlas, &mut new.grid, &mut new.drawn, end);
            if new.drawn.len() < n_frames {
                self.redrawing = Some(new);
            } else {
                *layer = Some(new.grid);
                self.drawn = new.drawn;
                has_changed = true;
            }
        }
        if self.drawn.len() < n_frames || layer.is_none() {
            let mut grid = match layer.take() {
                Some(grid) => grid,
                None => match self.blank(atlas) {
                    Some(grid) => grid,
                    None => return has_changed,
                },
            };
            let mut drawn = std::mem::take(&mut self.drawn);
            self.draw(atlas, &mut grid, &mut drawn, n_frames);
            self.drawn = drawn;
            *layer = Some(grid);
            has_changed = true;
        }
        has_changed
    }

    fn is_off(&self, atlas: &Atlas) -> bool {
        let most_m = MOST_OFF_CELLS * self.settings.resolution_m;
        self.drawn.iter().enumerate().any(|(frame, drawn)| {
            let off = drawn.inverse() * atlas.pose(frame);
            off.translation.vector.norm() + LEVER_M * off.rotation.angle().abs() > most_m
        })
    }

    /// An empty grid with room for everything.
    fn blank(&self, atlas: &Atlas) -> Option<Grid> {
        let places = (0..atlas.frames.len()).map(|frame| atlas.pose(frame).translation.vector);
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for place in places {
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
        }
        self.grid_of(low, high)
    }

    fn grid_of(&self, low: [f64; 2], high: [f64; 2]) -> Option<Grid> {
        let (resolution_m, room_m) =
            (self.settings.resolution_m, self.settings.limits.max_range_m + MARGIN_M);
        let first = low.map(|v| ((v - room_m) / resolution_m).floor());
        let n = |axis: usize| ((high[axis] + room_m) / resolution_m - first[axis]).ceil() as u32;
        let (width, height) = (n(0), n(1));
        let header = GridHeader {
            width,
            height,
            resolution_m,
            origin: [first[0] * resolution_m, first[1] * resolution_m, 0.0],
            occupied_above: Grid::OCCUPIED_ABOVE,
            free_below: Grid::FREE_BELOW,
        };
        Grid::new(header, Buffer::zeroed(width as usize * height as usize)).ok()
    }

    fn draw(&mut self, atlas: &Atlas, grid: &mut Grid, drawn: &mut Vec<Pose2>, end: usize) {
        for frame in drawn.len()..end {
            let Some(key) = atlas.frames.get(frame) else { return };
            let map_from_base = atlas.pose(frame);
            if let Some(larger) = self.grown(grid, &map_from_base) {
                *grid = larger;
            }
            let grid_from_base = grid.grid_from_map() * map_from_base;
            let mount = Mount2::new(&grid_from_base, &key.base_from_sensor, self.settings.resolution_m);
            self.ends.place(&key.scan, &mount, &self.settings.limits);
            let size = GridSize::new(grid.width() as usize, grid.height() as usize);
            let free = FreeSpace::Area { widest_wedge_rad: WIDEST_WEDGE_RAD };
            let cells = grid.cells.make_mut();
            self.painter.paint(cells, size, &self.ends, 1.0, free, &self.settings.evidence);
            drawn.push(map_from_base);
        }
    }

    /// The same grid with more room, when a frame comes near its edge.
    fn grown(&self, grid: &Grid, map_from_base: &Pose2) -> Option<Grid> {
        let (header, resolution_m) = (grid.header(), self.settings.resolution_m);
        let low = [header.origin[0], header.origin[1]];
        let high = [
            low[0] + f64::from(header.width) * resolution_m,
            low[1] + f64::from(header.height) * resolution_m,
        ];
        let (reach_m, at) = (self.settings.limits.max_range_m, map_from_base.translation.vector);
        let has_room = (0..2).all(|axis| at[axis] - reach_m >= low[axis] && at[axis] + reach_m <= high[axis]);
        if has_room {
            return None;
        }
        let room_m = reach_m + MARGIN_M;
        // Of the old grid only what holds something: its edge was room already.
        let bounds = |pick: fn(f64, f64) -> f64, old: [f64; 2], inward: f64| {
            [0, 1].map(|axis| pick(old[axis] + inward, at[axis]))
        };
        let mut larger = self.grid_of(bounds(f64::min, low, room_m), bounds(f64::max, high, -room_m))?;
        let shift = |axis: usize| {
            ((header.origin[axis] - larger.header().origin[axis]) / resolution_m).round() as usize
        };
        let (shift_cols, shift_rows, width) = (shift(0), shift(1), larger.width() as usize);
        let cells = larger.cells.make_mut();
        for (row, old) in grid.cells.chunks_exact(header.width as usize).enumerate() {
            let start = (row + shift_rows) * width + shift_cols;
            if let Some(new) = cells.get_mut(start..start + old.len()) {
                new.copy_from_slice(old);
            }
        }
        Some(larger)
    }
}
