//! The seats that say where the robot is: localizer or SLAM, and the relocalizer for a lost robot.

use super::events::Event;
use super::ring::{Filter, Ring};
use super::seat::Seat;
use crate::map::Map;
use crate::messages::{Check, Estimate, Prior, Seen, Status, Wish};
use crate::stages::{Cx, LocalizeError, Localizer, Slam};
use crate::time::Time;

/// Who finds the robot.
pub(super) enum Finder {
    /// On a map that others build.
    Localizer(Box<dyn Localizer>),
    /// On a map of its own.
    Slam {
        /// The plugin.
        slam: Box<dyn Slam>,
        /// It was started: from now on its map stays.
        has_begun: bool,
    },
}

impl Finder {
    /// A localizer begins anew whenever it is told something; a SLAM begins once, and keeps its map from then on.
    fn start(&mut self, prior: &Prior, map: &mut Map) -> Result<(), String> {
        match self {
            Finder::Localizer(localizer) => localizer.start(prior, map).map_err(|e| e.to_string()),
            Finder::Slam { slam, has_begun: true } => slam.relocate(prior, map).map_err(|e| e.to_string()),
            Finder::Slam { slam, has_begun } => {
                slam.start(prior, map).map_err(|e| e.to_string())?;
                *has_begun = true;
                Ok(())
            }
        }
    }

    /// It builds its map at present: whatever it says of the robot, it must see everything.
    pub fn is_mapping(&self) -> bool {
        matches!(self, Finder::Slam { has_begun: true, .. })
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &mut Map) -> Result<Estimate, String> {
        let estimate = match self {
            Finder::Localizer(localizer) => localizer.update(cx, seen, map).map_err(|e| e.to_string())?,
            Finder::Slam { slam, .. } => slam.update(cx, seen, map).map_err(|e| e.to_string())?,
        };
        estimate.check().map_err(|e| e.to_string())?;
        Ok(estimate)
    }
}

/// The seats and their last word.
pub(super) struct Localization {
    /// The main seat.
    pub finder: Seat<Finder>,
    /// For a lost robot.
    pub relocalizer: Option<Seat<Box<dyn Localizer>>>,
    /// The last estimate.
    pub estimate: Estimate,
}

impl Localization {
    /// Begins anew, or tells a SLAM that has begun where the robot is. Returns whether that worked.
    pub fn start(
        &mut self,
        prior: &Prior,
        map: &mut Map,
        ring: &Ring,
        now: Time,
        events: &mut Vec<Event>,
    ) -> bool {
        let result =
            prior.check().map_err(|e| e.to_string()).and_then(|()| self.finder.stage.start(prior, map));
        self.finder.settle(result, ring.cursor(), now, events).is_some()
    }

    /// Begins to look for a robot that may be anywhere: with the relocalizer if there is one.
    pub fn search(&mut self, map: &mut Map, ring: &Ring, now: Time, events: &mut Vec<Event>) -> bool {
        let Some(seat) = &mut self.relocalizer else {
            return self.start(&Prior::Unknown, map, ring, now, events);
        };
        let result = seat.stage.start(&Prior::Unknown, map);
        seat.settle(result, ring.cursor(), now, events).is_some()
    }

    /// One update of the seat whose turn it is; a wish for motion is a failure where nothing drives. Returns whether there is a new estimate.
    pub fn update(
        &mut self,
        searching: bool,
        not_actuated: bool,
        cx: &mut Cx<'_>,
        ring: &mut Ring,
        map: &mut Map,
        events: &mut Vec<Event>,
    ) -> bool {
        let now = cx.now;
        if let (true, Some(seat)) = (searching, &mut self.relocalizer) {
            seat.report_loss(ring, now, events);
            let read = ring.cursor();
            let seen = ring.seen(seat.cursor, Filter::Public);
            let checked = |estimate: Estimate| match estimate.check() {
                Ok(()) => movable(estimate, not_actuated),
                Err(fault) => Err(fault.to_string()),
            };
            let result = seat.stage.update(cx, seen, map).map_err(|e| e.to_string()).and_then(checked);
            let Some(estimate) = seat.settle(result, read, now, events) else { return false };
            return self.adopt(estimate, map, ring, now, events);
        }
        self.finder.report_loss(ring, now, events);
        let read = ring.cursor();
        let seen = ring.seen(self.finder.cursor, Filter::Public);
        let result = self.finder.stage.update(cx, seen, map);
        let result = result.and_then(|estimate| movable(estimate, searching && not_actuated));
        let Some(estimate) = self.finder.settle(result, read, now, events) else { return false };
        self.estimate = estimate;
        true
    }

    /// Takes the relocalizer's word; once it is sure, the main seat goes on from there.
    fn adopt(
        &mut self,
        mut estimate: Estimate,
        map: &mut Map,
        ring: &Ring,
        now: Time,
        events: &mut Vec<Event>,
    ) -> bool {
        if estimate.status == Status::Tracking {
            let odom_from_base = estimate.map_from_odom.inverse() * estimate.map_from_base;
            let prior = Prior::Pose {
                map_from_base: estimate.pose2(),
                odom_from_base: crate::frames::flatten(&odom_from_base),
                covariance: estimate.covariance2(),
            };
            if !self.start(&prior, map, ring, now, events) {
                estimate.status = Status::Converging;
            }
        }
        self.estimate = estimate;
        true
    }

    /// The seat whose turn it is has failed so often in a row: its name and last error.
    pub fn failed(&self, searching: bool, at_least: u32) -> Option<(&str, &str)> {
        match &self.relocalizer {
            Some(seat) if searching => seat.failed(at_least),
            _ => self.finder.failed(at_least),
        }
    }
}

/// An estimate whose wish can be carried out.
fn movable(estimate: Estimate, not_actuated: bool) -> Result<Estimate, String> {
    match &estimate.wish {
        Some(wish @ (Wish::TurnBy(_) | Wish::MoveBy(_))) if not_actuated => {
            Err(LocalizeError::NeedsMotion { wish: format!("{wish:?}") }.to_string())
        }
        _ => Ok(estimate),
    }
}
