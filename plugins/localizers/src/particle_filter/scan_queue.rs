//! Scans that wait for the odometer, and which of them are weighed together.

use rumbo_core::frames::Pose3;
use rumbo_core::messages::{LaserScan, Observation, SensorId};
use rumbo_core::time::{Span, Time};
use rumbo_kit::odometry_history::OdometryHistory;
use std::collections::{BTreeMap, VecDeque};

/// A scan with its stamp and mount.
#[derive(Debug, Clone)]
pub struct PendingScan {
    /// Who saw it.
    pub sensor: SensorId,
    /// When.
    pub stamp: Time,
    /// Where the sensor sat.
    pub base_from_sensor: Pose3,
    /// What it saw.
    pub scan: LaserScan,
}

/// Scans in the order of their stamps, few of each sensor.
#[derive(Debug, Default)]
pub struct ScanQueue {
    waiting: VecDeque<PendingScan>,
    newest: BTreeMap<SensorId, Time>,
    n_dropped: u64,
}

impl ScanQueue {
    /// More than this wait for an odometer that is silent: the oldest are dropped.
    const MOST_WAITING: usize = 40;
    /// A scan waits for the odometer at most this long, seconds.
    const PATIENCE_S: f64 = 0.5;

    /// Scans that were dropped so far: late or twice, or without odometry.
    pub fn n_dropped(&self) -> u64 {
        self.n_dropped
    }

    /// Forgets all scans that wait.
    pub fn clear(&mut self) {
        self.waiting.clear();
        self.newest.clear();
    }

    /// Takes in a scan; one whose stamp is not newer than the last of its sensor is dropped.
    pub fn push(&mut self, observation: &Observation, scan: &LaserScan) {
        let (sensor, stamp) = (observation.sensor, observation.stamp);
        if self.newest.get(&sensor).is_some_and(|newest| stamp <= *newest) {
            self.n_dropped += 1;
            return;
        }
        self.newest.insert(sensor, stamp);
        let at = self.waiting.partition_point(|scan| (scan.stamp, scan.sensor) <= (stamp, sensor));
        let base_from_sensor = observation.base_from_sensor;
        self.waiting.insert(at, PendingScan { sensor, stamp, base_from_sensor, scan: scan.clone() });
        if self.waiting.len() > Self::MOST_WAITING {
            self.waiting.pop_front();
            self.n_dropped += 1;
        }
    }

    /// The oldest scan for which the odometry is known. Those for which it will never be are dropped.
    pub fn pop_ready(&mut self, now: Time, odometry: &OdometryHistory) -> Option<PendingScan> {
        loop {
            let stamp = self.waiting.front()?.stamp;
            if odometry.at(stamp).is_some() {
                return self.waiting.pop_front();
            }
            let is_hopeless = odometry.is_before(stamp) || now - stamp > Span::from_secs(Self::PATIENCE_S);
            if !is_hopeless {
                return None;
            }
            self.waiting.pop_front();
            self.n_dropped += 1;
        }
    }

    /// Takes out the scans of other sensors that belong to the same moment: at most `within` newer.
    pub fn pop_companions(
        &mut self,
        scan: &PendingScan,
        within: Span,
        odometry: &OdometryHistory,
    ) -> Vec<PendingScan> {
        let mut companions: Vec<PendingScan> = Vec::new();
        let mut idx = 0;
        while let Some(other) = self.waiting.get(idx).filter(|other| other.stamp - scan.stamp <= within) {
            let is_known = companions.iter().any(|known| known.sensor == other.sensor);
            if other.sensor == scan.sensor || is_known || odometry.at(other.stamp).is_none() {
                idx += 1;
            } else {
                companions.extend(self.waiting.remove(idx));
            }
        }
        companions
    }
}
