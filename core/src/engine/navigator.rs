//! The mission's automaton: goals, paths, remembered obstacles, and the one door for commands.

use super::events::{Event, EventKind};
use super::obstacles::ObstacleMemory;
use super::order::State;
use super::patience::Patience;
use crate::frames::Point2;
use crate::messages::{Goal, Path, Status};
use crate::pipeline::Mission;
use crate::time::{Span, Time};
use std::collections::VecDeque;

/// How the last order for goals ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// All goals were reached.
    Arrived,
    /// A scripted drive is over.
    Driven,
    /// A goal cannot be reached.
    Unreachable(String),
    /// Many plans, no progress.
    Stuck(String),
    /// A goal took too long.
    TimedOut,
    /// The planner failed in a way that another try would not mend.
    PlannerFailed(String),
}

/// The automaton's memory.
#[derive(Debug)]
pub struct Navigator {
    /// Present state.
    pub state: State,
    /// Goals left, the present one first.
    pub goals: VecDeque<Goal>,
    /// The path that is followed.
    pub path: Option<Path>,
    /// Goes up with every new path.
    pub path_number: u64,
    /// What is in the way.
    pub memory: ObstacleMemory,
    /// A new path is needed.
    pub needs_plan: bool,
    /// Old obstacles were forgotten once for the present goal: a second time would be an endless tour of closed doors.
    pub has_forgotten: bool,
    /// Waiting for a way to open.
    pub patience: Patience,
    /// New plans for the present goal.
    pub replans: u32,
    /// How the last goals ended.
    pub outcome: Option<Outcome>,
    /// The run shall end.
    pub shutdown: bool,
    /// The goal moves: one that cannot be reached now is no end.
    pub is_following: bool,
    /// There was no way to a goal that moves.
    pub found_no_way: bool,
    mission: Mission,
    goal_since: Time,
    anchor: Option<Point2>,
    plans_at_anchor: u32,
    /// Something remembered was seen to be gone since the robot came to this spot.
    has_changed: bool,
}

impl Navigator {
    /// So many plans without progress are enough.
    const PLANS_WITHOUT_PROGRESS: u32 = 5;
    /// So many where what is in the way comes and goes.
    const PLANS_AMONG_PEOPLE: u32 = 20;
    /// Less than this is no progress, meters.
    const PROGRESS_M: f64 = 0.10;

    /// Without map, place and goals.
    pub fn new(mission: &Mission) -> Navigator {
        Navigator {
            state: State::NoMap,
            goals: VecDeque::new(),
            path: None,
            path_number: 0,
            memory: ObstacleMemory::new(mission),
            needs_plan: false,
            has_forgotten: false,
            patience: Patience::of(mission.patience_s),
            replans: 0,
            outcome: None,
            shutdown: false,
            is_following: mission.follow.is_some(),
            found_no_way: false,
            mission: mission.clone(),
            goal_since: Time::ZERO,
            anchor: None,
            plans_at_anchor: 0,
            has_changed: false,
        }
    }

    /// The rules of the mission.
    pub fn mission(&self) -> &Mission {
        &self.mission
    }

    /// Where the robot is going.
    pub fn goal(&self) -> Option<&Goal> {
        self.goals.front()
    }

    /// Changes the state and says so.
    pub fn enter(&mut self, now: Time, to: State, events: &mut Vec<Event>) {
        if self.state != to {
            events.push(Event { stamp: now, kind: EventKind::State { from: self.state, to } });
            self.state = to;
        }
    }

    /// Takes goals on.
    pub fn go(&mut self, now: Time, goals: Vec<Goal>, events: &mut Vec<Event>) {
        self.goals = goals.into();
        self.outcome = None;
        self.enter(now, State::Navigating, events);
        self.begin_goal(now, events);
    }

    fn begin_goal(&mut self, now: Time, events: &mut Vec<Event>) {
        self.path = None;
        self.memory.clear();
        self.count_anew(now, events);
    }

    /// Takes on a goal that moves. The path and what was found on the way hold until a new path comes; for the next
    /// position of a trail (`is_next`), tries and time are counted anew.
    pub fn lead(&mut self, now: Time, goal: Goal, is_next: bool, events: &mut Vec<Event>) {
        let Some(present) = self.goals.front_mut().filter(|_| self.state == State::Navigating) else {
            return self.go(now, vec![goal], events);
        };
        *present = goal;
        self.needs_plan = true;
        if is_next {
            self.count_anew(now, events);
        }
    }

