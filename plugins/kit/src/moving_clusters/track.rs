//! One body that is followed.

use super::filter::ConstantVelocity;
use super::past::Past;
use super::{Mover, MoverTuning};
use rumbo_core::frames::Point2;
use rumbo_core::time::{Span, Time};
use std::collections::VecDeque;

/// A body, whether it moves or stands.
#[derive(Debug)]
pub struct Track {
    number: u64,
    filter: ConstantVelocity,
    /// Middles of the segments of the present scan.
    parts: Vec<Point2>,
    /// One part of each of the last scans: a place where it surely was, unlike the middle between two legs.
    places: VecDeque<(Time, Point2)>,
    /// When it was last seen.
    pub seen: Time,
    /// It moves.
    pub is_moving: bool,
    /// It moved at some time.
    pub has_moved: bool,
    n_seen: u32,
    /// Scans in a row that saw through it.
    n_absent: u32,
    /// It has been slow since then.
    slow_since: Option<Time>,
}

impl Track {
    /// Nobody is expected to be faster at first, m/s: standard deviation along an axis.
    const FIRST_DEVIATION_M_S: f64 = 0.8;
    /// So many scans are needed for a velocity.
    const LEAST_SEEN: u32 = 3;
    /// A speed this many times its deviation along an axis may be one; the swap with the air makes it sure.
    const SURE: f64 = 1.0;
    /// Something slower than this part of the least speed stands.
    const SLOW: f64 = 0.75;
    /// Places of so long ago are compared with the present one.
    const AGO: Span = Span(350_000_000);
    /// What light goes through so many times in a row is gone.
    const ABSENT: u32 = 3;

    /// Somebody who is seen for the first time.
    pub fn new(number: u64, stamp: Time, position: Point2, tuning: &MoverTuning) -> Track {
        Track {
            number,
            filter: ConstantVelocity::at(position, tuning.middle_deviation_m, Self::FIRST_DEVIATION_M_S),
            parts: Vec::new(),
            places: VecDeque::new(),
            seen: stamp,
            is_moving: false,
            has_moved: false,
            n_seen: 1,
            n_absent: 0,
            slow_since: None,
        }
    }

    /// Where it is.
    pub fn position(&self) -> Point2 {
        self.filter.position
    }

    /// As others see it.
    pub fn mover(&self) -> Mover {
        let ConstantVelocity { position, velocity, .. } = self.filter;
        Mover { number: self.number, position, velocity, seen: self.seen, is_moving: self.is_moving }
    }

    /// Time passes.
    pub fn predict(&mut self, seconds: f64, tuning: &MoverTuning) {
        self.parts.clear();
        self.filter.predict(seconds, tuning.agility_m2_s3);
    }

    /// A segment belongs to it.
    pub fn take(&mut self, part: Point2) {
        self.parts.push(part);
    }

    /// Begins in the middle of its parts.
    pub fn center(&mut self) {
        if let Some(middle) = self.middle() {
            self.filter.position = middle;
        }
    }

    /// The scan is distributed.
    pub fn update(&mut self, stamp: Time, deviation_m: f64) {
        let Some(middle) = self.middle() else { return };
        self.filter.update(middle, deviation_m);
        self.seen = stamp;
        self.n_seen += 1;
    }

    fn middle(&self) -> Option<Point2> {
        let sum: nalgebra::Vector2<f64> = self.parts.iter().map(|part| part.coords).sum();
        (!self.parts.is_empty()).then(|| Point2::from(sum / self.parts.len() as f64))
    }

    /// Whether it moves or stands.
    pub fn judge(&mut self, stamp: Time, past: &Past, tuning: &MoverTuning) {
        while self.places.front().is_some_and(|(then, _)| stamp - *then > Past::REACH) {
            self.places.pop_front();
        }
        let speed_m_s = self.filter.velocity.norm();
        if self.parts.is_empty() {
            let is_absent = past.goes_through(self.position());
            self.n_absent = if is_absent { self.n_absent + 1 } else { 0 };
        } else {
            self.n_absent = 0;
            let is_fast = speed_m_s >= tuning.least_speed_m_s
                && speed_m_s >= Self::SURE * self.filter.speed_deviation_m_s();
            self.is_moving |=
                is_fast && self.n_seen >= Self::LEAST_SEEN && self.swapped_with_air(stamp, past);
            self.has_moved |= self.is_moving;
        }
        if let Some(part) = self.parts.first() {
            self.places.push_back((stamp, *part));
        }
        let is_slow = speed_m_s < Self::SLOW * tuning.least_speed_m_s;
        self.slow_since = is_slow.then(|| self.slow_since.unwrap_or(stamp));
        if self.slow_since.is_some_and(|since| (stamp - since).as_secs() >= tuning.stands_after_s) {
            self.is_moving = false;
        }
    }

    /// Light goes through where it was, or went through where it is.
    fn swapped_with_air(&self, stamp: Time, past: &Past) -> bool {
        let mut earlier = self.places.iter().filter(|(then, _)| stamp - *then >= Self::AGO);
        earlier.any(|(then, place)| {
            past.goes_through(*place) || self.parts.iter().any(|part| past.went_through(*then, *part))
        })
    }

    /// Whether it is worth to be followed.
    pub fn is_alive(&self, stamp: Time, tuning: &MoverTuning) -> bool {
        self.n_absent < Self::ABSENT && (stamp - self.seen).as_secs() <= tuning.forget_after_s
    }
}
