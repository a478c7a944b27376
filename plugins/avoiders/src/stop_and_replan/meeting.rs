//! What the robot does about people while it drives ahead.

use super::front_watch::Scene;
use super::people::encounter::{Encounter, Manner, Ways};
use super::people::{People, PeopleTuning};
use super::turn_then_go::TurnThenGo;
use rumbo_core::frames::{Point2, Twist};
use rumbo_core::time::{Span, Time};

/// Numbers of meetings, meters and seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeetingTuning {
    /// The watch for people.
    pub people: PeopleTuning,
    /// The robot backs off no farther than this.
    pub back_off_m: f64,
    /// So fast, m/s.
    pub back_m_s: f64,
}

/// People, and the robot's ways to go on.
#[derive(Debug)]
pub struct Meeting {
    /// Who walks.
    pub people: People,
    tuning: MeetingTuning,
    n_steps: usize,
    stood_since: Option<Time>,
    /// Since when something touches the robot, and how long it may be somebody who walks, seconds.
    touched: Option<(Time, f64)>,
    go: Vec<Point2>,
    slow: Vec<Point2>,
    back: Vec<Point2>,
}

/// What follows for the wheels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Advice {
    /// As they would do anyhow.
    GoOn,
    /// Like this instead.
    Drive(Twist),
    /// Somebody has been in the way for long: another path is needed.
    AnotherPath,
}

impl Meeting {
    /// Slower than this is standing, m/s.
    const STANDING_M_S: f64 = 0.01;
    /// Brakes and bumpers take a moment: a robot that has stood for so long did not touch anything by itself.
    const STOOD: Span = Span(500_000_000);
    /// Who walks into a robot that drives, or is in its way, is gone after so long, seconds; a thing stays.
    const LETS_GO_S: f64 = 1.5;

    /// Nobody met yet.
    pub fn new(tuning: MeetingTuning) -> Meeting {
        let n_steps = (tuning.people.encounter.horizon_s / Encounter::STEP_S).ceil() as usize;
        Meeting {
            people: People::new(tuning.people),
            tuning,
            n_steps,
            stood_since: None,
            touched: None,
            go: Vec::with_capacity(n_steps),
            slow: Vec::with_capacity(n_steps),
            back: Vec::with_capacity(n_steps),
        }
    }

    /// Whether what touches the robot came to it: the robot has been standing for a while, with `twist`, or people are about
    /// and it lets go by itself. Who stays longer than that does not walk.
    pub fn is_touched_by_somebody(&mut self, now: Time, twist: Twist, is_touched: bool) -> bool {
        let stands = twist.speed_m_s() < Self::STANDING_M_S;
        let stood = self.stood_since.filter(|since| now - *since >= Self::STOOD).is_some();
        self.stood_since = if stands { self.stood_since.or(Some(now)) } else { None };
        if !is_touched {
            self.touched = None;
            return false;
        }
        let longest_s = match (stood, self.people.are_about(now)) {
            (true, _) => self.tuning.people.patience_s,
            (false, true) => Self::LETS_GO_S,
            (false, false) => 0.0,
        };
        // As it was when the touch began.
        let (since, longest_s) = *self.touched.get_or_insert((now, longest_s));
        (now - since).as_secs() < longest_s
    }

    /// What to do instead of driving ahead with `twist`.
    pub fn advise(&mut self, twist: Twist, control: &TurnThenGo, scene: &Scene<'_>) -> Advice {
        self.people.look(scene.now);
        if self.people.walkers().is_empty() {
            self.people.rest(scene.now);
            return Advice::GoOn;
        }
        let here = Point2::from(scene.map_from_base.translation.vector);
        let yaw_rad = scene.map_from_base.rotation.angle();
        control.forecast((here, yaw_rad), Encounter::STEP_S, self.n_steps, 1.0, &mut self.go);
        control.forecast((here, yaw_rad), Encounter::STEP_S, self.n_steps, Encounter::SLOW, &mut self.slow);
        self.back_off(here, yaw_rad, control.done_m());
        let ways = Ways { go: &self.go, slow: &self.slow, back: &self.back };
        match self.people.meet(scene, &ways) {
            Manner::Go => Advice::GoOn,
            Manner::Slow => Advice::Drive(twist.scaled(Encounter::SLOW)),
            _ if self.people.is_tired(scene) => Advice::AnotherPath,
            Manner::Wait => Advice::Drive(Twist::ZERO),
            Manner::Back => Advice::Drive(Twist::new(-self.tuning.back_m_s, 0.0)),
        }
    }

    /// Back along the piece of which `done_m` is done: that floor was free.
    fn back_off(&mut self, here: Point2, yaw_rad: f64, done_m: f64) {
        let back_m_s = self.tuning.back_m_s;
        let most_m = self.tuning.back_off_m.min(done_m);
        self.back.clear();
        if most_m < back_m_s * Encounter::STEP_S {
            return;
        }
        let behind = -nalgebra::Vector2::new(yaw_rad.cos(), yaw_rad.sin());
        let way_m = |step: usize| (back_m_s * Encounter::STEP_S * (step + 1) as f64).min(most_m);
        self.back.extend((0..self.n_steps).map(|step| here + behind * way_m(step)));
    }
}
