//! Whole searches: rooms that look the same, and things that hide half of the view; the example `relocalization_figures`
//! makes many.

use super::relocalization_work::{Clutter, Course, Ending, Laser, Office, Said};
use rumbo_core::rng::stream;
use rumbo_localizers::landmark_relaxation::LandmarkRelaxationParams;

fn defaults() -> LandmarkRelaxationParams {
    LandmarkRelaxationParams::default()
}

fn among_rooms(is_closed: bool, params: &LandmarkRelaxationParams) -> Vec<Ending> {
    let office = Office::alike(2, is_closed);
    let known = office.knowledge(params);
    let run = |seed: u64| {
        let map_from_base = office.pose_in_a_room(2, &mut stream(seed, "alike"));
        let (laser, boxes) = (Laser::lms200(), Vec::new());
        Course { office: &office, known: &known, laser, boxes, map_from_base }.run(params, seed)
    };
    (0..12).map(run).collect()
}

#[test]
fn of_two_rooms_that_look_the_same_the_right_one_is_found_by_going_where_they_differ() {
    let endings = among_rooms(false, &defaults());
    let count = |of: fn(&Ending) -> bool| endings.iter().filter(|ending| of(ending)).count();
    assert!(count(|ending| ending.first == Said::Ambiguous) >= 10, "{endings:?}");
    assert!(count(|ending| ending.is_success() && ending.n_moves <= 1) >= 5, "{endings:?}");
    assert!(count(Ending::is_success) >= 11 && count(Ending::is_wrong) == 0, "{endings:?}");
    assert!(endings.iter().all(|ending| ending.kept_the_truth));
    // It is the moving that does it.
    let stays = among_rooms(false, &LandmarkRelaxationParams { most_moves: 0, ..defaults() });
    assert!(stays.iter().filter(|ending| ending.last == Said::Ambiguous).count() >= 10, "{stays:?}");
}

#[test]
fn of_closed_rooms_that_look_the_same_none_is_ever_believed() {
    for ending in among_rooms(true, &defaults()) {
        assert!(ending.last == Said::Ambiguous && ending.n_moves == 3 && ending.kept_the_truth, "{ending:?}");
    }
}

/// A robot half of whose view is hidden, in the smallest office or in another building.
fn half_hidden(
    params: &LandmarkRelaxationParams,
    is_known: bool,
    seeds: impl Iterator<Item = u64>,
) -> Vec<Ending> {
    let (office, other) = (Office::named("5x5"), Office::named("10x10"));
    let known = office.knowledge(params);
    let office = if is_known { &office } else { &other };
    let run = |seed: u64| {
        let mut rng = stream(seed, "hidden");
        let map_from_base = office.pose(&mut rng);
        let boxes = Clutter::HalfHidden.around(&map_from_base, &mut rng);
        Course { office, known: &known, laser: Laser::lms200(), boxes, map_from_base }.run(params, seed)
    };
    seeds.map(run).collect()
}

#[test]
fn a_robot_half_of_whose_view_is_hidden_moves_and_is_found_and_no_other_place_is_believed() {
    let endings = half_hidden(&defaults(), true, 20..36);
    let n_found = endings.iter().filter(|ending| ending.is_success()).count();
    let n_at_once = endings.iter().filter(|ending| ending.is_success() && ending.n_moves == 0).count();
    assert!(n_found >= 10 && n_at_once < n_found, "{n_found}, {n_at_once} at once: {endings:?}");
    assert!(!endings.iter().any(Ending::is_wrong), "{endings:?}");
    let elsewhere = half_hidden(&defaults(), false, 36..44);
    assert!(elsewhere.iter().all(|ending| ending.last != Said::Found), "{elsewhere:?}");
}

#[test]
fn who_believes_whatever_fits_believes_wrong_places_when_half_of_the_view_is_hidden() {
    let rash = LandmarkRelaxationParams { sure_explained: 0.0, sure_matches: 0, ..defaults() };
    let endings = [half_hidden(&rash, true, 30..31), half_hidden(&rash, false, 39..40)].concat();
    assert!(endings.iter().any(Ending::is_wrong), "{endings:?}");
}
