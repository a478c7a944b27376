//! The last third of a step: from the estimate through planner, avoider and guard to the wheels.

use super::at_work::Place;
use super::events::{Event, EventKind};
use super::guard;
use super::order::State;
use super::planning;
use super::ring::Filter;
use super::step::Engine;
use super::timing::Part;
use crate::frames::{Twist, flatten};
use crate::messages::{Check, Command};
use crate::stages::{AvoidInput, Cx, Drove, Steering, WorldError};
use std::time::Instant;

impl Engine {
    /// ─► Planner: a path where one is needed, from a planner that works beside the step.
    pub(super) fn plan(&mut self) {
        let clock = Instant::now();
        let map_from_base = self.map_from_base();
        self.follow_person();
        if self.navigator.state == State::Navigating {
            self.look_through_obstacles();
            self.navigator.watch(self.now, map_from_base.translation.vector.into(), &mut self.events);
        }
        self.watch_for_stalls();
        let at = planning::Situation { now: self.now, map_from_base, map: &self.map, trace: &self.trace };
        self.planning.update(&mut self.navigator, &mut self.schedule, &at, &mut self.events);
        self.times.add(Part::Planner, clock);
    }

    fn look_through_obstacles(&mut self) {
        let map_from_odom = flatten(&self.localization.estimate.map_from_odom);
        let mut n_obstacles = 0;
        for observation in self.ring.newest_unreplaced(self.n_new) {
            let map_from_base = map_from_odom * self.track.at(observation.stamp);
            n_obstacles += self.navigator.memory.look(observation, &map_from_base, &mut self.out);
        }
        if n_obstacles > 0 {
            self.navigator.note_change();
            let kind = EventKind::Forgot { n_obstacles, reason: "a sensor sees through them" };
            self.events.push(Event { stamp: self.now, kind });
        }
    }

    /// ─► Avoider: what to do until the next control tick.
    pub(super) fn steer(&mut self) -> Twist {
        let clock = Instant::now();
        let twist = match self.navigator.state {
            State::Localizing => self.wish.steer(self.track.now()),
            State::Navigating if self.navigator.path.is_some() => self.ask_avoider(),
            State::Waiting if self.script.is_some() => self.drive_by_script(),
            State::Waiting if self.wanders => self.ask_avoider(),
            _ => Twist::ZERO,
        };
        self.times.add(Part::Avoider, clock);
        twist
    }

    fn drive_by_script(&mut self) -> Twist {
        let Some(script) = &mut self.script else { return Twist::ZERO };
        script.steer(self.now, &mut self.navigator, &mut self.events)
    }

    fn ask_avoider(&mut self) -> Twist {
        let map_from_base = self.map_from_base();
        let Some(seat) = &mut self.avoider else { return Twist::ZERO };
        self.at_work.enter(Place::Avoider);
        seat.report_loss(&self.ring, self.now, &mut self.events);
        let read = self.ring.cursor();
        let input = AvoidInput {
            map_from_base,
            estimate: &self.localization.estimate,
            twist: self.track.twist(),
            seen: self.ring.seen(seat.cursor, Filter::Public),
            map: &self.map,
            grid: self.planning.grid.get().or(self.map.grid.as_ref()),
            path: self.navigator.path.as_ref(),
            path_number: self.navigator.path_number,
            arrival_radius_m: self.navigator.mission().arrival_radius_m,
            obstacles: self.navigator.memory.obstacles(),
            robot: &self.robot,
        };
        let result = seat.stage.steer(&mut Cx { now: self.now, trace: &self.trace }, &input);
        let checked = result.map_err(|e| e.to_string()).and_then(|steering| match &steering {
            Steering::Blocked { obstacles } => {
                let fault = obstacles.iter().find_map(|obstacle| obstacle.check().err());
                fault.map_or(Ok(steering), |fault| Err(fault.to_string()))
            }
            _ => Ok(steering),
        });
        let position = map_from_base.translation.vector.into();
        match seat.settle(checked, read, self.now, &mut self.events) {
            Some(Steering::Drive(twist)) => return twist,
            Some(Steering::Arrived) => self.end_path(),
            Some(Steering::Blocked { obstacles }) => {
                let n_obstacles = obstacles.len();
                self.events.push(Event { stamp: self.now, kind: EventKind::Blocked { n_obstacles } });
                self.navigator.memory.add(&obstacles, self.map.grid.as_ref());
                self.navigator.blocked(self.now, position, &mut self.events);
            }
            None => {}
        }
        Twist::ZERO
    }

    /// ─► Guard: no plugin passes it.
    pub(super) fn guard(&mut self, wanted: Twist) -> Twist {
        let clock = Instant::now();
        let situation = guard::Situation {
            now: self.now,
            odom_from_base: self.track.now_at(self.now),
            stage_failed: self.failing_stage(1).is_some(),
            deadline_missed: self.late > self.control_period,
        };
        let twist = self.guard.limit(wanted, &situation, &mut self.events);
        self.times.add(Part::Guard, clock);
        twist
    }

    /// ─► World: the wheels obey until the next command.
    pub(super) fn drive(&mut self, twist: Twist) -> Result<(), WorldError> {
        let clock = Instant::now();
        self.at_work.enter(Place::World);
        self.command = Command { stamp: self.now, twist };
        let drove = self.world.drive(&self.command)?;
        self.not_actuated = drove == Drove::NotActuated;
        self.times.add(Part::World, clock);
        Ok(())
    }
}
