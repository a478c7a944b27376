//! Maps: whole where somebody handed one in, and as one number a layer where only sameness matters.

use super::cdr::{CdrError, CdrReader, CdrWriter};
use rumbo_core::boundary::Buffer;
use rumbo_core::map::{Grid, GridHeader, Landmark, Landmarks, Line, Lines, Map, VoxelChunk, Voxels};

/// Writes a whole map.
pub fn put_map(cdr: &mut CdrWriter, map: &Map) {
    cdr.begin().u64(map.version);
    let grids: Vec<&Grid> = map.grid.iter().chain(&map.coarse_grids).collect();
    cdr.bool(map.grid.is_some());
    cdr.length(grids.len());
    grids.into_iter().for_each(|grid| put_grid(cdr, grid));
    cdr.bool(map.lines.is_some());
    put_lines(cdr, map.lines.as_ref().map_or(&[], |lines| &lines.lines));
    cdr.bool(map.landmarks.is_some());
    put_landmarks(cdr, map.landmarks.as_ref().map_or(&[], |landmarks| &landmarks.landmarks));
    cdr.bool(map.voxels.is_some());
    map.voxels.iter().for_each(|voxels| put_voxels(cdr, voxels));
}

fn put_grid(cdr: &mut CdrWriter, grid: &Grid) {
    let header = grid.header();
    cdr.u32(header.width);
    cdr.u32(header.height);
    cdr.f64(header.resolution_m);
    cdr.array(&header.origin);
    cdr.f32(header.occupied_above);
    cdr.f32(header.free_below);
    cdr.f32s(&grid.cells);
}

fn put_lines(cdr: &mut CdrWriter, lines: &[Line]) {
    cdr.length(lines.len());
    for line in lines {
        cdr.array(&line.from);
        cdr.array(&line.to);
        cdr.array(&line.covariance);
    }
}

fn put_landmarks(cdr: &mut CdrWriter, landmarks: &[Landmark]) {
    cdr.length(landmarks.len());
    for landmark in landmarks {
        cdr.u32(landmark.identity);
        cdr.u32(landmark.kind);
        cdr.array(&landmark.position);
        cdr.array(&landmark.covariance);
    }
}

fn put_voxels(cdr: &mut CdrWriter, voxels: &Voxels) {
    cdr.f64(voxels.resolution_m);
    cdr.array(&voxels.origin);
    cdr.length(voxels.chunks.len());
    for chunk in &voxels.chunks {
        chunk.index.iter().for_each(|part| cdr.i32(*part));
        cdr.f32s(&chunk.log_odds);
    }
}

/// Reads a whole map.
pub fn read_map(message: &[u8]) -> Result<Map, CdrError> {
    let mut cdr = CdrReader::new(message)?;
    let (version, has_grid) = (cdr.u64()?, cdr.bool()?);
    let n_grids = cdr.length(4)?;
    let mut grids = (0..n_grids).map(|_| grid(&mut cdr)).collect::<Result<Vec<_>, _>>()?;
    let first = if has_grid && !grids.is_empty() { Some(grids.remove(0)) } else { None };
    let has_lines = cdr.bool()?;
    let lines = (0..cdr.length(56)?).map(|_| line(&mut cdr)).collect::<Result<Vec<_>, _>>()?;
    let has_landmarks = cdr.bool()?;
    let landmarks = (0..cdr.length(48)?).map(|_| landmark(&mut cdr)).collect::<Result<Vec<_>, _>>()?;
    let voxels = if cdr.bool()? { Some(voxels(&mut cdr)?) } else { None };
    Ok(Map {
        version,
        grid: first,
        coarse_grids: grids,
        lines: has_lines.then(|| Lines { lines: Buffer::from(lines) }),
        landmarks: has_landmarks.then(|| Landmarks { landmarks: Buffer::from(landmarks) }),
        voxels,
    })
}

fn grid(cdr: &mut CdrReader<'_>) -> Result<Grid, CdrError> {
    let header = GridHeader {
        width: cdr.u32()?,
        height: cdr.u32()?,
        resolution_m: cdr.f64()?,
        origin: cdr.array()?,
        occupied_above: cdr.f32()?,
        free_below: cdr.f32()?,
    };
    let wrong = |fault: rumbo_core::map::GridFault| CdrError::Value {
        field: "grid",
        found: fault.to_string(),
        expected: "a grid",
    };
    Grid::new(header, Buffer::from(cdr.f32s()?)).map_err(wrong)
}

fn line(cdr: &mut CdrReader<'_>) -> Result<Line, CdrError> {
    Ok(Line { from: cdr.array()?, to: cdr.array()?, covariance: cdr.array()? })
}

fn landmark(cdr: &mut CdrReader<'_>) -> Result<Landmark, CdrError> {
    let (identity, kind) = (cdr.u32()?, cdr.u32()?);
    Ok(Landmark { identity, kind, position: cdr.array()?, covariance: cdr.array()? })
}

