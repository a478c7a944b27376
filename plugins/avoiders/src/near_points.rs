//! Everything near, whatever saw it, as points in the base frame: depth cameras, laser scanners and sonars alike.
//!
//! Points are kept in the odometer's frame: between two readings the robot's own motion moves them, and a correction of
//! the estimate does not. What left a sensor's view is handed to a [`ShortMemory`].

use crate::short_memory::ShortMemory;
use crate::view::View;
use rumbo_core::frames::{Point2, Pose2};
use rumbo_core::messages::{Observation, ObservationKind, SensorId};
use rumbo_core::stages::AvoidError;
use rumbo_core::time::{Span, Time};

/// A point near the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearPoint {
    /// Where, in the base frame of now.
    pub in_base: Point2,
    /// When it was seen.
    pub stamp: Time,
    /// No sensor looks there any more.
    pub is_remembered: bool,
}

/// What counts as near, and for how long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearTuning {
    /// Points farther than this from the base are of no interest, meters.
    pub keep_m: f64,
    /// Points of clouds lower and higher than this over the floor are no obstacles, meters.
    pub band_m: [f64; 2],
    /// A sensor without a reading for so long is silent.
    pub stale_after: Span,
    /// What left the view is kept so long; zero for a robot that forgets at once.
    pub memory: Span,
}

/// The last reading of one sensor.
#[derive(Debug)]
struct Source {
    sensor: SensorId,
    kind: ObservationKind,
    stamp: Time,
    is_blind: bool,
    odom_points: Vec<Point2>,
}

/// The last readings of all sensors, and what was seen before.
#[derive(Debug)]
pub struct NearPoints {
    tuning: NearTuning,
    sources: Vec<Source>,
    memory: ShortMemory,
    view: View,
    /// What is seen, and then what is remembered.
    points: Vec<NearPoint>,
    n_seen: usize,
    waiting_since: Option<Time>,
}

/// Whether the readings are good enough to drive by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sight {
    /// Every sensor that ever gave a reading still does.
    Clear,
    /// A sensor says that it sees nothing, or none has said anything yet.
    Blind,
}

impl NearPoints {
    /// Room for points that is taken up front.
    const ROOM: usize = 1024;

    /// Nothing seen yet.
    pub fn new(tuning: NearTuning) -> NearPoints {
        NearPoints {
            tuning,
            sources: Vec::with_capacity(8),
            memory: ShortMemory::new(tuning.memory, tuning.keep_m),
            view: View::new(tuning.band_m),
            points: Vec::with_capacity(Self::ROOM),
            n_seen: 0,
            waiting_since: None,
        }
    }

    /// Takes over a reading; `odom_from_base` is where the base was when it was seen.
    pub fn see(&mut self, observation: &Observation, odom_from_base: &Pose2) {
        let (kind, stamp) = (observation.data.kind(), observation.stamp);
        let keep_m = self.tuning.keep_m;
        let Some(viewed) = self.view.look(observation) else { return };
        let Some(source) = source_of(&mut self.sources, observation.sensor, kind, stamp) else { return };
        source.is_blind = !observation.valid;
        if source.is_blind {
            return;
        }
        let base_from_odom = odom_from_base.inverse();
        let is_sound = kind == ObservationKind::RangeRing;
        self.memory.look(stamp, &viewed, &base_from_odom, is_sound);
        for point in source.odom_points.drain(..) {
            self.memory.leave(point, source.stamp, &viewed, &base_from_odom, is_sound);
        }
        source.stamp = stamp;
        viewed.each_point(|in_base| {
            if in_base.coords.norm() <= keep_m {
                source.odom_points.push(odom_from_base * in_base);
            }
        });
    }

    /// Puts everything into the base frame of now.
    pub fn settle(&mut self, now: Time, odom_from_base: &Pose2) {
        let base_from_odom = odom_from_base.inverse();
        self.points.clear();
        for source in &self.sources {
            let seen = source.odom_points.iter().map(|point| base_from_odom * point);
            let stamp = source.stamp;
            self.points.extend(seen.map(|in_base| NearPoint { in_base, stamp, is_remembered: false }));
        }
        self.memory.age(now, &base_from_odom);
        self.points.extend(self.memory.points(&base_from_odom, true));
        self.n_seen = self.points.len();
        self.points.extend(self.memory.points(&base_from_odom, false));
    }

    /// Everything near, in the base frame of the last [`settle`](Self::settle): what sensors see, and what is remembered
    /// where `with_memory` says so.
    pub fn points(&self, with_memory: bool) -> &[NearPoint] {
        let n = if with_memory { self.points.len() } else { self.n_seen };
        self.points.get(..n).unwrap_or_default()
    }

    /// Whether the robot may drive by what it sees.
    pub fn sight(&mut self, now: Time) -> Result<Sight, AvoidError> {
        let stale_after = self.tuning.stale_after;
        let oldest = self.sources.iter().min_by_key(|source| source.stamp);
        if oldest.is_some_and(|source| now - source.stamp <= stale_after) {
            self.waiting_since = None;
            let is_blind = self.sources.iter().any(|source| source.is_blind);
            return Ok(if is_blind { Sight::Blind } else { Sight::Clear });
        }
        let since = *self.waiting_since.get_or_insert(now);
        if now - since <= stale_after {
            return Ok(Sight::Blind);
        }
        let kind = oldest.map_or("point cloud, laser scan or range ring", |source| source.kind.name());
        let age_s = (now - oldest.map_or(since, |source| source.stamp)).as_secs();
        Err(AvoidError::NoReading { kind, age_s })
    }
}

/// The sensor's last reading, where the new one is newer.
fn source_of(
    sources: &mut Vec<Source>,
    sensor: SensorId,
    kind: ObservationKind,
    stamp: Time,
) -> Option<&mut Source> {
    let at = sources.iter().position(|source| source.sensor == sensor && source.kind == kind);
    let at = at.unwrap_or_else(|| {
        // A sensor that is blind from the beginning is so since then.
        let before = Time(stamp.0.saturating_sub(1));
        let odom_points = Vec::with_capacity(NearPoints::ROOM);
        sources.push(Source { sensor, kind, stamp: before, is_blind: false, odom_points });
        sources.len() - 1
    });
    sources.get_mut(at).filter(|source| source.stamp < stamp)
}

#[cfg(test)]
mod tests;
