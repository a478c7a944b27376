//! Scans into all levels of a map that grows with what is seen.

use super::beam_ends::{BeamEnd, BeamEnds, BeamLimits, Mount2};
use super::evidence::Evidence;
use super::painter::{FreeSpace, ScanPainter};
use super::pyramid::{Grown, Pyramid};
use crate::GridSize;
use rumbo_core::frames::{Pose2, Pose3};
use rumbo_core::map::{GridFault, Map};
use rumbo_core::messages::LaserScan;

/// What scans say, and to which cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapperSettings {
    /// How much one beam says.
    pub evidence: Evidence,
    /// The levels.
    pub pyramid: Pyramid,
    /// What counts as a reading.
    pub limits: BeamLimits,
    /// Which cells become free.
    pub free_space: FreeSpace,
    /// The grid grows when the robot or what it sees lies beside it.
    pub auto_grow: bool,
}

/// What became of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Inserted {
    /// It is in the map.
    Whole,
    /// It is, but for what lies beside a grid that must not grow further.
    Cut,
    /// It says nothing.
    Empty,
    /// The sensor stands beside the map.
    Beside,
}

/// Inserts scans. Keeps its memory, so that a warm scan allocates nothing.
#[derive(Debug, Clone)]
pub struct ScanMapper {
    settings: MapperSettings,
    beams: BeamEnds,
    painter: ScanPainter,
}

impl ScanMapper {
    /// With these settings.
    pub fn new(settings: MapperSettings) -> ScanMapper {
        ScanMapper { settings, beams: BeamEnds::default(), painter: ScanPainter::default() }
    }

    /// The levels.
    pub fn pyramid(&self) -> &Pyramid {
        &self.settings.pyramid
    }

    /// Puts a scan into every level of a map that was laid; says nothing to the map's version.
    ///
    /// # Errors
    /// A grid that cannot be.
    pub fn insert(
        &mut self,
        scan: &LaserScan,
        map_from_base: &Pose2,
        base_from_sensor: &Pose3,
        map: &mut Map,
    ) -> Result<Inserted, GridFault> {
        self.place(scan, map_from_base, base_from_sensor, map);
        if self.beams.ends.iter().all(|end| *end == BeamEnd::Nothing) {
            return Ok(Inserted::Empty);
        }
        let mut is_cut = false;
        if self.settings.auto_grow {
            let (low, high) = self.extent();
            let mut grown = self.settings.pyramid.make_room(map, low, high)?;
            if grown == Grown::TooLarge {
                is_cut = true;
                // The cells that are there are still worth having; only a robot beside them has nothing to say.
                let origin = self.beams.origin.map(f64::from);
                grown = self.settings.pyramid.make_room(map, origin, origin)?;
            }
            if grown == Grown::Grew {
                self.place(scan, map_from_base, base_from_sensor, map);
            }
        }
        let is_on_map = self.paint(map);
        Ok(match (is_on_map, is_cut) {
            (false, _) => Inserted::Beside,
            (true, false) => Inserted::Whole,
            (true, true) => Inserted::Cut,
        })
    }

    fn place(&mut self, scan: &LaserScan, map_from_base: &Pose2, base_from_sensor: &Pose3, map: &Map) {
        let Some(grid) = &map.grid else { return };
        let grid_from_base = grid.grid_from_map() * map_from_base;
        let mount = Mount2::new(&grid_from_base, base_from_sensor, grid.resolution_m());
        self.beams.place(scan, &mount, &self.settings.limits);
    }

    /// Corners of a rectangle around the sensor and what it hit, cells.
    fn extent(&self) -> ([f64; 2], [f64; 2]) {
        let origin = self.beams.origin.map(f64::from);
        let (mut low, mut high) = (origin, origin);
        let ends = self.beams.x.iter().zip(&self.beams.y).zip(&self.beams.ends);
        for ((x, y), _) in ends.filter(|(_, end)| **end == BeamEnd::Hit) {
            for (axis, end) in [*x, *y].into_iter().enumerate() {
                low[axis] = low[axis].min(f64::from(end));
                high[axis] = high[axis].max(f64::from(end));
            }
        }
        (low, high)
    }

    fn paint(&mut self, map: &mut Map) -> bool {
        let MapperSettings { evidence, free_space, .. } = self.settings;
        let mut is_on_map = false;
        for (k, grid) in map.grid.iter_mut().chain(&mut map.coarse_grids).enumerate() {
            let size = GridSize::new(grid.width() as usize, grid.height() as usize);
            let scale = 0.5f32.powi(k as i32);
            let cells = grid.cells.make_mut();
            is_on_map = self.painter.paint(cells, size, &self.beams, scale, free_space, &evidence);
        }
        is_on_map
    }
}
