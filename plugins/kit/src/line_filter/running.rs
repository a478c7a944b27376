//! What a tracker does with each observation once it was started.

use super::clock::{Clock, Instant, Source, Steps};
use super::filter::{LineFilter, Reading};
use super::sighting::Mount;
use super::tracker::{TrackFault, TrackerSettings};
use super::wheel_readings::{Odometer, of_axle};
use crate::lines::{BeamFan, LineExtractor};
use rumbo_core::frames::{Pose2, flatten};
use rumbo_core::messages::{Check, Data, Estimate, LaserScan, Observation, Odometry, Status};
use rumbo_core::odometry_track::OdometryTrack;
use rumbo_core::robot::Drive;
use rumbo_core::time::Time;

/// No robot is as fast, m/s: an odometer that reads more has lost its place.
const FASTEST_M_S: f64 = 1000.0;

/// What was left out, since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LeftOut {
    /// Readings of wheels that slipped.
    pub slipping: u64,
    /// Readings that came too late.
    pub late: u64,
    /// Readings whose sensor was not due.
    pub not_due: u64,
    /// Readings whose numbers made no sense together.
    pub refused: u64,
}

/// A filter that was started, and what it has heard so far.
#[derive(Debug)]
pub(super) struct Running {
    pub filter: LineFilter,
    pub clock: Clock,
    pub odometer: Odometer,
    pub track: OdometryTrack,
    /// Wheels speak for themselves: the odometer, which is made from them, is not counted twice.
    has_wheels: bool,
    pub left_out: LeftOut,
    scans_without_match: u32,
    pub n_scans: u64,
    /// Where the last scan was taken in.
    looked_from: Option<Pose2>,
}

/// Longer than this the robot is not predicted, seconds.
const LONGEST_GAP_S: f64 = 10.0;

impl Running {
    /// Before the first reading.
    pub fn new(filter: LineFilter, settings: &TrackerSettings, odom_from_base: Pose2) -> Running {
        Running {
            filter,
            clock: settings.clock.clone(),
            odometer: Odometer { odom_from_base, stamp: None },
            track: OdometryTrack::new(),
            has_wheels: false,
            left_out: LeftOut::default(),
            scans_without_match: 0,
            n_scans: 0,
            looked_from: None,
        }
    }

    /// Somebody says where the robot is: clock and odometer may be others from now on.
    pub fn place(&mut self, settings: &TrackerSettings, odom_from_base: Pose2) {
        self.clock = settings.clock.clone();
        self.odometer = Odometer { odom_from_base, stamp: None };
        self.track = OdometryTrack::new();
        (self.scans_without_match, self.looked_from) = (0, None);
    }

