//! Following a person: where to go next, of positions that keep coming.
//!
//! Valverde Moreno (2015), appendix A.2: the goal is the person's position. Who is faster than the robot leaves a trail of
//! positions behind, and the robot takes them one after the other, oldest first, so that it goes round corners as the
//! person did.

use super::events::{Event, EventKind};
use super::order::State;
use super::step::Engine;
use crate::frames::Point2;
use crate::messages::{Data, Goal, PersonPosition, SensorId};
use crate::pipeline::{Follow, Pipeline};
use crate::time::{Span, Time};
use std::collections::VecDeque;

/// The last that was heard of the person.
#[derive(Debug, Clone, Copy)]
struct News {
    measured: Time,
    heard: Time,
    position: Point2,
    /// Motion of less than this may be noise, meters.
    noise_m: f64,
}

/// What to do next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Next {
    /// Stop: the person is here, or nobody knows where.
    Wait,
    /// Hold still until another plan is due.
    Stand,
    /// Go there: to the next position of the trail, where it is another one than before, or to the person.
    Go {
        /// Where, in the map.
        to: Point2,
        /// It is another position of the trail than before, and no place that has moved.
        is_next: bool,
    },
}

/// What is known of the person, and of the way there.
#[derive(Debug)]
pub struct Following {
    rules: Follow,
    sensor: Option<SensorId>,
    /// Nearer than this is with the person, meters.
    near_m: f64,
    /// A person who moved by less has the same path, meters.
    same_m: f64,
    trail: VecDeque<Point2>,
    /// Where the trail was laid last.
    laid: Option<Point2>,
    news: Option<News>,
    is_lost: bool,
    is_with: bool,
    /// Where the robot was sent, and whether that was part of the trail.
    sent: Option<(Point2, bool)>,
    no_way_until: Option<Time>,
    began: Option<Time>,
}

impl Following {
    /// A deviation that moves by more than this many times itself hardly is noise.
    const NOISE_DEVIATIONS: f64 = 3.0;
    /// A person within reach who steps back by less has not left, meters.
    const LEAST_LEAVE_M: f64 = 0.2;
    /// When there is no way to the person, another plan is asked for after so long, seconds.
    const AGAIN_AFTER_S: f64 = 2.0;
    /// The trail holds so many positions; then the oldest go. Seven kilometers by default.
    const MOST_POSITIONS: usize = 10_000;

    /// What the mission wants; nothing where it follows nobody.
    pub fn of(pipeline: &Pipeline) -> Option<Following> {
        let rules = pipeline.mission.follow.clone()?;
        let place = pipeline.sensors.iter().position(|spec| Some(&spec.stage.name) == rules.sensor.as_ref());
        let sensor = place.map(|idx| SensorId(idx as u16));
        Some(Following::new(rules, sensor, pipeline.mission.arrival_radius_m))
    }

    fn new(rules: Follow, sensor: Option<SensorId>, arrival_radius_m: f64) -> Following {
        Following {
            // An avoider that says that it has arrived goes no nearer.
            near_m: rules.stop_distance_m.max(arrival_radius_m),
            same_m: arrival_radius_m,
            rules,
            sensor,
            trail: VecDeque::new(),
            laid: None,
            news: None,
            is_lost: false,
            is_with: false,
            sent: None,
            no_way_until: None,
            began: None,
        }
    }

    /// Takes in where the person was at `measured`; what is older than the last news says nothing.
    pub fn hear(&mut self, now: Time, measured: Time, person: &PersonPosition, events: &mut Vec<Event>) {
        if self.news.is_some_and(|news| measured < news.measured) {
            return;
        }
        let position = person.position;
        if self.news.is_none() || self.is_lost {
            events.push(Event { stamp: now, kind: EventKind::PersonFound(position) });
            self.is_lost = false;
        }
        let noise_m = Self::NOISE_DEVIATIONS * person.deviation_m;
        self.news = Some(News { measured, heard: now, position, noise_m });
        let spacing_m = self.rules.spacing_m.max(noise_m);
        match self.laid {
            Some(laid) if (position - laid).norm() < spacing_m => {}
            Some(_) => {
                if self.trail.len() == Self::MOST_POSITIONS {
                    self.trail.pop_front();
                }
                self.trail.push_back(position);
                self.laid = Some(position);
            }
            None => self.laid = Some(position),
        }
    }

