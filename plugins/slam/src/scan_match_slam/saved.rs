//! The whole state as bytes, and back.

use super::motion::{Motion, MotionState};
use super::settings::TrackerSettings;
use super::tracker::{ScanTracker, Tracked};
use nalgebra::Matrix3;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Twist, pose2};
use rumbo_core::map::{Grid, GridHeader, Map};
use rumbo_core::messages::SensorId;
use rumbo_core::seal::{Broken, Reader, Seal};
use rumbo_core::time::Time;
use rumbo_kit::occupancy::UpdateGate;
use rumbo_kit::scan_match::SurfaceMap;

const SEAL: Seal = Seal { magic: *b"RUMBOSMS", version: 4 };

/// Everything that the next scan depends on; none before the first scan.
pub fn save(tracker: &ScanTracker) -> Option<Vec<u8>> {
    let (state, drawn, levels) = (tracker.state?, tracker.drawn.as_ref()?, &tracker.levels);
    let mut bytes = SEAL.begin(1024 + 4 * drawn.cells.len() * 5 / 2);
    let to = &mut bytes;
    put_stamp(to, state.stamp);
    put_pose(to, &state.map_from_base);
    put(to, state.covariance.as_slice());
    put(to, tracker.drift.as_slice());
    put(to, &[tracker.way_without_match_m, tracker.blind_deviation_m]);
    put_count(to, tracker.n_without_match);
    put_count(to, u32::from(tracker.is_by_odometer));
    put_count(to, u32::from(tracker.is_blank));
    put_some(to, tracker.pending.as_ref(), |to, (pose, covariance)| {
        put_pose(to, pose);
        put(to, covariance.as_slice());
    });
    put_motion(to, &tracker.motion.state());
    let gates: Vec<(SensorId, Pose2)> =
        tracker.gates.iter().filter_map(|(sensor, gate)| Some((*sensor, gate.last()?))).collect();
    put_all(to, &gates, |to, (sensor, pose)| {
        put_count(to, sensor.0.into());
        put_pose(to, pose);
    });
    put_all(to, &tracker.trajectory, put_stamped);
    put_grid(to, drawn);
    put_levels(to, levels);
    put_some(to, tracker.surfaces.as_ref(), put_surfaces);
    put_some(to, tracker.sure_levels.as_ref(), put_levels);
    Some(Seal::close(bytes))
}

/// Goes on from what was saved. The map's layers are replaced.
///
/// # Errors
/// What is wrong with the bytes; nothing was changed then.
pub fn restore(tracker: &mut ScanTracker, bytes: &[u8], map: &mut Map) -> Result<(), Broken> {
    let mut rest = SEAL.open(bytes)?;
    let restored = read(&mut rest, tracker.settings).filter(|_| rest.is_empty());
    let fresh = restored.ok_or(Broken::Damaged)?;
    (map.grid, map.coarse_grids) = (fresh.drawn.clone(), Vec::new());
    map.touch();
    *tracker = fresh;
    Ok(())
}

