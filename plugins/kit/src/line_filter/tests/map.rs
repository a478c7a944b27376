//! How the map grows: first scan, hits, forgetting, the last test, merging.

use super::{close, seen, sure};
use crate::line_filter::*;
use crate::lines::SensedLine;

fn filter(growth: Growth) -> LineFilter {
    let (robot, covariance) = sure();
    LineFilter::building(FilterSettings { growth, ..FilterSettings::default() }, robot, &covariance)
}

fn without_bootstrap() -> LineFilter {
    filter(Growth { bootstrap: false, ..Growth::default() })
}

fn see(filter: &mut LineFilter, lines: &[SensedLine]) -> ScanReport {
    filter.read_lines(lines, &Mount::default())
}

#[test]
fn long_lines_of_the_first_scan_are_walls_at_once_and_short_ones_must_be_seen_again() {
    let mut filter = filter(Growth::default());
    let lines = [seen(5.0, 0.0, [-1.0, 1.001]), seen(4.0, 1.5, [-1.0, 0.999])];
    assert_eq!(see(&mut filter, &lines).n_added, 1);
    close(filter.state().walls[0][0], 5.0, 1e-12, "rho");
    let p = filter.state().between(0, 0);
    close(p[(0, 0)], 1e-4 + 1e-6, 1e-12, "the line's and the robot's");
    assert_eq!(see(&mut filter, &lines).n_added, 0);
    let third = see(&mut filter, &lines);
    assert_eq!((third.n_added, third.matches.len()), (1, 1));
    assert_eq!(see(&mut filter, &[seen(3.0, -2.0, [-2.0, 2.0])]).n_added, 0, "it is not the first scan");
}

#[test]
fn three_scans_make_a_wall_and_two_pieces_in_one_scan_count_once() {
    let mut filter = without_bootstrap();
    let pieces = [seen(5.0, 0.0, [-2.0, -0.5]), seen(5.0, 0.0, [0.2, 1.5])];
    see(&mut filter, &pieces);
    see(&mut filter, &pieces);
    assert!(filter.walls().is_empty(), "four sightings in two scans");
    let last = seen(5.01, 0.001, [-1.0, 2.5]);
    assert_eq!(see(&mut filter, &[last]).n_added, 1);
    // From the last measurement alone, as long as all of them together.
    close(filter.state().walls[0][0], 5.01, 1e-12, "rho");
    let [right, left] = filter.walls()[0].ends_m;
    close(right[1], -2.0, 0.02, "right end");
    close(left[1], 2.5, 0.02, "left end");
}

#[test]
fn lines_that_are_no_walls_wait_for_their_period() {
    for (test_period_s, scans_until_wall) in [(0.0, 3), (0.5, 3), (1.0, 5), (1.2, 7)] {
        let growth = Growth { bootstrap: false, test_period_s, ..Growth::default() };
        let mut filter = filter(growth);
        let lines = [seen(5.0, 0.0, [-2.0, 2.0])];
        let mut n_scans = 0;
        while filter.walls().is_empty() && n_scans < 20 {
            filter.predict(0.5);
            see(&mut filter, &lines);
            n_scans += 1;
        }
        // The first scan is a test, and the third test confirms.
        assert_eq!(n_scans, scans_until_wall, "{test_period_s}");
        filter.predict(0.5);
        let matched = see(&mut filter, &lines).matches.len();
        assert_eq!(matched, 1, "walls of the map are matched with every scan");
    }
}

#[test]
fn a_line_that_is_not_seen_for_six_scans_is_forgotten() {
    for (n_empty, n_walls) in [(5, 1), (6, 0)] {
        let mut filter = without_bootstrap();
        let line = seen(5.0, 0.0, [-2.0, 2.0]);
        see(&mut filter, &[line]);
        see(&mut filter, &[line]);
        (0..n_empty).for_each(|_| {
            see(&mut filter, &[]);
        });
        see(&mut filter, &[line]);
        assert_eq!(filter.walls().len(), n_walls, "after {n_empty} scans without it");
    }
}

