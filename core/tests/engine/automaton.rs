//! The mission's automaton against that of Hernández Alamilla (2005), appendix B: states, codes, and every transition.

use crate::*;
use nalgebra::Matrix3;
use rumbo_core::engine::{Order, State};
use rumbo_core::frames::{Point2, Pose2};
use rumbo_core::messages::Goal;
use rumbo_core::pipeline::{InitialPose, StageSpec, WellKnownPose};
use rumbo_core::time::Span;

const VECTOR: &str = include_str!("../data/natural_landmark/http_api.toml");
const STATES: [State; 5] = [State::NoMap, State::Lost, State::Localizing, State::Waiting, State::Navigating];

fn vector() -> toml::Table {
    VECTOR.parse().unwrap()
}

fn state_named(name: &str) -> State {
    STATES.into_iter().find(|state| state.to_string() == name).unwrap_or_else(|| panic!("{name}"))
}

/// What makes a transition: an order, or what happens by itself in an engine that was made for it.
fn order_of(event: &str) -> Option<Order> {
    Some(match event {
        "map_ready accepted" => Order::SetMap(Box::new(map())),
        "set_position" => {
            Order::SetPose { map_from_base: Pose2::identity(), covariance: Matrix3::identity() * 1e-4 }
        }
        "localize" => Order::Localize,
        "go_to" => go(3.0),
        _ => return None,
    })
}

fn go(x: f64) -> Order {
    Order::GoTo(vec![Goal { position: Point2::new(x, 0.0), yaw_rad: None }])
}

/// The map of the builder that is used in these tests.
fn map() -> rumbo_core::map::Map {
    let mut engine = Engine::build(&pipeline("map of")).unwrap();
    engine.step();
    engine.view().map.clone()
}

/// An engine in a state; `event` decides what its plugins do.
fn engine_in(state: State, event: &str) -> Engine {
    let mut with = pipeline("automaton");
    with.mission.waypoints.clear();
    if matches!(state, State::NoMap | State::Lost | State::Localizing) {
        with.mission.initial_pose = InitialPose::WellKnown(WellKnownPose::Unknown);
    }
    if state == State::NoMap {
        with.map_builders.clear();
    }
    let gives_up = if event == "localization failed" { "gives_up = true" } else { "" };
    with.relocalizer = Some(stage(Stage::Localizer, "relocalizer", "turner", None, gives_up));
    let lost = if event == "tracking lost" { "lost_at_s = 1.0\n" } else { "" };
    let lost = format!("{lost}needs_grid = true");
    with.localizer = Some(stage(Stage::Localizer, "quiet localizer", "reckoning", None, &lost));
    let refuses = if event == "goal unreachable" { "refuses = true" } else { "" };
    let planner = stage(Stage::Planner, "quiet planner", "line", None, refuses);
    with.planner = Some(StageSpec { latency: Span::from_secs(0.5), ..planner });
    let mut engine = Engine::build(&with).unwrap();
    engine.step();
    match state {
        State::Lost => engine.command(Order::Cancel),
        State::Navigating => engine.command(go(1.0)),
        _ => {}
    }
    if matches!(state, State::Lost | State::Navigating) {
        engine.step();
    }
    assert_eq!(engine.view().state, state);
    engine
}

#[test]
fn the_codes_of_the_states_are_the_published_ones() {
    let vector = vector();
    let codes = vector["status_codes"].as_table().unwrap();
    assert_eq!(codes.len(), STATES.len());
    for (name, code) in codes {
        assert_eq!(i64::from(state_named(name).code()), code.as_integer().unwrap(), "{name}");
    }
}

#[test]
fn every_published_transition_happens() {
    let vector = vector();
    let mut n_tried = 0;
    for transition in vector["transition"].as_array().unwrap() {
        let word = |key: &str| transition[key].as_str().unwrap();
        let (event, from, to) = (word("event"), state_named(word("from")), state_named(word("to")));
        // Maps that do not come are a matter of who fetches them: then there is no order.
        if event == "map_ready failed" {
            assert_eq!(from, to);
            continue;
        }
        let mut engine = engine_in(from, event);
        let by_itself = order_of(event).map(|order| engine.command(order)).is_none();
        let n_steps = if by_itself { 2_000 } else { 1 };
        let reached = (0..n_steps).any(|_| {
            engine.step();
            engine.view().state != from || from == to
        });
        assert!(reached && engine.view().state == to, "{from} --{event}--> {}", engine.view().state);
        n_tried += 1;
    }
    assert_eq!(n_tried, 13);
}

#[test]
fn every_other_pair_of_state_and_instruction_is_refused_and_changes_nothing() {
    let vector = vector();
    let listed: Vec<(&str, &str)> = vector["transition"]
        .as_array()
        .unwrap()
        .iter()
        .map(|transition| (transition["from"].as_str().unwrap(), transition["event"].as_str().unwrap()))
        .collect();
    let mut n_refused = 0;
    for state in STATES {
        for event in ["map_ready accepted", "set_position", "localize", "go_to"] {
            // A place that somebody points at ends a search, which the source leaves open.
            let ours = (state, event) == (State::Localizing, "set_position");
            if ours || listed.contains(&(state.to_string().as_str(), event)) {
                continue;
            }
            let mut engine = engine_in(state, "");
            engine.command(order_of(event).unwrap());
            engine.step();
            let view = engine.view();
            assert_eq!(view.state, state, "{event}");
            assert!(
                view.events.iter().any(|e| matches!(e.kind, EventKind::Refused { .. })),
                "{state} {event}"
            );
            n_refused += 1;
        }
    }
    assert_eq!(n_refused, 11);
}
