use super::*;

fn at(seconds: f64) -> Time {
    Time::from_secs(seconds)
}

fn person(x: f64, y: f64, deviation_m: f64) -> PersonPosition {
    PersonPosition { position: Point2::new(x, y), deviation_m }
}

fn following() -> Following {
    Following::new(Follow::default(), None, 0.1)
}

/// Tells where the person is, second by second.
fn walk(following: &mut Following, places: &[(f64, f64)]) {
    for (second, (x, y)) in (0..).zip(places) {
        following.hear(at(f64::from(second)), at(f64::from(second)), &person(*x, *y, 0.0), &mut Vec::new());
    }
}

/// As the engine does: where the robot is sent, if anywhere.
fn step(following: &mut Following, seconds: f64, x: f64, y: f64) -> Option<(f64, f64)> {
    match following.next(at(seconds), Point2::new(x, y), 0.0, &mut Vec::new()) {
        Next::Go { to, .. } => {
            following.note_sent(to);
            Some((to.x, to.y))
        }
        _ => None,
    }
}

#[test]
fn the_trail_is_taken_oldest_first_and_one_position_a_step() {
    let mut following = following();
    // Round a corner: 1 m along x, then 2 m along y, in steps of half a meter; a position every 0.7 m or more.
    walk(
        &mut following,
        &[(0.0, 0.0), (0.5, 0.0), (1.0, 0.0), (1.0, 0.5), (1.0, 1.0), (1.0, 1.5), (1.0, 2.0)],
    );
    assert_eq!(following.trail, [Point2::new(1.0, 0.0), Point2::new(1.0, 1.0), Point2::new(1.0, 2.0)]);
    assert_eq!(step(&mut following, 6.0, -1.0, 0.0), Some((1.0, 0.0)), "not straight to the person");
    assert_eq!(step(&mut following, 6.1, 0.31, 0.0), Some((1.0, 1.0)), "0.69 m is near enough");
    // Near to both that are left: one goes in each step.
    assert_eq!(step(&mut following, 6.2, 0.4, 1.5), Some((1.0, 1.0)), "0.78 m is not");
    assert_eq!(step(&mut following, 6.3, 0.5, 1.45), Some((1.0, 2.0)));
    assert_eq!(
        step(&mut following, 6.4, 0.6, 1.55),
        Some((1.0, 2.0)),
        "that of the person, no longer of the trail"
    );
    assert!(following.trail.is_empty());
    assert_eq!(step(&mut following, 6.5, 0.7, 1.61), None, "0.49 m away");
}

#[test]
fn the_robot_stops_near_the_person_and_starts_when_the_person_has_left() {
    let (mut near, mut events) = (following(), Vec::new());
    walk(&mut near, &[(2.0, 0.0)]);
    assert_eq!(step(&mut near, 0.0, 1.49, 0.0), Some((2.0, 0.0)));
    assert_eq!(near.next(at(0.1), Point2::new(1.51, 0.0), 0.0, &mut events), Next::Wait);
    assert_eq!(near.next(at(0.2), Point2::new(1.51, 0.0), 0.0, &mut events), Next::Wait);
    assert_eq!(events.len(), 1, "said once: {events:?}");
    assert_eq!(events[0].kind, EventKind::PersonReached(Point2::new(2.0, 0.0)));
    assert_eq!(step(&mut near, 0.3, 1.31, 0.0), None, "0.69 m is a step back");
    assert_eq!(step(&mut near, 0.4, 1.29, 0.0), Some((2.0, 0.0)));
    // A fast robot begins to brake before.
    let mut fast = following();
    walk(&mut fast, &[(2.0, 0.0)]);
    assert!(matches!(fast.next(at(0.0), Point2::new(1.29, 0.0), 0.2, &mut events), Next::Go { .. }));
    assert_eq!(fast.next(at(0.1), Point2::new(1.31, 0.0), 0.2, &mut events), Next::Wait);
    // An avoider that goes no nearer than 0.8 m is with the person there.
    let mut coarse = Following::new(Follow::default(), None, 0.8);
    walk(&mut coarse, &[(2.0, 0.0)]);
    assert_eq!(step(&mut coarse, 0.0, 1.21, 0.0), None);
}

