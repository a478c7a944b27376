//! The layout byte by byte, and everything that a file can be instead.

use super::*;
use rumbo_core::boundary::Buffer;
use rumbo_core::map::{CellClass, Grid, GridHeader};

/// Four columns and three rows at (1, 2): free, with one wall cell.
fn grid() -> Grid {
    let header = GridHeader { origin: [1.0, 2.0, 0.0], ..*Grid::unknown(4, 3, 0.5).unwrap().header() };
    let mut cells = Buffer::filled(12, -Grid::CERTAIN);
    cells.make_mut()[5] = Grid::CERTAIN;
    Grid::new(header, cells).unwrap()
}

fn raster() -> Raster {
    Raster::of(&grid()).unwrap()
}

fn memory() -> Memory {
    let mut memory = Memory { n_visits: 7, ..Memory::blank(12) };
    memory
        .cells
        .insert(2, CellMemory { learned: Some(Verdict::Occupied), occupied_visits: 0, free_visits: 0 });
    memory.cells.insert(5, CellMemory { learned: Some(Verdict::Free), occupied_visits: 2, free_visits: 0 });
    memory.cells.insert(11, CellMemory { learned: None, occupied_visits: 0, free_visits: 1 });
    memory.was_met[5] = true;
    memory.was_met[8] = true;
    memory
}

fn with_checksum(mut content: Vec<u8>) -> Vec<u8> {
    let checksum = crc32fast::hash(&content);
    content.extend(checksum.to_le_bytes());
    content
}