    /// What to do, for a robot that is here and needs `braking_m` to stand; at most one position of the trail is passed
    /// each time.
    pub fn next(&mut self, now: Time, robot: Point2, braking_m: f64, events: &mut Vec<Event>) -> Next {
        let since = self.news.map_or(*self.began.get_or_insert(now), |news| news.heard);
        let silent_for = now - since;
        if silent_for > Span::from_secs(self.rules.lost_after_s) && !self.is_lost {
            let last = self.news.map(|news| news.position);
            events.push(Event { stamp: now, kind: EventKind::PersonLost { last, silent_for } });
            (self.is_lost, self.is_with) = (true, false);
        }
        let Some(news) = self.news.filter(|_| !self.is_lost) else { return self.wait() };
        let more_m = if self.is_with { news.noise_m.max(Self::LEAST_LEAVE_M) } else { braking_m };
        if (news.position - robot).norm() <= self.near_m + more_m {
            if !self.is_with {
                events.push(Event { stamp: now, kind: EventKind::PersonReached(news.position) });
            }
            self.is_with = true;
            self.trail.clear();
            self.laid = Some(news.position);
            return self.wait();
        }
        self.is_with = false;
        if self.trail.front().is_some_and(|at| (at - robot).norm() < self.rules.pass_radius_m) {
            self.trail.pop_front();
        }
        if self.no_way_until.is_some_and(|until| now < until) {
            return Next::Stand;
        }
        let first = self.trail.front();
        let to = first.copied().unwrap_or(news.position);
        let is_next = match self.sent {
            Some((sent, of_trail)) => of_trail != first.is_some() || (of_trail && sent != to),
            None => true,
        };
        Next::Go { to, is_next }
    }

    fn wait(&mut self) -> Next {
        (self.sent, self.no_way_until) = (None, None);
        Next::Wait
    }

    /// Whether a path to where the robot was sent is one to this place, too.
    fn is_same(&self, to: Point2) -> bool {
        self.sent.is_some_and(|(sent, _)| (sent - to).norm() < self.same_m)
    }

    /// The robot was sent there.
    fn note_sent(&mut self, to: Point2) {
        (self.sent, self.no_way_until) = (Some((to, !self.trail.is_empty())), None);
    }

    /// There is no way to where the robot was sent: the next position of the trail may have one, or the person later.
    fn no_way(&mut self, now: Time) {
        if self.trail.pop_front().is_none() {
            self.no_way_until = Some(now + Span::from_secs(Self::AGAIN_AFTER_S));
        }
        self.sent = None;
    }

    /// The path is over, and the robot as near to where it was sent as the avoider goes.
    fn path_is_over(&mut self) {
        if let Some((_, true)) = self.sent {
            self.trail.pop_front();
        }
        self.sent = None;
    }
}

impl Engine {
    /// The person's newest position, and what follows from it for the navigator.
    pub(super) fn follow_person(&mut self) {
        let robot = self.map_from_base().translation.vector.into();
        let Some(following) = &mut self.following else { return };
        for observation in self.ring.newest(self.n_new) {
            if let Data::Custom(custom) = &observation.data
                && observation.valid
                && following.sensor == Some(observation.sensor)
                && let Some(Ok(person)) = PersonPosition::read(custom)
            {
                following.hear(self.now, observation.stamp, &person, &mut self.events);
            }
        }
        if !matches!(self.navigator.state, State::Waiting | State::Navigating) {
            return following.sent = None;
        }
        if std::mem::take(&mut self.navigator.found_no_way) {
            following.no_way(self.now);
        }
        let braking_m = self.robot.stopping_m(self.track.twist().speed_m_s());
        match following.next(self.now, robot, braking_m, &mut self.events) {
            Next::Wait if self.navigator.state == State::Navigating => {
                self.navigator.stop();
                self.navigator.enter(self.now, State::Waiting, &mut self.events);
            }
            Next::Wait | Next::Stand => {}
            // A plan at work is for where the person was a moment ago; it is waited for, or there would never be one.
            Next::Go { to, is_next } if is_next || !(following.is_same(to) || self.planning.is_at_work()) => {
                following.note_sent(to);
                let goal = Goal { position: to, yaw_rad: None };
                self.navigator.lead(self.now, goal, is_next, &mut self.events);
            }
            Next::Go { .. } => {}
        }
    }

    /// The avoider is at the end of the path.
    pub(super) fn end_path(&mut self) {
        match &mut self.following {
            Some(following) => {
                following.path_is_over();
                self.navigator.path = None;
            }
            None => self.navigator.arrive(self.now, &mut self.events),
        }
    }
}

#[cfg(test)]
mod tests;
