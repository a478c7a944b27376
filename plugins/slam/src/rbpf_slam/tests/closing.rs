//! Loops that no guess closes: places against the truth of the hall, bent ways against closed forms, ways through links
//! against all ways.

use super::hall::{Hall, apart, lane};
use crate::rbpf_slam::RbpfSlamParams;
use crate::rbpf_slam::archive::{Archive, Link, turned_into};
use crate::rbpf_slam::bending::bent as bend;
use crate::rbpf_slam::closing::{Closing, ClosingSettings};
use crate::rbpf_slam::filter::Filter;
use crate::rbpf_slam::follower::Followed;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::LaserScan;
use rumbo_core::rng::{RngExt as _, stream};
use rumbo_kit::streams::Streams;
use std::collections::BTreeSet;
use std::sync::Arc;

fn closing() -> ClosingSettings {
    RbpfSlamParams::default().settings().unwrap().closing
}

fn push(archive: &mut Archive, scan: &LaserScan, deviations: [f64; 3]) {
    let covariance = Matrix3::from_diagonal(&Vector3::from(deviations.map(|v| v * v)));
    let followed = Followed { before_from_after: Pose2::identity(), covariance };
    archive.push(scan, &Pose3::identity(), true, &followed);
}

/// Once around the hall and three meters more; the second way turns by a little too much in each step.
fn around_the_hall(seed: u64) -> (Archive, Vec<Pose2>, Vec<Pose2>) {
    let (hall, mut rng) = (Hall::published(), stream(seed, "around"));
    let truth: Vec<Pose2> = (0..94).map(|k| lane(0.5 * f64::from(k))).collect();
    let (mut archive, mut way) = (Archive::default(), vec![truth[0]]);
    for (k, pose) in truth.iter().enumerate() {
        push(&mut archive, &hall.scan(pose, &mut rng), [0.02, 0.02, 0.012]);
        if k > 0 {
            let followed = truth[k - 1].inverse() * pose * pose2(0.0, 0.0, 0.13f64.to_radians());
            way.push(way[k - 1] * followed);
        }
    }
    (archive, truth, way)
}

fn farthest_m(a: &[Pose2], b: &[Pose2]) -> f64 {
    a.iter().zip(b).map(|(a, b)| apart(a, b)[0]).fold(0.0, f64::max)
}

#[test]
fn a_loop_that_is_open_by_more_than_a_match_reaches_is_found_and_the_way_bent() {
    for seed in 1..4 {
        let (archive, truth, way) = around_the_hall(seed);
        let here = way.len() - 1;
        let off_m = apart(&truth[here], &way[here])[0];
        assert!(off_m > 0.8, "{off_m} m: matches alone would close that");
        let found = Closing::default().find(&archive, &way, None, &closing()).unwrap();
        let place_from_here = truth[found.place].inverse() * truth[here];
        let [off_m, off_deg] = apart(&place_from_here, &found.place_from_here);
        assert!(off_m < 0.06 && off_deg < 0.6, "seed {seed}: {off_m} m, {off_deg} degrees");
        let information = turned_into(&found.place_from_here, &(found.information * 0.05));
        let link = Link { earlier: found.place, later: here, information };
        let bent = bend(&archive, &way, &link, &found.place_from_here).unwrap();
        assert!(farthest_m(&bent, &truth) < 0.25 * farthest_m(&way, &truth));
    }
}

#[test]
fn a_way_with_no_loop_open_is_left_alone_where_the_place_is_known_already() {
    let (mut archive, _, way) = around_the_hall(4);
    let found = Closing::default().find(&archive, &way, None, &closing()).unwrap();
    let (earlier, later) = (found.place, way.len() - 1);
    archive.links.push(Link { earlier, later, information: Matrix3::identity() });
    let again = Closing::default().find(&archive, &way, None, &closing());
    assert_eq!(again, None, "a short way leads there");
    let nowhere = ClosingSettings { most_reach_m: 0.0, drift_share: 0.0, ..closing() };
    archive.links.clear();
    let found = Closing::default().find(&archive, &way, None, &nowhere);
    assert!(
        found.is_none_or(|found| apart(&found.place_from_here, &(way[found.place].inverse() * way[later]))
            [0]
            < 0.5)
    );
}

