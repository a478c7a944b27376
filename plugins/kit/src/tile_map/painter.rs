//! One scan into the tiles of all levels.

use super::TileMap;
use super::level::TileLevel;
use super::tile::{TILE_CELLS, Tile, UnitEvidence};
use crate::GridSize;
use crate::occupancy::{BeamEnd, BeamEnds, BeamLimits, Evidence, FreeSpace, Mount2, ScanPainter};
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::LaserScan;

/// Puts scans into maps of tiles. A scan is drawn on a sheet just large enough for it, by the painter of plain grids, and
/// the tiles take over what the sheet shows. Keeps its memory, so that a warm scan allocates only tiles.
#[derive(Debug, Clone)]
pub struct TilePainter {
    limits: BeamLimits,
    free_space: FreeSpace,
    evidence: Evidence,
    beams: BeamEnds,
    painter: ScanPainter,
    sheet: Vec<f32>,
}

/// A scan that reaches farther than this from its sensor is not drawn, finest cells: no device does.
const FARTHEST_CELLS: f32 = 16_384.0;

impl TilePainter {
    /// What counts as a reading, which cells are free, and how much a beam says.
    pub fn new(limits: BeamLimits, free_space: FreeSpace, evidence: Evidence) -> TilePainter {
        TilePainter {
            limits,
            free_space,
            evidence,
            beams: BeamEnds::default(),
            painter: ScanPainter::default(),
            sheet: Vec::new(),
        }
    }

    /// Adds a scan that was seen from here. Tiles that change get the `version`, which nobody else may give. Returns how
    /// many beams ended at something.
    pub fn paint(
        &mut self,
        map: &mut TileMap,
        scan: &LaserScan,
        map_from_base: &Pose2,
        base_from_sensor: &Pose3,
        version: u64,
    ) -> usize {
        let Some(resolution_m) = map.finest().map(TileLevel::resolution_m) else { return 0 };
        let n_levels = map.levels().len() as u32;
        let Some(corner) = self.place(scan, map_from_base, base_from_sensor, resolution_m, n_levels) else {
            return 0;
        };
        let Some(size) = self.extent() else { return 0 };
        for (k, level) in map.levels_mut().iter_mut().enumerate() {
            // Room for the last cell that is cut by the end of the finest sheet.
            let size = GridSize::new((size.width >> k) + 1, (size.height >> k) + 1);
            self.sheet.clear();
            self.sheet.resize(size.n_cells(), 0.0);
            let scale = 1.0 / (1u32 << k) as f32;
            let (sheet, beams) = (&mut self.sheet, &self.beams);
            self.painter.paint(sheet, size, beams, scale, self.free_space, &self.evidence);
            let evidence = UnitEvidence::new(&self.evidence, level.unit());
            take_over(level, sheet, size, corner.map(|v| v >> k), &evidence, version);
        }
        self.beams.n_hits
    }

    /// Places the beams on the sheet, and says where its lower left corner is, in finest cells from the map's origin: at
    /// whole cells of all levels.
    fn place(
        &mut self,
        scan: &LaserScan,
        map_from_base: &Pose2,
        base_from_sensor: &Pose3,
        resolution_m: f64,
        n_levels: u32,
    ) -> Option<[i64; 2]> {
        let coarsest = 1i64 << n_levels.min(31);
        let at = map_from_base.translation.vector / resolution_m;
        if !(at.x.abs() < 1e9 && at.y.abs() < 1e9) {
            return None;
        }
        // Near the sensor, so that single precision is enough wherever the robot is.
        let whole = [at.x, at.y].map(|v| (v.floor() as i64).div_euclid(coarsest) * coarsest);
        let near = pose2(
            map_from_base.translation.x - whole[0] as f64 * resolution_m,
            map_from_base.translation.y - whole[1] as f64 * resolution_m,
            map_from_base.rotation.angle(),
        );
        self.beams.place(scan, &Mount2::new(&near, base_from_sensor, resolution_m), &self.limits);
        let lowest = |values: &[f32], origin: f32, ends: &[BeamEnd]| {
            let said = values.iter().zip(ends).filter(|(_, end)| **end != BeamEnd::Nothing);
            said.fold(origin, |least, (value, _)| least.min(*value))
        };
        let (beams, [x, y]) = (&self.beams, self.beams.origin);
        let low = [lowest(&beams.x, x, &beams.ends), lowest(&beams.y, y, &beams.ends)];
        if low.iter().any(|v| v.abs() > FARTHEST_CELLS) {
            return None;
        }
        let low = low.map(|v| (v.floor() as i64 - 1).div_euclid(coarsest) * coarsest);
        self.beams.x.iter_mut().for_each(|x| *x -= low[0] as f32);
        self.beams.y.iter_mut().for_each(|y| *y -= low[1] as f32);
        self.beams.origin = [x - low[0] as f32, y - low[1] as f32];
        Some([whole[0] + low[0], whole[1] + low[1]])
    }

