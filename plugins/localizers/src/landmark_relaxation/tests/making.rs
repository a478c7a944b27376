//! Models from files and beside the step.

use super::super::model_making::{FileUse, Made, ModelMaking};
use super::super::model_seat::{ModelSeat, NoModel};
use super::*;
use rumbo_core::stages::Background;
use rumbo_core::time::{Span, Time};
use rumbo_kit::landmark_model::fingerprint;
use std::path::{Path, PathBuf};

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rumbo-relocalizer-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn seat(file: Option<&Path>, background: Background) -> ModelSeat {
    let settings = LandmarkRelaxationParams::default().model();
    ModelSeat::new(settings, file.map(Path::to_path_buf), background)
}

/// Makes the model of a map; how many updates that took.
fn make(seat: &mut ModelSeat, grid: &Grid) -> usize {
    seat.want(grid);
    for n in 1..10_000 {
        seat.go_on(Time::from_secs(0.1 * n as f64)).unwrap();
        if seat.known().is_some() {
            return n;
        }
        std::thread::yield_now();
        if n > 100 {
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
    }
    panic!("it does not come to an end");
}

fn use_of(file: &Path, grid: &Grid) -> FileUse {
    let mut seat = seat(Some(file), Background::inline(Span::ZERO));
    make(&mut seat, grid);
    assert!(seat.known().unwrap().model == knowledge(grid).model, "it is the model of this map");
    seat.file_use()
}

const BUILT: FileUse = FileUse { was_read: false, was_refused: false, is_unwritable: false };
const READ: FileUse = FileUse { was_read: true, ..BUILT };
const REPLACED: FileUse = FileUse { was_refused: true, ..BUILT };

#[test]
fn a_model_is_built_once_and_a_file_that_is_not_its_own_is_replaced() {
    let folder = folder("files");
    let file = folder.join("office.landmark_model");
    let grid = room([0.0; 3]);
    assert_eq!(use_of(&file, &grid), BUILT);
    assert_eq!(use_of(&file, &grid), READ);
    let mut changed = grid.clone();
    changed.cells.make_mut()[30 * 102 + 40] = Grid::CERTAIN;
    assert_eq!(use_of(&file, &changed), REPLACED);
    assert_eq!(use_of(&file, &changed), READ);
    let whole = std::fs::read(&file).unwrap();
    for n in [0, 7, 40, whole.len() / 2, whole.len() - 1] {
        std::fs::write(&file, &whole[..n]).unwrap();
        assert_eq!(use_of(&file, &changed), REPLACED, "{n} bytes");
        assert!(std::fs::read(&file).unwrap() == whole);
    }
    std::fs::write(&file, "somebody's letter").unwrap();
    assert_eq!(use_of(&file, &changed), REPLACED);
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_model_from_a_file_is_there_as_soon_as_one_that_is_built() {
    let folder = folder("rounds");
    let file = folder.join("hall.landmark_model");
    // Large enough for two parts, and quickly traced: most of it is not free.
    let mut grid = Grid::unknown(300, 300, CELL_M).unwrap();
    for row in 10..60 {
        grid.cells.make_mut()[row * 300 + 20..row * 300 + 90].fill(-Grid::CERTAIN);
        grid.cells.make_mut()[row * 300 + 90] = Grid::CERTAIN;
    }
    let updates = |file: Option<&Path>| {
        let mut seat = seat(file, Background::inline(Span::ZERO));
        (make(&mut seat, &grid), seat.file_use().was_read)
    };
    let (n, _) = updates(None);
    assert_eq!(updates(Some(&file)), (n, false));
    assert_eq!(updates(Some(&file)), (n, true));
    assert!(n >= 4, "{n}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_place_that_cannot_be_written_is_said_and_nothing_else_happens() {
    let folder = folder("unwritable");
    let unwritable = FileUse { is_unwritable: true, ..BUILT };
    assert_eq!(use_of(&folder.join("nowhere/office.landmark_model"), &room([0.0; 3])), unwritable);
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn beside_the_step_and_in_it_the_same_model_is_made() {
    let grid = room([0.0; 3]);
    let expected = knowledge(&grid).model;
    for background in [Background::threaded(), Background::inline(Span::from_secs(0.25))] {
        let mut seat = seat(None, background);
        assert_eq!((seat.progress(), seat.known().is_some()), (0.0, false));
        make(&mut seat, &grid);
        assert!(seat.known().unwrap().model == expected && seat.progress() == 1.0);
        // The same map again: nothing is to be done; another: it is.
        seat.want(&grid);
        assert!(seat.known().is_some());
        let mut changed = grid.clone();
        changed.cells.make_mut()[30 * 102 + 40] = Grid::CERTAIN;
        seat.want(&changed);
        assert!(seat.known().is_none());
        make(&mut seat, &changed);
        assert!(seat.known().unwrap().model != expected);
    }
}

#[test]
fn work_that_was_given_up_is_an_error_once_and_can_be_wanted_again() {
    let give_up = GiveUp::default();
    let grid = room([0.0; 3]);
    let mut seat = seat(None, Background::inline(Span::ZERO).under(&give_up));
    seat.want(&grid);
    seat.go_on(Time::ZERO).unwrap();
    give_up.raise();
    let ended = (0..5).find_map(|_| seat.go_on(Time::ZERO).err());
    assert_eq!(ended, Some(NoModel));
    seat.want(&grid);
    let settings = LandmarkRelaxationParams::default().model();
    let mut making = ModelMaking::new(&grid, &settings, None, fingerprint(&grid, &settings));
    making.go_on(&GiveUp::default());
    making.go_on(&give_up);
    assert!(matches!(making.finish(), Made::GivenUp));
}