#[test]
fn lines_apart_are_candidates_of_their_own() {
    // Just within and just beyond 0.3 m, 15 degrees and 1 m.
    let angle = 15f64.to_radians();
    let others = [
        (seen(5.29, 0.0, [-2.0, 2.0]), seen(5.31, 0.0, [-2.0, 2.0])),
        (seen(5.0, angle - 0.001, [-2.0, 2.0]), seen(5.0, angle + 0.001, [-2.0, 2.0])),
        (seen(5.0, 0.0, [2.99, 4.0]), seen(5.0, 0.0, [3.01, 4.0])),
    ];
    for (near, far) in others {
        for (other, n_walls) in [(near, 1), (far, 0)] {
            let mut filter = without_bootstrap();
            let line = seen(5.0, 0.0, [-2.0, 2.0]);
            [line, other, line].iter().for_each(|line| {
                see(&mut filter, &[*line]);
            });
            assert_eq!(filter.walls().len(), n_walls, "{other:?}");
        }
    }
}

#[test]
fn a_candidate_that_is_a_known_wall_after_all_only_extends_it() {
    let mut filter = filter(Growth::default());
    see(&mut filter, &[seen(5.0, 0.0, [-2.0, 2.0])]);
    // Too far along to be matched, so it becomes a candidate; the third sighting comes within a meter of the wall.
    let beyond = seen(5.0, 0.0, [3.5, 4.5]);
    see(&mut filter, &[beyond]);
    see(&mut filter, &[beyond]);
    let gates = Gates { gap_m: 2.0, ..Gates::default() };
    filter.settings.gates = Gates { behind_m: -100.0, ..gates };
    // Now no wall is ever matched (all are too near), and the candidate is confirmed.
    let third = see(&mut filter, &[beyond]);
    assert_eq!((third.n_added, third.matches.len()), (0, 0));
    assert_eq!(filter.walls().len(), 1);
    close(filter.walls()[0].ends_m[1][1], 4.5, 1e-6, "the wall reaches as far as both");
}

#[test]
fn matched_walls_reach_as_far_as_they_were_seen_and_stay_on_their_line() {
    let mut filter = filter(Growth::default());
    see(&mut filter, &[seen(5.0, 0.0, [-2.0, 2.0])]);
    see(&mut filter, &[seen(5.01, 0.002, [-4.0, -1.0])]);
    let ([rho, phi], [right, left]) = (filter.state().walls[0], filter.walls()[0].ends_m);
    for [x, y] in [right, left] {
        close(x * phi.cos() + y * phi.sin(), rho, 1e-9, "on the line");
    }
    close(right[1], -4.0, 0.03, "right end");
    close(left[1], 2.0, 0.03, "left end");
}

#[test]
fn walls_that_overlap_and_cannot_be_told_apart_become_one() {
    let growth = Growth { merge: true, ..Growth::default() };
    for (merge, n_walls) in [(true, 1), (false, 2)] {
        let mut filter = filter(Growth { merge, ..growth });
        // Two pieces of the first scan, and then one line over both.
        see(&mut filter, &[seen(5.0, 0.0, [-3.0, -0.5]), seen(5.005, 0.001, [0.5, 3.0])]);
        assert_eq!(filter.walls().len(), 2);
        let before: Vec<f64> = (0..2).map(|wall| filter.state().between(wall, wall)[(0, 0)]).collect();
        let report = see(&mut filter, &[seen(5.0, 0.0, [-1.0, 1.0])]);
        assert_eq!(filter.walls().len(), n_walls, "{report:?}");
        assert_eq!(report.n_merged, 2 - n_walls);
        if merge {
            let [right, left] = filter.walls()[0].ends_m;
            assert!(right[1] < -2.9 && left[1] > 2.9);
            assert!(filter.state().between(0, 0)[(0, 0)] < before[0].min(before[1]));
        }
    }
}

#[test]
fn running_innovations_leave_their_band_only_when_the_filter_errs() {
    let mut consistency = Consistency::default();
    (0..49).for_each(|_| consistency.push(2.0, 2));
    assert!(consistency.band().is_none());
    consistency.push(2.0, 2);
    let band = consistency.band().unwrap();
    close(band.mean, 1.0, 1e-12, "mean");
    // Chi square of 100 degrees of freedom at 0.05 % and 99.95 % (tables: 59.90 and 153.17).
    close(band.band[0], 0.5990, 1e-3, "lower end");
    close(band.band[1], 1.5317, 1e-3, "upper end");
    assert!(!band.is_overconfident() && !band.is_conservative());
    (0..50).for_each(|_| consistency.push(3.1, 2));
    assert!(consistency.band().unwrap().is_overconfident());
    (0..50).for_each(|_| consistency.push(1.1, 2));
    assert!(consistency.band().unwrap().is_conservative());
}