#[test]
fn a_place_that_could_be_several_is_none() {
    // To and fro in a corridor without doors.
    let reading = |k: usize| {
        let sin = (-135f64 + k as f64).to_radians().sin().abs();
        (1.2 / sin.max(1e-6)).min(100.0) as f32
    };
    let scan = LaserScan {
        first_bearing_rad: -135f64.to_radians(),
        bearing_step_rad: 1f64.to_radians(),
        max_range_m: 30.0,
        ranges_m: (0..271).map(reading).collect::<Vec<f32>>().into(),
        ..LaserScan::default()
    };
    let (mut archive, mut way) = (Archive::default(), Vec::new());
    for k in 0i32..80 {
        push(&mut archive, &scan, [0.01, 0.01, 0.002]);
        let along_m = 0.5 * f64::from(if k < 40 { k } else { 80 - k });
        way.push(pose2(along_m, 0.0, 0.0));
    }
    assert_eq!(Closing::default().find(&archive, &way, None, &closing()), None);
}

#[test]
fn a_place_that_is_like_another_one_elsewhere_is_none() {
    // Around a hall, around another one just like it, and back somewhere between the two.
    let (hall, mut rng) = (Hall::published(), stream(3, "twins"));
    let (mut archive, mut way) = (Archive::default(), Vec::new());
    let mut visit = |archive: &mut Archive, map_from_hall: &Pose2, steps: std::ops::Range<i32>| {
        for pose in steps.map(|k| lane(0.5 * f64::from(k))) {
            push(archive, &hall.scan(&pose, &mut rng), [0.02, 0.02, 0.012]);
            way.push(map_from_hall * pose);
        }
        way.clone()
    };
    let between = pose2(6.0, 0.0, 0.0);
    let far = ClosingSettings { drift_share: 0.2, ..closing() };
    visit(&mut archive, &Pose2::identity(), 0..86);
    let mut one = archive.clone();
    visit(&mut archive, &pose2(12.0, 0.0, 0.0), 0..86);
    let twice = visit(&mut archive, &between, 0..10);
    let found = Closing::default().find(&archive, &twice, None, &far);
    assert_eq!(found, None, "either of the two");
    // The first hall alone is found.
    one.taken.extend_from_slice(&archive.taken[172..]);
    let once = [&twice[..86], &twice[172..]].concat();
    let found = Closing::default().find(&one, &once, None, &far).unwrap();
    let [off_m, _] = apart(&(once[found.place] * found.place_from_here), &lane(4.5));
    assert!(off_m < 0.06, "{off_m} m");
}

#[test]
fn each_step_takes_its_share_of_what_a_loop_was_open_by() {
    let scan = LaserScan { max_range_m: 30.0, ranges_m: vec![1.0].into(), ..LaserScan::default() };
    let deviations: Vec<f64> = (0..12).map(|k| 0.01 + 0.01 * f64::from(k % 5)).collect();
    let (mut archive, mut way) = (Archive::default(), vec![pose2(1.0, 2.0, 0.7)]);
    push(&mut archive, &scan, [1.0, 1.0, 1.0]);
    for deviation in &deviations {
        push(&mut archive, &scan, [*deviation, 0.02, 1e-6]);
        way.push(way[way.len() - 1] * pose2(0.5, 0.0, 0.0));
    }
    // The link speaks of the last ten steps.
    let (earlier, later, variance) = (2, 12, 0.03f64.powi(2));
    let link = Link { earlier, later, information: Matrix3::identity() / variance };
    let open_m = 0.2;
    let bent = bend(&archive, &way, &link, &pose2(5.0 + open_m, 0.0, 0.0)).unwrap();
    let variances: Vec<f64> = deviations.iter().map(|v| v * v).collect();
    let total: f64 = variances[2..].iter().sum::<f64>() + variance;
    for (k, pair) in bent.windows(2).enumerate() {
        let share = if k < 2 { 0.0 } else { variances[k] / total };
        let step = pair[0].inverse() * pair[1];
        assert!((step.translation.x - 0.5 - open_m * share).abs() < 1e-6, "step {k}: {}", step.translation.x);
        assert!(step.translation.y.abs() < 1e-6 && step.rotation.angle().abs() < 1e-6);
    }
    // Six deviations, and then what no step may be torn by although its noise allows it.
    let far = pose2(5.0 + 6.0 * total.sqrt(), 0.0, 0.0);
    assert_eq!(bend(&archive, &way, &link, &far), None, "too improbable");
    let mut wide = archive.clone();
    wide.taken.iter_mut().for_each(|taken| taken.covariance *= 1e4);
    assert_eq!(bend(&wide, &way, &link, &pose2(15.0, 0.0, 0.0)), None, "torn");
}