#[test]
fn every_byte_is_where_the_layout_says() {
    let bytes = memory_bytes(&memory(), &raster());
    assert_eq!(bytes[..12], *b"RUMBOLCH\x01\0\0\0");
    // Columns, rows, and 1 for cells that stand in the map with what was learned: the wall is gone, a thing came.
    let mut hash = sha2::Sha256::default();
    sha2::Digest::update(&mut hash, [4, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0]);
    sha2::Digest::update(&mut hash, [0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(bytes[12..44], sha2::Digest::finalize(hash)[..]);
    assert_eq!(bytes[44..52], [4, 0, 0, 0, 3, 0, 0, 0]);
    let numbers: Vec<f64> =
        bytes[52..84].chunks(8).map(|word| f64::from_le_bytes(word.try_into().unwrap())).collect();
    assert_eq!(numbers, [0.5, 1.0, 2.0, 0.0]);
    assert_eq!(bytes[84..92], [7, 0, 0, 0, 3, 0, 0, 0]);
    let cells = [[2, 0, 0, 0, 1, 0, 0], [5, 0, 0, 0, 2, 2, 0], [11, 0, 0, 0, 0, 0, 1]].concat();
    assert_eq!(bytes[92..113], cells);
    assert_eq!(bytes[113..115], [0b0010_0000, 0b0000_0001]);
    assert_eq!(bytes.len(), 119);
}

#[test]
fn it_comes_back_with_the_map_that_the_visits_began_with_and_with_the_one_that_was_saved() {
    let bytes = memory_bytes(&memory(), &raster());
    let (found, learned) = memory_of(&bytes, &raster()).unwrap();
    assert_eq!(found, memory());
    assert_eq!((learned.class(2), learned.class(5)), (CellClass::Occupied, CellClass::Free));
    let (again, same) = memory_of(&bytes, &learned).unwrap();
    assert_eq!((again, same), (found, learned));
}

#[test]
fn unknown_cells_around_the_known_ones_change_nothing() {
    let bytes = memory_bytes(&memory(), &raster());
    let header = GridHeader {
        width: 6,
        height: 4,
        origin: [0.5, 2.0, 0.0],
        ..*Grid::unknown(6, 4, 0.5).unwrap().header()
    };
    let mut cells = Buffer::zeroed(24);
    for (index, value) in grid().cells.iter().enumerate() {
        cells.make_mut()[index / 4 * 6 + index % 4 + 1] = *value;
    }
    let around = Raster::of(&Grid::new(header, cells).unwrap()).unwrap();
    let (found, learned) = memory_of(&bytes, &around).unwrap();
    assert_eq!(found, memory());
    assert_eq!((around.in_grid(0), around.in_grid(5), learned.class(5)), (1, 8, CellClass::Free));
}

#[test]
fn another_map_is_told_from_the_right_one() {
    let bytes = memory_bytes(&memory(), &raster());
    let header = *grid().header();
    let others = [
        GridHeader { resolution_m: 0.51, ..header },
        GridHeader { origin: [1.01, 2.0, 0.0], ..header },
        GridHeader { origin: [1.0, 2.0, 0.01], ..header },
        GridHeader { width: 3, height: 4, ..header },
    ];
    for header in others {
        let other = Raster::of(&Grid::new(header, grid().cells).unwrap()).unwrap();
        assert_eq!(memory_of(&bytes, &other), Err(MemoryFault::OtherMap), "{header:?}");
    }
    let mut redrawn = grid();
    redrawn.cells.make_mut()[9] = Grid::CERTAIN;
    assert_eq!(memory_of(&bytes, &Raster::of(&redrawn).unwrap()), Err(MemoryFault::OtherMap));
    // What was learned stands above what the map shows, so this is still one of its earlier maps.
    let mut before = grid();
    before.cells.make_mut()[5] = -Grid::CERTAIN;
    assert!(memory_of(&bytes, &Raster::of(&before).unwrap()).is_ok());
}

#[test]
fn what_is_cut_off_damaged_newer_or_something_else_is_refused_with_its_reason() {
    let bytes = memory_bytes(&memory(), &raster());
    for n in 0..bytes.len() {
        let fault = memory_of(&bytes[..n], &raster()).unwrap_err();
        assert_eq!(fault, if n < 8 { MemoryFault::Foreign } else { MemoryFault::Damaged }, "{n} bytes");
    }
    for bit in 0..bytes.len() * 8 {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        let fault = memory_of(&flipped, &raster()).unwrap_err();
        let is_right = match bit / 8 {
            ..8 => fault == MemoryFault::Foreign,
            8..12 => matches!(fault, MemoryFault::Version { .. }),
            _ => fault == MemoryFault::Damaged,
        };
        assert!(is_right, "bit {bit}: {fault:?}");
    }
    let mut newer = bytes.clone();
    newer[8] = 2;
    let told = memory_of(&newer, &raster()).unwrap_err().to_string();
    assert!(told.contains("its version is 2, this program reads 1"), "{told}");
    assert_eq!(memory_of(b"image: floor.pgm\nresolution: 0.05", &raster()), Err(MemoryFault::Foreign));
    let longer = with_checksum([&bytes[..bytes.len() - 4], &[0]].concat());
    assert_eq!(memory_of(&longer, &raster()), Err(MemoryFault::Damaged));
}

#[test]
fn content_that_does_not_hold_together_is_refused_even_with_a_right_checksum() {
    let bytes = memory_bytes(&memory(), &raster());
    let content = &bytes[..bytes.len() - 4];
    let spoiled = |place: usize, value: u8| {
        let mut content = content.to_vec();
        content[place] = value;
        memory_of(&with_checksum(content), &raster())
    };
    for (place, value, what) in [
        (92, 12, "an index beyond the raster, and after it a smaller one"),
        (99, 2, "the same index twice"),
        (96, 3, "a class that is none"),
        (96, 0, "a cell of which nothing is remembered"),
        (105, 1, "visits of both kinds"),
        (91, 255, "more cells than bytes"),
        (47, 255, "columns without end"),
        (51, 255, "rows without end"),
    ] {
        assert_eq!(spoiled(place, value), Err(MemoryFault::Damaged), "{what}");
    }
}

#[test]
fn a_map_without_memory_is_remembered_too() {
    let blank = Memory::blank(12);
    assert_eq!(memory_of(&memory_bytes(&blank, &raster()), &raster()), Ok((blank, raster())));
}