fn read(from: &mut Reader<'_>, settings: TrackerSettings) -> Option<ScanTracker> {
    let mut tracker = ScanTracker::new(settings);
    let state = Tracked { stamp: Time(from.i64()?), map_from_base: pose(from)?, covariance: matrix(from)? };
    tracker.state = Some(state);
    tracker.newest = Some(state.stamp);
    tracker.is_resumed = true;
    tracker.drift = matrix(from)?;
    tracker.way_without_match_m = number(from)?;
    tracker.blind_deviation_m = number(from)?;
    tracker.n_without_match = from.u32()?;
    tracker.is_by_odometer = from.u32()? != 0;
    tracker.is_blank = from.u32()? != 0;
    tracker.pending = some(from, |from| Some((pose(from)?, matrix(from)?)))?;
    tracker.motion = Motion::resumed(settings.prediction, settings.errors, &motion(from)?);
    let [way_m, turn_rad] = settings.insert_every;
    tracker.gates = all(from, |from| {
        let sensor = SensorId(u16::try_from(from.u32()?).ok()?);
        let mut gate = UpdateGate::new(way_m, turn_rad);
        gate.close(&pose(from)?);
        Some((sensor, gate))
    })?;
    tracker.trajectory = all(from, |from| Some((Time(from.i64()?), pose(from)?)))?;
    let drawn = Map { grid: Some(grid(from)?), ..Map::default() };
    tracker.levels = levels(from)?;
    let fits = tracker.mapper.pyramid().fits(&tracker.levels) && tracker.drawer.pyramid().fits(&drawn);
    tracker.drawn = drawn.grid;
    let finest = tracker.levels.grid.as_ref()?;
    let empty = SurfaceMap::new(finest.resolution_m(), finest.grid_from_map());
    let saved = some(from, surfaces)?;
    tracker.surfaces = tracker.settings.polish.is_some().then(|| saved.unwrap_or(empty));
    tracker.sure_levels = some(from, levels)?;
    // Tables that are made of a map are known by its version.
    tracker.levels.touch();
    let fits =
        fits && tracker.sure_levels.as_ref().is_none_or(|levels| tracker.mapper.pyramid().fits(levels));
    fits.then_some(tracker)
}

fn put_motion(to: &mut Vec<u8>, motion: &MotionState) {
    put_all(to, &motion.odometry, put_stamped);
    put_all(to, &motion.rates_rad_s, |to, (stamp, rate)| {
        put_stamp(to, *stamp);
        put(to, &[*rate]);
    });
    put_some(to, motion.last.as_ref(), put_stamped);
    put_some(to, motion.matched.as_ref(), |to, stamp| put_stamp(to, *stamp));
    put_some(to, motion.velocity.as_ref(), |to, velocity| {
        put(to, &[velocity.forward_m_s, velocity.left_m_s, velocity.turn_rad_s]);
    });
}

fn motion(from: &mut Reader<'_>) -> Option<MotionState> {
    Some(MotionState {
        odometry: all(from, |from| Some((Time(from.i64()?), pose(from)?)))?,
        rates_rad_s: all(from, |from| Some((Time(from.i64()?), number(from)?)))?,
        last: some(from, |from| Some((Time(from.i64()?), pose(from)?)))?,
        matched: some(from, |from| from.i64().map(Time))?,
        velocity: some(from, |from| {
            let (forward_m_s, left_m_s) = (number(from)?, number(from)?);
            Some(Twist { forward_m_s, left_m_s, turn_rad_s: number(from)? })
        })?,
    })
}

fn put_stamp(to: &mut Vec<u8>, stamp: Time) {
    to.extend(stamp.0.to_le_bytes());
}

fn put_count(to: &mut Vec<u8>, count: u32) {
    to.extend(count.to_le_bytes());
}

fn put_stamped(to: &mut Vec<u8>, (stamp, pose): &(Time, Pose2)) {
    put_stamp(to, *stamp);
    put_pose(to, pose);
}

fn put_some<T>(to: &mut Vec<u8>, value: Option<&T>, put: impl Fn(&mut Vec<u8>, &T)) {
    put_count(to, u32::from(value.is_some()));
    if let Some(value) = value {
        put(to, value);
    }
}

fn put_all<T>(to: &mut Vec<u8>, values: &[T], put: impl Fn(&mut Vec<u8>, &T)) {
    put_count(to, values.len() as u32);
    values.iter().for_each(|value| put(to, value));
}

fn some<'b, T>(from: &mut Reader<'b>, read: impl Fn(&mut Reader<'b>) -> Option<T>) -> Option<Option<T>> {
    if from.u32()? == 0 { Some(None) } else { read(from).map(Some) }
}

fn all<'b, T>(from: &mut Reader<'b>, read: impl Fn(&mut Reader<'b>) -> Option<T>) -> Option<Vec<T>> {
    let n = from.u32()?;
    (0..n).map(|_| read(from)).collect()
}