#[test]
fn the_shortest_way_goes_through_places_that_were_recognized() {
    let scan = LaserScan { max_range_m: 30.0, ranges_m: vec![1.0].into(), ..LaserScan::default() };
    let mut rng = stream(9, "ways");
    for _ in 0..20 {
        let (mut archive, mut way) = (Archive::default(), Vec::new());
        for _ in 0..30 {
            push(&mut archive, &scan, [0.1; 3]);
            way.push(pose2(
                rng.random_range(0.0..9.0),
                rng.random_range(0.0..9.0),
                rng.random_range(-3.0..3.0),
            ));
        }
        for _ in 0..4 {
            let (a, b) = (rng.random_range(0..30usize), rng.random_range(0..30usize));
            if a != b {
                let (earlier, later) = (a.min(b), a.max(b));
                archive.links.push(Link { earlier, later, information: Matrix3::identity() });
            }
        }
        // Floyd and Warshall: all ways between all pairs.
        let length_m = |a: usize, b: usize| {
            let [off_m, off_deg] = apart(&way[a], &way[b]);
            off_m + 0.5 * off_deg.to_radians()
        };
        let mut ways = vec![vec![f64::INFINITY; 30]; 30];
        let pairs = (0..29).map(|k| (k, k + 1)).chain(archive.links.iter().map(|l| (l.earlier, l.later)));
        for (a, b) in pairs {
            (ways[a][b], ways[b][a]) = (length_m(a, b), length_m(a, b));
        }
        for via in 0..30 {
            for a in 0..30 {
                for b in 0..30 {
                    ways[a][b] = ways[a][b].min(ways[a][via] + ways[via][b]);
                }
            }
        }
        ways[17][17] = 0.0;
        for (found, expected) in archive.ways_from(17, &way).iter().zip(&ways[17]) {
            assert!((found - expected).abs() < 1e-4, "{found} {expected}");
        }
    }
}

#[test]
fn after_a_loop_all_guesses_share_one_map_that_is_drawn_along_the_way() {
    let (archive, truth, way) = around_the_hall(5);
    let params = RbpfSlamParams { particles: 6, ..RbpfSlamParams::default() };
    let mut filter = Filter::new(params.settings().unwrap().filter, Streams::new(stream(5, "settle")));
    filter.begin(&truth[0]);
    filter.settle(truth.clone(), &archive);
    assert_eq!(filter.particles().len(), 6);
    assert!((0..6).all(|idx| filter.lineage().way_of(idx) == truth));
    let tiles = |map: &rumbo_kit::tile_map::TileMap| {
        map.levels()
            .iter()
            .flat_map(|level| level.tiles().map(|(_, tile)| Arc::as_ptr(tile)))
            .collect::<Vec<_>>()
    };
    let distinct: BTreeSet<_> = filter.particles().iter().flat_map(|particle| tiles(&particle.map)).collect();
    assert_eq!(distinct.len(), filter.particles()[0].map.n_tiles());
    // What a beam hit is there, and drawn along another way it is elsewhere.
    let hits = |filter: &Filter| {
        let map = &filter.particles()[0].map;
        let scan = &archive.taken[60].scan;
        let seen = |(bearing_rad, range_m): (f64, f64)| {
            let point =
                truth[60] * pose2(0.0, 0.0, bearing_rad) * rumbo_core::frames::Point2::new(range_m, 0.0);
            map.log_odds_at(point) > 0.0
        };
        scan.hits().map(seen).filter(|hit| *hit).count() as f64 / scan.hits().count() as f64
    };
    let along_the_truth = hits(&filter);
    filter.settle(way, &archive);
    assert!(along_the_truth > 0.8 && hits(&filter) < 0.6, "{along_the_truth} {}", hits(&filter));
}