    fn count_anew(&mut self, now: Time, events: &mut Vec<Event>) {
        self.goal_since = now;
        self.needs_plan = true;
        self.replans = 0;
        self.has_forgotten = false;
        self.patience.renew();
        self.anchor = None;
        self.plans_at_anchor = 0;
        if let Some(goal) = self.goals.front() {
            events.push(Event { stamp: now, kind: EventKind::GoalAccepted(goal.position) });
        }
    }

    /// Drops all goals.
    pub fn stop(&mut self) -> Vec<Goal> {
        self.path = None;
        self.needs_plan = false;
        self.patience.renew();
        self.memory.clear();
        self.goals.drain(..).collect()
    }

    /// Looks at time and place: a goal may have taken too long, a waypoint may be near enough to go on.
    pub fn watch(&mut self, now: Time, position: Point2, events: &mut Vec<Event>) {
        if self.state != State::Navigating {
            return;
        }
        if self.mission.goal_timeout_s.is_some_and(|limit| now - self.goal_since > Span::from_secs(limit)) {
            events.push(Event { stamp: now, kind: EventKind::TimedOut });
            return self.end(now, Outcome::TimedOut, events);
        }
        let Some(goal) = self.goals.front() else { return };
        let near = (goal.position - position).norm() < self.mission.switch_radius_m;
        if near && self.goals.len() > 1 {
            self.arrive(now, events);
        }
    }

    /// The present goal is reached; on to the next.
    pub fn arrive(&mut self, now: Time, events: &mut Vec<Event>) {
        if let Some(goal) = self.goals.pop_front() {
            events.push(Event { stamp: now, kind: EventKind::Arrived(goal.position) });
        }
        if self.goals.is_empty() {
            return self.end(now, Outcome::Arrived, events);
        }
        self.begin_goal(now, events);
    }

    /// No goals any more, and this is why.
    pub fn end(&mut self, now: Time, outcome: Outcome, events: &mut Vec<Event>) {
        if let Outcome::Unreachable(reason) | Outcome::Stuck(reason) | Outcome::PlannerFailed(reason) =
            &outcome
        {
            events.push(Event { stamp: now, kind: EventKind::Unreachable { reason: reason.clone() } });
        }
        if self.is_following && matches!(outcome, Outcome::Unreachable(_)) {
            (self.path, self.needs_plan, self.found_no_way) = (None, false, true);
            return;
        }
        self.stop();
        self.outcome = Some(outcome);
        self.enter(now, State::Waiting, events);
    }

    /// The avoider cannot go on: the way is closed here.
    pub fn blocked(&mut self, now: Time, position: Point2, events: &mut Vec<Event>) {
        if self.anchor.is_none_or(|anchor| (anchor - position).norm() >= Self::PROGRESS_M) {
            self.anchor = Some(position);
            self.plans_at_anchor = 0;
            self.has_changed = false;
        }
        self.plans_at_anchor += 1;
        let n = if self.has_changed { Self::PLANS_AMONG_PEOPLE } else { Self::PLANS_WITHOUT_PROGRESS };
        if self.plans_at_anchor > n {
            let reason = format!("{n} new plans without {:.2} m of progress", Self::PROGRESS_M);
            return self.end(now, Outcome::Stuck(reason), events);
        }
        self.replan(now, events);
    }

    /// The path is of no use any more: another one is asked for, if the mission allows that.
    pub fn replan(&mut self, now: Time, events: &mut Vec<Event>) {
        self.path = None;
        self.replans += 1;
        if self.mission.max_replans.is_some_and(|most| self.replans > most) {
            let reason = format!("more than the {} new plans that the mission allows", self.replans - 1);
            return self.end(now, Outcome::Stuck(reason), events);
        }
        self.needs_plan = true;
    }

    /// A sensor saw that something is gone: a plan from the same spot may be another one.
    pub fn note_change(&mut self) {
        self.has_changed = true;
    }

    /// A path to follow.
    pub fn follow(&mut self, path: Path) {
        self.path = Some(path);
        self.patience.renew();
        self.path_number += 1;
    }

    /// The relocalizer has no answer.
    pub fn not_found(&mut self, now: Time, events: &mut Vec<Event>) {
        events.push(Event { stamp: now, kind: EventKind::NotFound });
        self.enter(now, State::Lost, events);
    }

