//! Whole scans of the hall of the forklift experiment, with what the reference extraction found in them.

use super::{DATA, circle};
use crate::lines::{LineExtractor, LineSettings, SensedLine};
use rumbo_core::frames::wrap_angle;
use std::f64::consts::{FRAC_PI_2, PI};

/// Rows of a table as numbers, without its head.
fn table(name: &str) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(format!("{DATA}{name}")).unwrap();
    text.lines().skip(1).map(|row| row.split(',').map(|word| word.parse().unwrap()).collect()).collect()
}

/// Extracted lines of the scan in this column of the table.
fn extracted(column: usize) -> Vec<SensedLine> {
    let ranges: Vec<f64> = table("ekf_scans.csv").iter().map(|row| row[column]).collect();
    assert_eq!(ranges.len(), 720);
    LineExtractor::new(LineSettings::default()).extract(&circle(), ranges.into_iter()).to_vec()
}

#[test]
fn the_walls_of_the_hall_are_where_they_are() {
    // At k = 0 the robot stands at (19.5, 10) and looks along y in a hall of 30 m x 20 m.
    let walls = [(10.5, -FRAC_PI_2), (10.0, 0.0), (19.5, FRAC_PI_2), (10.0, PI)];
    let lines = extracted(2);
    for (distance_m, normal_rad) in walls {
        let near = lines.iter().filter(|line| {
            line.n_points >= 50
                && (line.distance_m - distance_m).abs() <= 0.03
                && wrap_angle(line.normal_rad - normal_rad).abs() <= 0.01
        });
        assert!(near.count() >= 1, "no wall at {distance_m} {normal_rad}: {lines:?}");
    }
}

#[test]
fn lines_are_those_of_the_reference_extraction() {
    let log = table("ekf_log_lines.csv");
    for (column, k) in [(2, 0.0), (3, 200.0), (4, 700.0)] {
        let expected: Vec<&Vec<f64>> = log.iter().filter(|row| row[0] == k).collect();
        let found = extracted(column);
        let numbers: Vec<_> =
            found.iter().map(|l| (l.distance_m, l.normal_rad, l.n_points, l.ends_m)).collect();
        assert_eq!(found.len(), expected.len(), "{k}: {numbers:#?}");
        for (line, row) in found.iter().zip(expected) {
            // The table's ranges are rounded to 0.1 mm.
            let found = [
                line.distance_m,
                line.normal_rad,
                line.ends_m[0][0],
                line.ends_m[0][1],
                line.ends_m[1][0],
                line.ends_m[1][1],
            ];
            let expected = [row[1], row[2], row[6], row[7], row[8], row[9]];
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 3e-4, "{k}: {line:?} for {row:?}");
            }
            for (found, expected) in line.covariance.iter().zip([row[3], row[4], row[5]]) {
                assert!((found - expected).abs() < 2e-3 * row[3], "{k}: {line:?} for {row:?}");
            }
            assert_eq!(line.n_points as f64, row[10]);
        }
    }
}