fn number(from: &mut Reader<'_>) -> Option<f64> {
    from.f64().filter(|number| number.is_finite())
}

fn matrix(from: &mut Reader<'_>) -> Option<Matrix3<f64>> {
    let mut matrix = Matrix3::zeros();
    for value in matrix.iter_mut() {
        *value = number(from)?;
    }
    Some(matrix)
}

fn put(bytes: &mut Vec<u8>, numbers: &[f64]) {
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
}

fn put_pose(bytes: &mut Vec<u8>, pose: &Pose2) {
    put(bytes, &[pose.translation.x, pose.translation.y, pose.rotation.angle()]);
}

fn put_grid(bytes: &mut Vec<u8>, grid: &Grid) {
    let header = grid.header();
    bytes.extend(header.width.to_le_bytes());
    bytes.extend(header.height.to_le_bytes());
    put(bytes, &[header.resolution_m, header.occupied_above.into(), header.free_below.into()]);
    put(bytes, &header.origin);
    bytes.extend(grid.cells.iter().flat_map(|cell| cell.to_le_bytes()));
}

fn put_levels(bytes: &mut Vec<u8>, levels: &Map) {
    let grids: Vec<&Grid> = levels.grid.iter().chain(&levels.coarse_grids).collect();
    put_all(bytes, &grids, |bytes, grid| put_grid(bytes, grid));
}

fn levels(from: &mut Reader<'_>) -> Option<Map> {
    let mut grids = all(from, grid)?;
    let coarse_grids = grids.split_off(usize::from(!grids.is_empty()));
    Some(Map { grid: Some(grids.pop()?), coarse_grids, ..Map::default() })
}

fn put_surfaces(bytes: &mut Vec<u8>, surfaces: &SurfaceMap) {
    put(bytes, &[surfaces.resolution_m()]);
    put_pose(bytes, &surfaces.level_from_map());
    put_count(bytes, surfaces.tiles().count() as u32);
    for (tile, cells) in surfaces.tiles() {
        bytes.extend(tile.iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend(cells.iter().flatten().flat_map(|v| v.to_le_bytes()));
    }
}

fn surfaces(rest: &mut Reader<'_>) -> Option<SurfaceMap> {
    let resolution_m = number(rest).filter(|edge| *edge > 0.0)?;
    let mut surfaces = SurfaceMap::new(resolution_m, pose(rest)?);
    for _ in 0..rest.u32()? {
        let tile = [rest.u32()?, rest.u32()?].map(|v| v as i32);
        let numbers: Vec<f32> =
            rest.u32s(SurfaceMap::TILE_NUMBERS)?.into_iter().map(f32::from_bits).collect();
        surfaces.put_tile(tile, numbers.as_chunks().0).then_some(())?;
    }
    Some(surfaces)
}

fn pose(rest: &mut Reader<'_>) -> Option<Pose2> {
    let pose = pose2(rest.f64()?, rest.f64()?, rest.f64()?);
    rumbo_core::frames::is_finite2(&pose).then_some(pose)
}

fn grid(rest: &mut Reader<'_>) -> Option<Grid> {
    let (width, height) = (rest.u32()?, rest.u32()?);
    let (resolution_m, occupied_above, free_below) = (rest.f64()?, rest.f64()?, rest.f64()?);
    let origin = [rest.f64()?, rest.f64()?, rest.f64()?];
    let n_cells = (width as usize).checked_mul(height as usize)?;
    let cells: Vec<f32> = rest.u32s(n_cells)?.into_iter().map(f32::from_bits).collect();
    if cells.iter().any(|cell| !cell.is_finite()) {
        return None;
    }
    let header = GridHeader {
        width,
        height,
        resolution_m,
        origin,
        occupied_above: occupied_above as f32,
        free_below: free_below as f32,
    };
    Grid::new(header, Buffer::from(cells)).ok()
}