    /// The estimate's status changed what can be done. Returns goals that were given up because the robot is lost.
    pub fn on_status(&mut self, now: Time, status: Status, events: &mut Vec<Event>) -> Vec<Goal> {
        match (self.state, status) {
            // Only a SLAM is asked in `Lost`, since it goes on with its map.
            (State::Localizing | State::Lost, Status::Tracking) => {
                events.push(Event { stamp: now, kind: EventKind::Relocalized });
                self.enter(now, State::Waiting, events);
                Vec::new()
            }
            (State::Navigating | State::Waiting, Status::Lost) => {
                let goals = self.stop();
                self.enter(now, State::Lost, events);
                goals
            }
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn goal(x: f64) -> Goal {
        Goal { position: Point2::new(x, 0.0), yaw_rad: None }
    }

    #[test]
    fn waypoints_are_passed_within_the_switch_radius_but_the_last_is_reached() {
        let mission = Mission { switch_radius_m: 0.5, ..Mission::default() };
        let (mut navigator, mut events) = (Navigator::new(&mission), Vec::new());
        navigator.go(Time::ZERO, vec![goal(1.0), goal(5.0)], &mut events);
        navigator.watch(Time(1), Point2::new(0.6, 0.0), &mut events);
        assert_eq!(navigator.goal(), Some(&goal(5.0)));
        navigator.watch(Time(2), Point2::new(4.9, 0.0), &mut events);
        assert_eq!(navigator.outcome, None);
        navigator.arrive(Time(3), &mut events);
        assert_eq!((navigator.outcome, navigator.state), (Some(Outcome::Arrived), State::Waiting));
    }

    #[test]
    fn one_waypoint_is_passed_a_step_and_only_nearer_than_the_switch_radius() {
        let mission = Mission { switch_radius_m: 0.7, ..Mission::default() };
        let (mut navigator, mut events) = (Navigator::new(&mission), Vec::new());
        navigator.go(Time::ZERO, vec![goal(1.0), goal(1.2), goal(1.4), goal(1.5)], &mut events);
        // Exactly at the radius (0.7 m from 1.0 has no rounding here) is not below it.
        navigator.watch(Time(1), Point2::new(1.0, 0.7), &mut events);
        assert_eq!(navigator.goals.len(), 4);
        for (time, left) in [(2, 3), (3, 2), (4, 1), (5, 1), (6, 1)] {
            navigator.watch(Time(time), Point2::new(1.3, 0.0), &mut events);
            assert_eq!(navigator.goals.len(), left, "all are near, and one goes each time but the last");
        }
        let passed = events.iter().filter(|event| matches!(event.kind, EventKind::Arrived(_)));
        assert_eq!(passed.map(|event| event.stamp.0).collect::<Vec<_>>(), [2, 3, 4]);
        assert!(navigator.outcome.is_none() && navigator.needs_plan);
    }

    #[test]
    fn five_plans_on_one_spot_are_enough() {
        let (mut navigator, mut events) = (Navigator::new(&Mission::default()), Vec::new());
        navigator.go(Time::ZERO, vec![goal(9.0)], &mut events);
        for k in 0..5 {
            navigator.blocked(Time(k), Point2::new(0.01 * k as f64, 0.0), &mut events);
            assert!(navigator.needs_plan, "plan {k}");
        }
        navigator.blocked(Time(9), Point2::origin(), &mut events);
        assert!(matches!(navigator.outcome, Some(Outcome::Stuck(_))));
    }

    #[test]
    fn where_things_come_and_go_there_are_more_plans_on_one_spot_but_not_for_ever() {
        let (mut navigator, mut events) = (Navigator::new(&Mission::default()), Vec::new());
        navigator.go(Time::ZERO, vec![goal(9.0)], &mut events);
        for k in 0..20 {
            navigator.blocked(Time(k), Point2::origin(), &mut events);
            navigator.note_change();
            assert!(navigator.needs_plan && navigator.outcome.is_none(), "plan {k}");
        }
        navigator.blocked(Time(20), Point2::new(0.05, 0.0), &mut events);
        assert!(matches!(navigator.outcome, Some(Outcome::Stuck(_))));
    }

    #[test]
    fn a_lost_robot_hands_its_goals_back() {
        let (mut navigator, mut events) = (Navigator::new(&Mission::default()), Vec::new());
        navigator.go(Time::ZERO, vec![goal(1.0), goal(2.0)], &mut events);
        assert_eq!(navigator.on_status(Time(1), Status::Lost, &mut events).len(), 2);
        assert_eq!(navigator.state, State::Lost);
    }
}
