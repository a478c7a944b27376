//! The first third of a step: from the world through sensors and odometer to what the stages see.

use super::at_work::Place;
use super::ring::Filter;
use super::seat::Seat;
use super::step::Engine;
use super::timing::Part;
use crate::frames::{Pose2, Pose3, Twist, lift};
use crate::messages::{Check, Data, MessageFault, Observation, Odometry, SensorId};
use crate::odometry_track::OdometryTrack;
use crate::stages::{Cx, Sensor};
use crate::time::Time;
use std::time::Instant;

/// A sensor in its place.
pub(super) struct SensorSeat {
    pub seat: Seat<Box<dyn Sensor>>,
    pub inputs: Vec<SensorId>,
}

impl Engine {
    /// World ─► Sensor: what is seen goes into the ring.
    pub(super) fn sense(&mut self) {
        let clock = Instant::now();
        self.n_new = 0;
        for idx in 0..self.sensors.len() {
            let SensorSeat { seat, inputs } = &mut self.sensors[idx];
            // In a recording a sensor is due at the recorded stamps, whatever its rate.
            if !(seat.is_due(&mut self.schedule, &self.ring, self.now) || self.recorded && inputs.is_empty())
            {
                continue;
            }
            self.at_work.enter(Place::Sensor(idx));
            let (mut cx, read) = (Cx { now: self.now, trace: &self.trace }, self.ring.cursor());
            let result = if inputs.is_empty() {
                seat.stage.poll(&mut cx, self.world.as_mut(), &mut self.out)
            } else {
                seat.report_loss(&self.ring, self.now, &mut self.events);
                let seen = self.ring.seen(seat.cursor, Filter::Of(inputs));
                if seen.is_empty() { Ok(()) } else { seat.stage.derive(&mut cx, seen, &mut self.out) }
            };
            let kept = self.collect();
            let result = result.map_err(|e| e.to_string()).and(kept.map_err(|e| e.to_string()));
            let seat = &mut self.sensors[idx].seat;
            seat.settle(result, read, self.now, &mut self.events);
        }
        self.times.add(Part::Sensors, clock);
    }

    /// Moves what a sensor gave into the ring; a message that must not go on stays out.
    fn collect(&mut self) -> Result<(), MessageFault> {
        let mut kept = Ok(());
        while let Some(observation) = self.out.pop_front() {
            match observation.check() {
                Ok(()) => {
                    self.ring.push(observation, &mut self.out);
                    self.n_new += 1;
                }
                Err(fault) => kept = Err(fault),
            }
        }
        kept
    }

    /// (Odometer): the only publisher of odom → base; without one, the odometry sensor is.
    pub(super) fn track_odometry(&mut self) {
        let clock = Instant::now();
        if let Some(seat) = &mut self.odometer
            && seat.is_due(&mut self.schedule, &self.ring, self.now)
        {
            self.at_work.enter(Place::Odometer);
            seat.report_loss(&self.ring, self.now, &mut self.events);
            let (mut cx, read) = (Cx { now: self.now, trace: &self.trace }, self.ring.cursor());
            let seen = self.ring.seen(seat.cursor, Filter::Raw);
            let result = seat.stage.update(&mut cx, seen, &self.map).map_err(|e| e.to_string());
            let checked = result.and_then(|e| e.check().map(|()| e).map_err(|fault| fault.to_string()));
            if let Some(estimate) = seat.settle(checked, read, self.now, &mut self.events) {
                let odom_from_footprint = estimate.pose2();
                let space = lift(&odom_from_footprint).inverse() * estimate.map_from_base;
                self.footprint_from_base = Some(space);
                let observation = odometry_of(&odom_from_footprint, estimate.stamp, &self.track);
                self.ring.push(observation, &mut self.out);
                self.n_new += 1;
            }
        }
        let from_odometer = self.odometer.is_some();
        for observation in self.ring.newest(self.n_new) {
            if let Data::Odometry(odometry) = &observation.data
                && observation.valid
                && from_odometer == (observation.sensor == SensorId::ODOMETER)
            {
                self.track.push(observation.stamp, odometry);
            }
        }
        for observation in self.ring.newest_unreplaced(self.n_new) {
            self.guard.see(observation, &self.track.at(observation.stamp));
        }
        self.times.add(Part::Localizer, clock);
    }
}

/// The odometer seat's estimate as an observation.
fn odometry_of(odom_from_base: &Pose2, stamp: Time, track: &OdometryTrack) -> Observation {
    let mut twist = Twist::ZERO;
    if let Some(last) = track.stamp() {
        let seconds = (stamp - last).as_secs();
        if seconds > 0.0 {
            let step = track.now().inverse() * odom_from_base;
            twist = Twist {
                forward_m_s: step.translation.x / seconds,
                left_m_s: step.translation.y / seconds,
                turn_rad_s: step.rotation.angle() / seconds,
            };
        }
    }
    let odometry = Odometry { odom_from_base: *odom_from_base, twist, noise: [0.0; 3] };
    Observation {
        sensor: SensorId::ODOMETER,
        stamp,
        base_from_sensor: Pose3::identity(),
        valid: true,
        data: Data::Odometry(odometry),
    }
}
