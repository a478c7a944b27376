//! The one door for commands: what the pipeline itself orders, and how orders are obeyed or refused.

use super::events::{Event, EventKind};
use super::inbox::Inbox;
use super::localization::Finder;
use super::order::{Order, State};
use super::step::Engine;
use crate::frames::{Point2, pose2};
use crate::map::Map;
use crate::messages::{Check, Estimate, Goal, Prior};
use crate::pipeline::{InitialPose, Pipeline, Waypoint, WellKnownPose};
use crate::stages::World;
use nalgebra::{Matrix3, Vector3};

impl Engine {
    /// The orders that a pipeline gives by itself at the start.
    pub(super) fn first_orders(pipeline: &Pipeline, world: &dyn World) -> Vec<Order> {
        let mission = &pipeline.mission;
        let deviation = Vector3::new(
            mission.initial_deviation_m,
            mission.initial_deviation_m,
            mission.initial_deviation_deg.to_radians(),
        );
        let covariance = Matrix3::from_diagonal(&deviation.component_mul(&deviation));
        let start = match mission.initial_pose {
            InitialPose::Pose { x_m, y_m, yaw_deg } => Some(pose2(x_m, y_m, yaw_deg.to_radians())),
            InitialPose::WellKnown(WellKnownPose::World) => world.start(),
            InitialPose::WellKnown(WellKnownPose::Unknown) => None,
        };
        vec![start.map_or(Order::Localize, |map_from_base| Order::SetPose { map_from_base, covariance })]
    }

    /// The waypoints as goals.
    pub(super) fn mission_goals(pipeline: &Pipeline) -> Vec<Goal> {
        let goal = |w: &Waypoint| Goal {
            position: Point2::new(w.x_m, w.y_m),
            yaw_rad: w.yaw_deg.map(f64::to_radians),
        };
        pipeline.mission.waypoints.iter().map(goal).collect()
    }

    /// Takes an order; it is obeyed, or refused with an event, in the next step.
    pub fn command(&mut self, order: Order) {
        self.given.push(order.clone());
        self.orders.push(order);
    }

    /// From now on takes orders from this box, too.
    pub fn listen(&mut self, inbox: Inbox) {
        self.inbox = inbox;
    }

    /// Obeys what was ordered, and what the mission itself wants next.
    pub(super) fn obey(&mut self) {
        if self.navigator.state == State::NoMap && self.needed_layers.iter().all(|layer| self.map.has(*layer))
        {
            self.navigator.enter(self.now, State::Lost, &mut self.events);
        }
        self.inbox.empty().into_iter().for_each(|order| self.command(order));
        self.obeyed.clear();
        self.obeyed.append(&mut self.given);
        if !self.orders.is_empty() {
            let orders = std::mem::take(&mut self.orders);
            orders.into_iter().for_each(|order| self.obey_one(order));
        }
        if self.pending.is_empty() && self.following.is_none() {
            return;
        }
        match self.navigator.state {
            // Where the person was when the robot got lost is no goal any more.
            State::Waiting if self.following.is_some() => self.pending.clear(),
            State::Waiting => {
                let goals = std::mem::take(&mut self.pending);
                self.obey_one(Order::GoTo(goals));
            }
            State::Lost => self.obey_one(Order::Localize),
            _ => {}
        }
    }

    fn obey_one(&mut self, order: Order) {
        let state = self.navigator.state;
        let is_sound = match &order {
            Order::GoTo(goals) => goals.iter().all(|goal| goal.check().is_ok()),
            Order::PersonAt(person) => person.check().is_ok() && self.following.is_some(),
            // A SLAM makes the map itself: another one would be overwritten by its next update.
            Order::SetMap(_) => !matches!(self.localization.finder.stage, Finder::Slam { .. }),
            _ => true,
        };
        if !order.is_allowed(state) || !is_sound {
            let kind = EventKind::Refused { command: order.name(), state };
            return self.events.push(Event { stamp: self.now, kind });
        }
        match order {
            Order::GoTo(goals) => {
                self.has_mission = true;
                self.script = None;
                self.follow_nobody();
                self.navigator.go(self.now, goals, &mut self.events);
            }
            Order::SetPose { map_from_base, covariance } => {
                let prior = Prior::Pose { map_from_base, odom_from_base: self.track.now(), covariance };
                let was_mapping = self.localization.finder.stage.is_mapping();
                let (map, ring) = (&mut self.map, &self.ring);
                let started = self.localization.start(&prior, map, ring, self.now, &mut self.events);
                self.settle_search(started, was_mapping, State::Waiting);
                if started {
                    let odom = self.track.now();
                    self.localization.estimate = Estimate::planar(self.now, map_from_base, odom, covariance);
                }
            }
            Order::Localize => {
                let was_mapping = self.localization.finder.stage.is_mapping();
                let (map, ring) = (&mut self.map, &self.ring);
                let started = self.localization.search(map, ring, self.now, &mut self.events);
                self.settle_search(started, was_mapping, State::Localizing);
            }
            Order::SetMap(map) => self.set_map(*map),
            Order::PersonAt(person) => {
                if let Some(following) = &mut self.following {
                    following.hear(self.now, self.now, &person, &mut self.events);
                }
            }
            Order::Cancel => {
                self.follow_nobody();
                self.navigator.stop();
                self.wish.clear();
                let to = if state == State::Localizing { State::Lost } else { State::Waiting };
                self.navigator.enter(self.now, to, &mut self.events);
            }
            Order::Shutdown => self.navigator.shutdown = true,
        }
    }

    /// Somebody else says from now on where to go.
    fn follow_nobody(&mut self) {
        self.following = None;
        self.navigator.is_following = false;
    }

    /// A SLAM that was told something of no use to it goes on as before, with what it knows.
    fn settle_search(&mut self, started: bool, was_mapping: bool, to: State) {
        if !started && was_mapping {
            return;
        }
        self.wish.clear();
        let to = if started { to } else { State::Lost };
        self.navigator.enter(self.now, to, &mut self.events);
    }

    fn set_map(&mut self, map: Map) {
        let version = self.map.version;
        self.map = map;
        self.map.version = version + 1;
        self.navigator.enter(self.now, State::Lost, &mut self.events);
    }
}
