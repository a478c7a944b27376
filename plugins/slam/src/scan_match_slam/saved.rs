//! The whole state as bytes, and back.

use super::tracker::{ScanTracker, Tracked};
use nalgebra::Matrix3;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::map::{Grid, GridHeader, Map};
use rumbo_core::time::Time;
use rumbo_kit::seal::{Broken, Reader, Seal};

const SEAL: Seal = Seal { magic: *b"RUMBOSMS", version: 1 };

/// Everything that a later run needs; none before the first scan.
pub fn save(tracker: &ScanTracker) -> Option<Vec<u8>> {
    let (state, map) = (tracker.state?, &tracker.kept);
    let mut bytes = SEAL.begin(64 + 4 * map.grid.as_ref().map_or(0, |grid| grid.cells.len()) * 3 / 2);
    bytes.extend(state.stamp.0.to_le_bytes());
    put_pose(&mut bytes, &state.map_from_base);
    put(&mut bytes, state.covariance.as_slice());
    bytes.extend((tracker.trajectory.len() as u32).to_le_bytes());
    for (stamp, pose) in &tracker.trajectory {
        bytes.extend(stamp.0.to_le_bytes());
        put_pose(&mut bytes, pose);
    }
    let grids: Vec<&Grid> = map.grid.iter().chain(&map.coarse_grids).collect();
    bytes.extend((grids.len() as u32).to_le_bytes());
    for grid in grids {
        put_grid(&mut bytes, grid);
    }
    Some(Seal::close(bytes))
}

/// Goes on from what was saved. The map's layers are replaced.
///
/// # Errors
/// What is wrong with the bytes; nothing was changed then.
pub fn restore(tracker: &mut ScanTracker, bytes: &[u8], map: &mut Map) -> Result<(), Broken> {
    let mut rest = SEAL.open(bytes)?;
    let (state, trajectory, mut grids) =
        read(&mut rest).filter(|_| rest.is_empty()).ok_or(Broken::Damaged)?;
    if grids.is_empty() {
        return Err(Broken::Damaged);
    }
    let mut fresh = ScanTracker::new(tracker.settings);
    fresh.pending = Some((state.map_from_base, state.covariance));
    fresh.trajectory = trajectory;
    fresh.state = Some(state);
    fresh.is_blank = false;
    let coarse = grids.split_off(1);
    let restored = Map { grid: grids.pop(), coarse_grids: coarse, ..Map::default() };
    if !tracker.settings.mapper.pyramid.fits(&restored) {
        return Err(Broken::Damaged);
    }
    // Cells of their own: what is kept is written again at every insertion.
    (map.grid, map.coarse_grids) =
        (restored.grid.as_ref().map(unshared), restored.coarse_grids.iter().map(unshared).collect());
    fresh.kept = restored;
    map.touch();
    *tracker = fresh;
    Ok(())
}

/// A copy that shares no cells.
fn unshared(grid: &Grid) -> Grid {
    let mut copy = grid.clone();
    copy.cells.make_mut();
    copy
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

type Parts = (Tracked, Vec<(Time, Pose2)>, Vec<Grid>);

fn read(rest: &mut Reader<'_>) -> Option<Parts> {
    let stamp = Time(rest.i64()?);
    let map_from_base = pose(rest)?;
    let mut covariance = Matrix3::zeros();
    for value in covariance.iter_mut() {
        *value = rest.f64().filter(|v| v.is_finite())?;
    }
    let n_poses = rest.u32()?;
    let mut trajectory = Vec::new();
    for _ in 0..n_poses {
        trajectory.push((Time(rest.i64()?), pose(rest)?));
    }
    let n_grids = rest.u32()?;
    let mut grids = Vec::new();
    for _ in 0..n_grids {
        grids.push(grid(rest)?);
    }
    Some((Tracked { stamp, map_from_base, covariance }, trajectory, grids))
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