#[test]
fn what_may_be_noise_is_no_way() {
    let mut following = following();
    let mut hear = |x: f64| following.hear(Time::ZERO, Time::ZERO, &person(x, 0.0, 0.4), &mut Vec::new());
    [0.0, 0.9, 1.19, -1.19].into_iter().for_each(&mut hear);
    assert!(following.trail.is_empty(), "three deviations are 1.2 m");
    following.hear(Time::ZERO, Time::ZERO, &person(1.21, 0.0, 0.4), &mut Vec::new());
    assert_eq!(following.trail.len(), 1);
    // With the person: a reading 1.1 m off does not make the robot start.
    assert_eq!(step(&mut following, 0.0, 1.21, 0.0), None);
    following.hear(at(1.0), at(1.0), &person(2.3, 0.0, 0.4), &mut Vec::new());
    assert_eq!(step(&mut following, 1.0, 1.21, 0.0), None);
}

#[test]
fn a_person_who_says_nothing_is_lost_until_the_next_news() {
    let (mut following, mut events) = (following(), Vec::new());
    assert_eq!(following.next(at(3.0), Point2::origin(), 0.0, &mut events), Next::Wait);
    following.next(at(8.1), Point2::origin(), 0.0, &mut events);
    following.next(at(9.0), Point2::origin(), 0.0, &mut events);
    let (last, silent_for) = (None, at(8.1) - at(3.0));
    assert_eq!(events.len(), 1);
    assert_eq!(events[0].kind, EventKind::PersonLost { last, silent_for });
    following.hear(at(10.0), at(9.5), &person(4.0, 0.0, 0.0), &mut events);
    assert_eq!(events[1].kind, EventKind::PersonFound(Point2::new(4.0, 0.0)));
    assert_eq!(step(&mut following, 15.0, 0.0, 0.0), Some((4.0, 0.0)), "five seconds are not more than five");
    assert_eq!(following.next(at(15.1), Point2::origin(), 0.0, &mut events), Next::Wait);
    assert!(matches!(events[2].kind, EventKind::PersonLost { last: Some(_), .. }));
    // The trail from before is still there.
    following.hear(at(20.0), at(20.0), &person(5.0, 0.0, 0.0), &mut events);
    assert_eq!(events.len(), 4);
    assert_eq!(following.trail, [Point2::new(5.0, 0.0)]);
}

#[test]
fn late_news_change_nothing() {
    let mut following = following();
    following.hear(at(2.0), at(2.0), &person(2.0, 0.0, 0.0), &mut Vec::new());
    following.hear(at(2.1), at(1.0), &person(9.0, 0.0, 0.0), &mut Vec::new());
    assert_eq!(step(&mut following, 2.1, 0.0, 0.0), Some((2.0, 0.0)));
}

#[test]
fn where_there_is_no_way_the_next_position_is_tried_and_at_last_the_person_again() {
    let mut following = following();
    walk(&mut following, &[(3.0, 0.0), (4.0, 0.0), (5.0, 0.0)]);
    assert_eq!(step(&mut following, 2.0, 0.0, 0.0), Some((4.0, 0.0)));
    following.no_way(at(2.0));
    assert_eq!(step(&mut following, 2.0, 0.0, 0.0), Some((5.0, 0.0)));
    following.no_way(at(2.1));
    assert_eq!(step(&mut following, 2.1, 0.0, 0.0), Some((5.0, 0.0)), "the person");
    following.no_way(at(2.2));
    assert_eq!(following.next(at(4.1), Point2::origin(), 0.0, &mut Vec::new()), Next::Stand);
    assert_eq!(step(&mut following, 4.2, 0.0, 0.0), Some((5.0, 0.0)));
}

#[test]
fn an_endless_trail_loses_its_oldest_positions() {
    let mut following = following();
    let places: Vec<(f64, f64)> = (0..=10_002).map(|k| (f64::from(k), 0.0)).collect();
    walk(&mut following, &places);
    assert_eq!((following.trail.len(), following.trail[0].x), (10_000, 3.0));
}