fn voxels(cdr: &mut CdrReader<'_>) -> Result<Voxels, CdrError> {
    let (resolution_m, origin) = (cdr.f64()?, cdr.array()?);
    let chunk = |cdr: &mut CdrReader<'_>| {
        let index = [cdr.i32()?, cdr.i32()?, cdr.i32()?];
        Ok(VoxelChunk { index, log_odds: Buffer::from(cdr.f32s()?) })
    };
    let chunks = (0..cdr.length(16)?).map(|_| chunk(cdr)).collect::<Result<_, CdrError>>()?;
    Ok(Voxels { resolution_m, origin, chunks })
}

/// Writes one number a layer that changes with every bit of it; zero for a layer that is not there.
pub fn put_map_hash(cdr: &mut CdrWriter, map: &Map) {
    let mut room = CdrWriter::default();
    let mut hash = |is_there: bool, put: &dyn Fn(&mut CdrWriter)| {
        if is_there { room.hash(put) } else { 0 }
    };
    let grid = hash(map.grid.is_some(), &|cdr| map.grid.iter().for_each(|grid| put_grid(cdr, grid)));
    let coarse_grids = hash(!map.coarse_grids.is_empty(), &|cdr| {
        map.coarse_grids.iter().for_each(|grid| put_grid(cdr, grid));
    });
    let lines = hash(map.lines.is_some(), &|cdr| {
        put_lines(cdr, map.lines.as_ref().map_or(&[], |lines| &lines.lines));
    });
    let landmarks = hash(map.landmarks.is_some(), &|cdr| {
        put_landmarks(cdr, map.landmarks.as_ref().map_or(&[], |landmarks| &landmarks.landmarks));
    });
    let voxels = hash(map.voxels.is_some(), &|cdr| {
        map.voxels.iter().for_each(|voxels| put_voxels(cdr, voxels));
    });
    cdr.begin().u64(map.version);
    [grid, coarse_grids, lines, landmarks, voxels].into_iter().for_each(|hash| cdr.u64(hash));
}

#[cfg(test)]
mod tests {
    use super::super::word_hash::hash_of;
    use super::*;

    fn map() -> Map {
        let mut grid = Grid::unknown(3, 2, 0.1).unwrap();
        grid.cells.make_mut()[4] = 1.0 / 3.0;
        let line = Line { from: [0.1, 0.2], to: [0.3, 0.4], covariance: [1.0, 2.0, 3.0] };
        let landmark = Landmark { identity: 4, kind: 1, position: [0.1, 0.2], covariance: [1.0, 0.0, 1.0] };
        let chunk = VoxelChunk { index: [-1, 0, 2], log_odds: Buffer::from(vec![0.5f32; 4]) };
        Map {
            version: 7,
            coarse_grids: vec![Grid::unknown(2, 1, 0.2).unwrap()],
            grid: Some(grid),
            lines: Some(Lines { lines: Buffer::from(vec![line]) }),
            landmarks: Some(Landmarks { landmarks: Buffer::from(vec![landmark]) }),
            voxels: Some(Voxels { resolution_m: 0.05, origin: [0.0; 3], chunks: vec![chunk] }),
        }
    }

    #[test]
    fn a_map_comes_back_whole() {
        let mut cdr = CdrWriter::default();
        for map in [Map::default(), map()] {
            put_map(&mut cdr, &map);
            assert_eq!(read_map(cdr.bytes()), Ok(map));
        }
        for len in 0..cdr.bytes().len() {
            assert!(read_map(&cdr.bytes()[..len]).is_err(), "cut at {len}");
        }
    }

    #[test]
    fn a_hash_without_room_for_the_message_is_that_of_its_bytes() {
        let mut cdr = CdrWriter::default();
        for (width, height) in [(3, 2), (77, 31), (64, 64)] {
            let mut map = map();
            let grid = Grid::unknown(width, height, 0.1).unwrap();
            map.coarse_grids = vec![grid.clone(), grid];
            let put = |cdr: &mut CdrWriter| map.coarse_grids.iter().for_each(|grid| put_grid(cdr, grid));
            put(cdr.begin());
            let expected = hash_of(cdr.bytes());
            assert_eq!(cdr.hash(put), expected);
        }
    }

    #[test]
    fn one_changed_cell_changes_the_number_of_its_layer_only() {
        let numbers = |map: &Map| {
            let mut cdr = CdrWriter::default();
            put_map_hash(&mut cdr, map);
            let mut reader = CdrReader::new(cdr.bytes()).unwrap();
            [(); 6].map(|()| reader.u64().unwrap())
        };
        let before = numbers(&map());
        let mut changed = map();
        changed.grid.as_mut().unwrap().cells.make_mut()[5] = 1e-9;
        let after = numbers(&changed);
        let differ: Vec<usize> = (0..6).filter(|idx| before[*idx] != after[*idx]).collect();
        assert_eq!(differ, [1]);
        assert_eq!(numbers(&Map::default()), [0; 6]);
    }
}
