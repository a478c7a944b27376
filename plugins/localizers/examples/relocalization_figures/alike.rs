//! Rooms that look the same: how many moves it takes to tell them apart.

use super::relocalization_work::{Course, Ending, Laser, Office, Said};
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::rng::stream;
use rumbo_localizers::landmark_relaxation::LandmarkRelaxationParams;
use std::f64::consts::TAU;

/// Two and four rooms, open and closed; so many starts each.
pub fn run(n_starts: u64) {
    let params = LandmarkRelaxationParams::default();
    for (n_rooms, is_closed) in [(2, false), (4, false), (2, true), (4, true)] {
        let office = Office::alike(n_rooms, is_closed);
        let known = office.knowledge(&params);
        let course = |seed: u64| {
            let pose = office.pose_in_a_room(n_rooms, &mut stream(seed, "alike"));
            let course = Course {
                office: &office,
                known: &known,
                laser: Laser::lms200(),
                boxes: Vec::new(),
                map_from_base: pose,
            };
            (pose, course.run(&params, seed))
        };
        let all: Vec<(Pose2, Ending)> = (0..n_starts).map(course).collect();
        println!("{n_rooms} rooms{}:", if is_closed { ", closed" } else { "" });
        tell("all starts", all.iter().map(|(_, ending)| ending));
        if !is_closed {
            for ways in [&[1.0][..], &[0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]] {
                let can = |(pose, ending): &&(Pose2, Ending)| {
                    ending.first == Said::Ambiguous && one_move_parts(&office, n_rooms, pose, ways)
                };
                tell(
                    &format!("told apart by one of {ways:?} m"),
                    all.iter().filter(can).map(|(_, ending)| ending),
                );
            }
        }
        for (seed, (_, ending)) in
            all.iter().enumerate().filter(|(_, (_, e))| e.is_wrong() || e.n_moves > 2).take(8)
        {
            println!("       start {seed}: {ending:?}");
        }
    }
}

fn tell<'a>(which: &str, endings: impl Iterator<Item = &'a Ending>) {
    let endings: Vec<&Ending> = endings.collect();
    let count = |of: &dyn Fn(&Ending) -> bool| endings.iter().filter(|ending| of(ending)).count();
    println!(
        "  {which}: {}; at first {} found, {} ambiguous, {} lost; found after 0, 1, 2, 3 moves {:?}; wrong {}, ambiguous at \
         the end {}, lost {}; the truth was among the candidates in {}; first way {:.2} m",
        endings.len(),
        count(&|e| e.first == Said::Found),
        count(&|e| e.first == Said::Ambiguous),
        count(&|e| e.first == Said::Lost),
        [0, 1, 2, 3].map(|n| count(&|e| e.is_success() && e.n_moves == n)),
        count(&|e| e.is_wrong()),
        count(&|e| e.last == Said::Ambiguous),
        count(&|e| e.last == Said::Lost),
        count(&|e| e.kept_the_truth),
        endings.iter().map(|e| e.first_way_m).sum::<f64>() / endings.len().max(1) as f64,
    );
}

/// By brute force on the true floor: after some straight way of these lengths, in any direction in single degrees, that a
/// robot of 0.30 m with its air can drive, a tenth of all ranges differ from those in every other room.
fn one_move_parts(office: &Office, n_rooms: usize, pose: &Pose2, ways_m: &[f64]) -> bool {
    let room = ((pose.translation.x - super::relocalization_work::FIRST_ROOM_M)
        / super::relocalization_work::ROOM_TO_ROOM_M) as i64;
    let in_room = |other: i64| {
        pose2((other - room) as f64 * super::relocalization_work::ROOM_TO_ROOM_M, 0.0, 0.0) * pose
    };
    let others: Vec<Pose2> = (0..n_rooms as i64).filter(|other| *other != room).map(in_room).collect();
    let parts = |way_m: f64, degree: u32| {
        let base_from_there = Pose2::rotation(f64::from(degree).to_radians()) * pose2(way_m, 0.0, 0.0);
        let is_free = (1..=(way_m / 0.1) as u32).all(|k| {
            let at =
                pose * Pose2::rotation(f64::from(degree).to_radians()) * pose2(f64::from(k) * 0.1, 0.0, 0.0);
            office.is_open(at.translation.x / 0.05, at.translation.y / 0.05, 0.30 / 0.05)
        });
        let range = |from: &Pose2, k: u32| office.range_m(from, TAU * f64::from(k) / 180.0, &[]).min(8.0);
        let differs = |other: &Pose2| {
            let (here, there) = (pose * base_from_there, other * base_from_there);
            (0..180).filter(|k| (range(&here, *k) - range(&there, *k)).abs() > 0.2).count() >= 18
        };
        is_free && others.iter().all(differs)
    };
    ways_m.iter().any(|way_m| (0..360).any(|degree| parts(*way_m, degree)))
}