    /// Takes in one observation.
    pub fn take(
        &mut self,
        observation: &Observation,
        settings: &TrackerSettings,
        extractor: &mut LineExtractor,
    ) -> Result<(), TrackFault> {
        let stamp = observation.stamp;
        match &observation.data {
            Data::WheelSpeeds(wheels) => {
                wheels.check()?;
                if let Some(speeds) = of_axle(wheels, &settings.drive) {
                    self.has_wheels = true;
                    if self.goes_to(Source::Wheels, stamp, settings)? {
                        self.turn_wheels(speeds);
                    }
                }
            }
            Data::Odometry(odometry) => {
                odometry.check()?;
                self.track.push(stamp, odometry);
                self.follow_odometer(stamp, odometry, settings)?;
            }
            // What stands for the angle of another drive, nobody says.
            Data::SteeringAngle(steering) if matches!(settings.drive, Drive::Tricycle { .. }) => {
                steering.check()?;
                if self.goes_to(Source::Steering, stamp, settings)? {
                    let reading = self.filter.read_steering(steering.angle_rad);
                    self.left_out.refused += u64::from(reading == Reading::Refused);
                }
            }
            Data::LaserScan(scan) => {
                scan.check()?;
                if self.goes_to(Source::Laser, stamp, settings)? && self.is_elsewhere(settings.look_every) {
                    self.look(scan, &Mount::from(&flatten(&observation.base_from_sensor)), extractor);
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Predicts to a reading; whether it is to be taken in.
    fn goes_to(
        &mut self,
        source: Source,
        stamp: Time,
        settings: &TrackerSettings,
    ) -> Result<bool, TrackFault> {
        let Some(steps) = self.admitted(source, stamp, settings)? else { return Ok(false) };
        (0..steps.n).for_each(|_| self.filter.predict(steps.seconds));
        Ok(true)
    }

    /// How to go on to a reading; none where it is left out.
    fn admitted(
        &mut self,
        source: Source,
        stamp: Time,
        settings: &TrackerSettings,
    ) -> Result<Option<Steps>, TrackFault> {
        let gap_s = self.clock.now().map_or(0.0, |now| (stamp - now).as_secs());
        match self.clock.admit(source, stamp) {
            Instant::Ahead(_) if gap_s > LONGEST_GAP_S => {
                self.filter.forget_motion(settings.start_motion);
                Err(TrackFault::Gap { gap_s })
            }
            Instant::Ahead(steps) => Ok(Some(steps)),
            Instant::Slightly => Ok(Some(Steps::default())),
            Instant::Late => {
                self.left_out.late += 1;
                Ok(None)
            }
            Instant::NotDue => {
                self.left_out.not_due += 1;
                Ok(None)
            }
        }
    }

    /// An odometer says how far the robot went since its last reading: that is where it goes now.
    fn follow_odometer(
        &mut self,
        stamp: Time,
        odometry: &Odometry,
        settings: &TrackerSettings,
    ) -> Result<(), TrackFault> {
        if self.has_wheels || self.odometer.stamp.is_none_or(|last| stamp <= last) {
            self.odometer.advance(stamp, odometry.odom_from_base);
            return Ok(());
        }
        let admitted = self.admitted(Source::Wheels, stamp, settings);
        if admitted == Ok(None) {
            // A later reading tells this way, too.
            return Ok(());
        }
        let mean = self.odometer.advance(stamp, odometry.odom_from_base);
        let (Some(steps), Some(mean)) = (admitted?, mean) else { return Ok(()) };
        if mean.forward_m_s.abs() > FASTEST_M_S {
            self.left_out.refused += 1;
            return Ok(());
        }
        let seconds = if steps.n > 0 { steps.all_s() } else { mean.seconds };
        let noise = settings.odometer.of(odometry.noise, &settings.filter.wheels);
        let read = [mean.forward_m_s, mean.turn_rad_s];
        let reading = self.filter.roll(read, noise.variances(read, seconds), steps);
        self.left_out.refused += u64::from(reading == Reading::Refused);
        Ok(())
    }

    fn turn_wheels(&mut self, speeds_m_s: [f64; 2]) {
        match self.filter.read_wheels(speeds_m_s) {
            Reading::Slipping(_) => self.left_out.slipping += 1,
            Reading::Refused => self.left_out.refused += 1,
            Reading::Fused(_) | Reading::TooSlow => {}
        }
    }

    /// The robot is farther (m) or turned by more (rad) than this from where it looked last.
    fn is_elsewhere(&self, [way_m, turn_rad]: [f64; 2]) -> bool {
        self.looked_from.is_none_or(|map_from_last| {
            let step = map_from_last.inverse() * self.filter.state().pose();
            step.translation.vector.norm() >= way_m || step.rotation.angle().abs() >= turn_rad
        })
    }

    fn look(&mut self, scan: &LaserScan, mount: &Mount, extractor: &mut LineExtractor) {
        let fan = BeamFan {
            first_bearing_rad: scan.first_bearing_rad,
            bearing_step_rad: scan.bearing_step_rad,
            min_range_m: f64::from(scan.min_range_m),
            max_range_m: f64::from(scan.max_range_m),
        };
        let lines = extractor.extract(&fan, scan.ranges_m.iter().map(|range| f64::from(*range)));
        let report = self.filter.read_lines(lines, mount);
        self.looked_from = Some(self.filter.state().pose());
        self.n_scans += 1;
        self.left_out.refused += u64::from(report.is_refused);
        if !report.matches.is_empty() {
            self.scans_without_match = 0;
        } else if !lines.is_empty() {
            self.scans_without_match = self.scans_without_match.saturating_add(1);
        }
    }

    /// Where the robot is.
    pub fn estimate(&self, now: Time, lost_after_scans: u32) -> Estimate {
        let stamp = self.clock.now().unwrap_or(now).min(now);
        let odom_from_base =
            self.track.stamp().map_or(self.odometer.odom_from_base, |_| self.track.at(stamp));
        let state = self.filter.state();
        let mut estimate = Estimate::planar(stamp, state.pose(), odom_from_base, state.pose_covariance());
        if self.filter.is_on_map() && self.scans_without_match >= lost_after_scans {
            estimate.status = Status::Lost;
        }
        estimate
    }
}
