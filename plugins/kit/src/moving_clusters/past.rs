//! The scans of the last moments: what light went through then.

use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose2};
use rumbo_core::messages::LaserScan;
use rumbo_core::time::{Span, Time};
use std::collections::VecDeque;

/// One scan, and where it was made.
#[derive(Debug)]
struct Kept {
    stamp: Time,
    sensor_from_frame: Pose2,
    first_bearing_rad: f64,
    bearing_step_rad: f64,
    min_range_m: f32,
    max_range_m: f32,
    ranges_m: Buffer<f32>,
}

/// The last scans, the newest at the end.
#[derive(Debug)]
pub struct Past {
    scans: VecDeque<Kept>,
}

impl Default for Past {
    fn default() -> Self {
        Past { scans: VecDeque::with_capacity(Past::USUAL) }
    }
}

impl Past {
    /// So long ago is of no interest.
    pub const REACH: Span = Span(1_600_000_000);
    /// A scanner with 40 scans a second has no more of them in that time.
    const USUAL: usize = 66;
    /// Half the width around a point that must be free of hits for light to have gone through, meters: a leg and the
    /// noise of the scanner.
    const AROUND_M: f64 = 0.15;
    /// And a beam must end this much beyond, meters.
    const BEYOND_M: f64 = 0.25;
    /// A point this near to the scanner has no neighborhood, meters.
    const NEAREST_M: f64 = 0.2;

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.scans.clear();
    }

    /// Keeps a scan; its ranges are shared.
    pub fn keep(&mut self, stamp: Time, scan: &LaserScan, frame_from_sensor: &Pose2) {
        while self.scans.front().is_some_and(|old| stamp - old.stamp > Self::REACH) {
            self.scans.pop_front();
        }
        self.scans.push_back(Kept {
            stamp,
            sensor_from_frame: frame_from_sensor.inverse(),
            first_bearing_rad: scan.first_bearing_rad,
            bearing_step_rad: scan.bearing_step_rad,
            min_range_m: scan.min_range_m,
            max_range_m: scan.max_range_m,
            ranges_m: scan.ranges_m.clone(),
        });
    }

    /// Whether light went through a point in the scan of this moment.
    pub fn went_through(&self, stamp: Time, point: Point2) -> bool {
        self.scans.iter().any(|scan| scan.stamp == stamp && scan.goes_through(point))
    }

    /// Whether light goes through a point now.
    pub fn goes_through(&self, point: Point2) -> bool {
        self.scans.back().is_some_and(|scan| scan.goes_through(point))
    }
}

impl Kept {
    fn goes_through(&self, point: Point2) -> bool {
        let in_sensor = self.sensor_from_frame * point;
        let distance_m = in_sensor.coords.norm();
        if distance_m < Past::NEAREST_M {
            return false;
        }
        let bearing_rad = in_sensor.y.atan2(in_sensor.x);
        let around_rad = (Past::AROUND_M / distance_m).min(1.0).asin();
        let beam = |bearing: f64| (bearing - self.first_bearing_rad) / self.bearing_step_rad;
        let (one, other) = (beam(bearing_rad - around_rad), beam(bearing_rad + around_rad));
        let (first, last) = (one.min(other).floor(), one.max(other).ceil());
        if !(first >= 0.0 && last < self.ranges_m.len() as f64) {
            return false;
        }
        // Nothing within reach says as much as the reach; not-a-number and what is too near say nothing.
        let needed_m = distance_m + Past::BEYOND_M;
        let is_beyond =
            |range: &f32| *range >= self.min_range_m && f64::from(range.min(self.max_range_m)) >= needed_m;
        self.ranges_m.get(first as usize..=last as usize).is_some_and(|beams| beams.iter().all(is_beyond))
    }
}
