//! The example of figure 4.7 of Hernández Alamilla (2005) and lines found by the Hough transform.

use super::hough::Hough;
use super::*;

fn table(text: &str) -> toml::Table {
    toml::from_str(text).unwrap()
}

fn number(row: &toml::Value, key: &str) -> f64 {
    let value = &row[key];
    value.as_float().or(value.as_integer().map(|v| v as f64)).unwrap()
}

fn numbers(row: &toml::Value) -> Vec<f64> {
    row.as_array()
        .unwrap()
        .iter()
        .map(|v| v.as_float().or(v.as_integer().map(|v| v as f64)).unwrap())
        .collect()
}

fn figure() -> (toml::Table, Vec<f64>) {
    let rows = include_str!("../../../tests/data/natural_landmark/fig4_7_scan_1deg.csv");
    let ranges = rows.lines().skip(1).map(|row| row.split(',').nth(1).unwrap().parse().unwrap()).collect();
    (table(include_str!("../../../tests/data/natural_landmark/fig4_7_landmarks.toml")), ranges)
}

fn is_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} for {expected}");
}

fn rows<'a>(file: &'a toml::Table, name: &str) -> &'a Vec<toml::Value> {
    file[name].as_array().unwrap()
}

#[test]
fn the_example_of_the_source_gives_its_twelve_landmarks() {
    let (file, ranges) = figure();
    for settings in [LandmarkSettings::default(), with_hough()] {
        let found = extract(settings, &half_turn(1.0), &ranges);
        assert_eq!(found.len(), 12, "{found:#?}");
        let of = |letters: &str| -> Vec<Landmark> {
            found.iter().filter(|mark| letters.contains(mark.letter())).copied().collect()
        };
        let expected = rows(&file, "expected_discontinuity");
        assert_eq!(of("id").len(), expected.len());
        for (mark, row) in of("id").iter().zip(expected) {
            is_near(mark.distance_m, number(row, "D"), 1e-4);
            is_near(mark.bearing_rad.to_degrees(), number(row, "theta"), 1e-9);
            is_near(mark.extent_m().unwrap(), number(row, "P"), 1.01e-4);
            assert_eq!(mark.letter().to_string(), row["T"].as_str().unwrap());
        }
        let expected = rows(&file, "expected_corner");
        assert_eq!(of("e").len(), expected.len());
        for (mark, row) in of("e").iter().zip(expected) {
            is_near(mark.distance_m, number(row, "D"), 1e-4);
            is_near(mark.bearing_rad.to_degrees(), number(row, "theta"), 1e-9);
            assert_eq!(mark.extent_m(), None);
        }
        let expected = rows(&file, "expected_wall");
        assert_eq!(of("p").len(), expected.len());
        let is_hough = settings.wall_fit == WallFit::Hough;
        for (mark, row) in of("p").iter().zip(expected) {
            is_near(mark.distance_m, number(row, "D"), if is_hough { 1e-4 } else { 0.01 });
            is_near(mark.bearing_rad.to_degrees(), number(row, "theta"), if is_hough { 1e-4 } else { 0.5 });
            is_near(mark.extent_m().unwrap(), number(row, "P"), 1.01e-4);
            let n_inner = mark.beams[1] - mark.beams[0] - 1;
            assert_eq!(f64::from(n_inner), number(row, "interior_points"));
        }
    }
}

#[test]
fn votes_of_the_example_are_those_of_the_transform() {
    let (file, ranges) = figure();
    let mut extractor = Extractor::new(with_hough());
    let walls: Vec<Landmark> = extractor
        .extract(&half_turn(1.0), ranges.iter().copied())
        .iter()
        .filter(|mark| mark.is_wall())
        .copied()
        .collect();
    for (wall, row) in walls.iter().zip(rows(&file, "expected_wall")) {
        let readings = &extractor.readings()[wall.beams[0] as usize..=wall.beams[1] as usize];
        let line = Hough::new().strongest(readings, 8.0).unwrap();
        assert_eq!(f64::from(line.n_votes), number(row, "votes"));
    }
}

#[test]
fn printed_landmarks_are_reproduced_within_the_source_s_own_spread() {
    let (file, ranges) = figure();
    let found = extract(with_hough(), &half_turn(1.0), &ranges);
    for row in rows(&file, "printed") {
        let letter = row["T"].as_str().unwrap();
        let is_wall = letter == "p";
        let fits = |mark: &&Landmark| {
            let [far, turn] = if is_wall { [0.011, 0.5] } else { [0.0101, 1e-6] };
            mark.letter().to_string() == letter
                && mark
                    .extent_m()
                    .is_none_or(|p| (p - number(row, "P")).abs() <= if is_wall { 0.10 } else { 0.011 })
                && (mark.distance_m - number(row, "D")).abs() <= far
                && (mark.bearing_rad.to_degrees() - number(row, "theta")).abs() <= turn
        };
        assert!(found.iter().any(|mark| fits(&mark)), "{row}");
    }
}

#[test]
fn lines_of_the_hough_vectors_are_found_on_all_sides() {
    let file = table(include_str!("../../../tests/data/natural_landmark/hough.toml"));
    for case in rows(&file, "hough") {
        let readings: Vec<Reading> = case["points"]
            .as_array()
            .unwrap()
            .iter()
            .map(numbers)
            .map(|point| Reading::at(point[0].to_radians(), point[1]))
            .collect();
        let line = Hough::new().strongest(&readings, 8.0).unwrap();
        let result = numbers(&case["result"]);
        assert_eq!(f64::from(line.n_votes), number(case, "votes"));
        is_near(line.distance_m, result[0], 1e-9);
        is_near(line.bearing_rad.to_degrees(), result[1], 1e-9);
    }
}