    /// Cells of the sheet.
    fn extent(&self) -> Option<GridSize> {
        let beams = &self.beams;
        let highest = |values: &[f32], origin: f32| {
            let said = values.iter().zip(&beams.ends).filter(|(_, end)| **end != BeamEnd::Nothing);
            said.fold(origin, |most, (value, _)| most.max(*value))
        };
        let high = [highest(&beams.x, beams.origin[0]), highest(&beams.y, beams.origin[1])];
        let fits = high.iter().all(|v| (0.0..2.0 * FARTHEST_CELLS).contains(v));
        fits.then(|| GridSize::new(high[0] as usize + 2, high[1] as usize + 2))
    }
}

/// Writes what a sheet shows into the tiles below it. The sheet began without evidence, so its sign says whether a beam
/// passed or ended in a cell.
fn take_over(
    level: &mut TileLevel,
    sheet: &[f32],
    size: GridSize,
    corner: [i64; 2],
    evidence: &UnitEvidence,
    version: u64,
) {
    let edge = TILE_CELLS as i64;
    let end = [corner[0] + size.width as i64, corner[1] + size.height as i64];
    let first_tile = corner.map(|v| v.div_euclid(edge));
    let last_tile = end.map(|v| (v - 1).div_euclid(edge));
    for tile_y in first_tile[1]..=last_tile[1] {
        for tile_x in first_tile[0]..=last_tile[0] {
            let low = [tile_x * edge, tile_y * edge];
            let cols = low[0].max(corner[0])..(low[0] + edge).min(end[0]);
            let rows = low[1].max(corner[1])..(low[1] + edge).min(end[1]);
            let line = |row: i64| {
                let begin = (row - corner[1]) as usize * size.width;
                let (from, to) = ((cols.start - corner[0]) as usize, (cols.end - corner[0]) as usize);
                sheet.get(begin + from..begin + to).unwrap_or_default()
            };
            if rows.clone().all(|row| line(row).iter().all(|said| *said == 0.0)) {
                continue;
            }
            let Some(tile) = level.tile_mut([tile_x, tile_y]) else { continue };
            tile.version = version;
            for row in rows {
                write_line(
                    tile,
                    (cols.start - low[0]) as usize,
                    (row - low[1]) as usize,
                    line(row),
                    evidence,
                );
            }
        }
    }
}

/// Adds a line of evidence to a tile's cells.
fn write_line(tile: &mut Tile, col: usize, row: usize, said: &[f32], evidence: &UnitEvidence) {
    let begin = row * TILE_CELLS + col;
    let Some(cells) = tile.cells.get_mut(begin..begin + said.len()) else { return };
    for (cell, said) in cells.iter_mut().zip(said) {
        let (passed, hit) = (evidence.passed(*cell), evidence.hit(*cell));
        *cell = if *said > 0.0 {
            hit
        } else if *said < 0.0 {
            passed
        } else {
            *cell
        };
    }
}
