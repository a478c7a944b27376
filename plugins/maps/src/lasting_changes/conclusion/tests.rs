//! Single cells and small pictures.

use super::*;
use crate::lasting_changes::{Beam, VisitRules};
use rumbo_core::map::Grid;

const VISIT: VisitRules = VisitRules { min_scans: 3, min_duration_s: 1.0 };
const RULES: Rules = Rules { confirm_visits: 2, removal: Removal::SeenBefore };

/// `#` occupied, `?` unknown, `.` free; the first line is the upper one.
fn raster(picture: &[&str]) -> Raster {
    let (width, height) = (picture[0].len() as u32, picture.len() as u32);
    let mut grid = Grid::unknown(width, height, 0.05).unwrap();
    for (row, line) in picture.iter().rev().enumerate() {
        for (col, letter) in line.chars().enumerate() {
            let cell = &mut grid.cells.make_mut()[row * width as usize + col];
            *cell = match letter {
                '#' => Grid::CERTAIN,
                '?' => 0.0,
                _ => -Grid::CERTAIN,
            };
        }
    }
    Raster::of(&grid).unwrap()
}

fn picture(raster: &Raster) -> Vec<String> {
    let letter = |class: &CellClass| match class {
        CellClass::Occupied => '#',
        CellClass::Unknown => '?',
        CellClass::Free => '.',
    };
    raster.classes.chunks(raster.size().width).rev().map(|row| row.iter().map(letter).collect()).collect()
}

/// Every second a beam along the row from the left, that ends in this column.
fn visit(raster: &Raster, ends: &[(usize, usize)], seconds: usize) -> Visit {
    let mut visit = Visit::new(raster.size().n_cells(), VISIT);
    for second in 0..seconds {
        let beam = |&(row, col): &(usize, usize)| {
            let y = row as f64 + 0.5;
            Beam { from: [0.5, y], to: [col as f64 + 0.5, y], is_hit: true }
        };
        let beams: Vec<Beam> = ends.iter().map(beam).collect();
        visit.take(&beams, raster, second as f32);
    }
    visit
}

/// The map after so many such visits, each to the map that the one before left.
fn after(raster: &Raster, ends: &[(usize, usize)], n_visits: u32, rules: &Rules) -> (Raster, Memory) {
    let (mut map, mut memory) = (raster.clone(), Memory::blank(raster.size().n_cells()));
    for _ in 0..n_visits {
        memory = conclude(&map, &memory, &visit(&map, ends, 3), rules).memory;
        memory.apply(&mut map);
    }
    assert_eq!(memory.n_visits, n_visits);
    (map, memory)
}

#[test]
fn what_stands_in_two_visits_comes_into_the_map() {
    let map = raster(&["..........#"]);
    assert_eq!(picture(&after(&map, &[(0, 5)], 1, &RULES).0), ["..........#"]);
    assert_eq!(picture(&after(&map, &[(0, 5)], 2, &RULES).0), [".....#....#"]);
}

#[test]
fn a_visit_that_does_not_see_it_does_not_count_and_one_that_sees_it_gone_begins_anew() {
    let map = raster(&["..........#"]);
    let (seen, unseen) = (visit(&map, &[(0, 5)], 3), visit(&map, &[], 3));
    let free = visit(&map, &[(0, 10)], 3);
    let end = |visits: &[&Visit]| {
        visits.iter().fold(Memory::blank(11), |memory, visit| conclude(&map, &memory, visit, &RULES).memory)
    };
    assert_eq!(end(&[&seen]).cell(5).occupied_visits, 1);
    assert_eq!(end(&[&seen, &unseen, &seen]).cell(5).learned, Some(Verdict::Occupied));
    assert_eq!(end(&[&seen, &free]).cell(5), Default::default());
    assert_eq!(end(&[&seen, &free, &seen]).cell(5).occupied_visits, 1);
}

#[test]
fn a_cell_beside_what_the_map_has_is_no_news() {
    let map = raster(&["..........#"]);
    assert_eq!(after(&map, &[(0, 9)], 5, &RULES).1.cells.len(), 0);
    // But where the old one is seen through, the new one is.
    let map = raster(&[".....#....#", ".....#....#"]);
    let rules = Rules { removal: Removal::All, ..RULES };
    assert_eq!(picture(&after(&map, &[(0, 10), (1, 10)], 2, &rules).0), ["..........#", "..........#"]);
}

#[test]
fn what_is_gone_leaves_the_map_if_a_laser_had_met_it() {
    let map = raster(&["....##....#", "....##....#", "....##....#"]);
    let through = [(0, 10), (1, 10), (2, 10)];
    let (same, memory) = after(&map, &through, 5, &RULES);
    assert_eq!((picture(&same), memory.cells.len()), (picture(&map), 0), "it might be glass");
    let rules = Rules { removal: Removal::Nothing, ..RULES };
    let met = conclude(&map, &Memory::blank(33), &visit(&map, &[(1, 4)], 3), &RULES).memory;
    let gone = |rules: &Rules, n_visits: usize| {
        let (mut map, mut memory) = (map.clone(), met.clone());
        for _ in 0..n_visits {
            memory = conclude(&map, &memory, &visit(&map, &through, 3), rules).memory;
            memory.apply(&mut map);
        }
        picture(&map)
    };
    assert_eq!(gone(&RULES, 1), picture(&map));
    assert_eq!(gone(&RULES, 2), ["..........#", "..........#", "..........#"]);
    assert_eq!(gone(&rules, 5), picture(&map));
}

#[test]
fn a_wall_that_other_beams_meet_stays_although_some_graze_through_it() {
    let map = raster(&["..........", "#########.", ".........."]);
    let rules = Rules { removal: Removal::All, ..RULES };
    let mut grazed = Visit::new(30, VISIT);
    for second in 0..9 {
        let along = Beam { from: [0.5, 1.9], to: [9.9, 1.9], is_hit: true };
        let down = (0..9).map(|col| {
            let x = f64::from(col) + 0.5;
            Beam { from: [x, 2.9], to: [x, 1.5], is_hit: true }
        });
        // First the grazing beam alone, then those that meet the wall as well.
        let beams: Vec<Beam> = std::iter::once(along).chain(down.filter(|_| second > 5)).collect();
        grazed.take(&beams, &map, second as f32);
    }
    let end = conclude(&map, &Memory::blank(30), &grazed, &rules);
    assert_eq!(end.n_different, 0, "{:?}", end.memory.cells);
}

#[test]
fn scatter_of_readings_makes_nothing_thicker() {
    let map = raster(&["..........#"]);
    let mut scattered = Visit::new(11, VISIT);
    for second in 0..40 {
        let col = if second % 8 == 0 { 4.5 } else { 5.5 };
        scattered.take(&[Beam { from: [0.5, 0.5], to: [col, 0.5], is_hit: true }], &map, second as f32);
    }
    let end = conclude(&map, &Memory::blank(11), &scattered, &RULES);
    assert_eq!(end.memory.unconfirmed().collect::<Vec<_>>(), [(5, Verdict::Occupied)]);
}

#[test]
fn unknown_floor_becomes_known() {
    let map = raster(&["...??.....#", "...??.....#"]);
    let (map, _) = after(&map, &[(0, 10), (1, 10)], 2, &RULES);
    assert_eq!(picture(&map), ["..........#", "..........#"]);
}
