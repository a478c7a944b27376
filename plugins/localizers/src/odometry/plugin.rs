//! Dead reckoning as a localizer.

use super::params::OdometryParams;
use super::propagation::Uncertainty;
use crate::prior::known_beginning;
use rumbo_core::frames::{Pose2, lift};
use rumbo_core::map::Map;
use rumbo_core::messages::{Check, Estimate, ObservationKind, Odometry, Prior, Seen};
use rumbo_core::registry::{Manifest, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, LocalizeError, Localizer};
use rumbo_core::time::Time;

/// See [`OdometryParams`].
#[derive(Debug)]
pub struct DeadReckoning {
    params: OdometryParams,
    max_speed_m_s: f64,
    max_turn_rad_s: f64,
    track: Option<Track>,
}

/// The way since the start.
#[derive(Debug)]
struct Track {
    map_from_odom: Pose2,
    odom_from_base: Pose2,
    /// Stamp of the newest reading; none before the first.
    stamp: Option<Time>,
    uncertainty: Uncertainty,
}

impl DeadReckoning {
    /// Before the first reading the odometer may have moved unseen for this long, seconds.
    const BEFORE_FIRST_S: f64 = 1.0;

    /// Dead reckoning for a robot with these limits.
    pub fn new(params: OdometryParams, max_speed_m_s: f64, max_turn_rad_s: f64) -> DeadReckoning {
        DeadReckoning { params, max_speed_m_s, max_turn_rad_s, track: None }
    }

    /// Goes on to a reading that is newer than the last; the error of a jump is reported, and the pose kept.
    fn advance(&mut self, stamp: Time, odometry: &Odometry) -> Result<(), LocalizeError> {
        let Some(track) = &mut self.track else { return Err(LocalizeError::NotStarted) };
        if track.stamp.is_some_and(|last| stamp <= last) {
            // A newer reading has told the whole way already.
            return Ok(());
        }
        let is_first = track.stamp.is_none();
        let elapsed_s = track.stamp.map_or(Self::BEFORE_FIRST_S, |last| (stamp - last).as_secs());
        let step = track.odom_from_base.inverse() * odometry.odom_from_base;
        let (way_m, turn_rad) = (step.translation.vector.norm(), step.rotation.angle());
        let (reach_m, reach_rad) = (self.max_speed_m_s * elapsed_s, self.max_turn_rad_s * elapsed_s);
        let jumped = way_m > self.params.jump_m + 2.0 * reach_m
            || turn_rad.abs() > self.params.jump_deg.to_radians() + 2.0 * reach_rad;
        track.stamp = Some(stamp);
        let map_from_base = track.map_from_odom * track.odom_from_base;
        track.odom_from_base = odometry.odom_from_base;
        if jumped {
            track.map_from_odom = map_from_base * odometry.odom_from_base.inverse();
            if is_first {
                // The prior was made before the odometer had said anything: its pose there is a guess.
                return Ok(());
            }
            track.uncertainty.widen(reach_m, reach_rad);
            return Err(LocalizeError::Other(format!(
                "the odometer jumped by {way_m:.2} m and {:.0} degrees in {elapsed_s:.2} s; was it restarted? \
                 The pose is kept",
                turn_rad.to_degrees()
            )));
        }
        let way = map_from_base.rotation * step.translation.vector;
        track.uncertainty.advance(way, turn_rad, odometry.noise, self.params.error_growth);
        Ok(())
    }
}

impl Localizer for DeadReckoning {
    fn start(&mut self, prior: &Prior, _map: &Map) -> Result<(), LocalizeError> {
        let ((map_from_base, covariance), odom_from_base) = known_beginning(prior)?;
        self.track = Some(Track {
            map_from_odom: map_from_base * odom_from_base.inverse(),
            odom_from_base,
            stamp: None,
            uncertainty: Uncertainty::new(covariance),
        });
        Ok(())
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, _map: &Map) -> Result<Estimate, LocalizeError> {
        let mut outcome = Ok(());
        for (observation, odometry) in seen.odometry().filter(|(observation, _)| observation.valid) {
            odometry.check()?;
            let advanced = self.advance(observation.stamp, odometry);
            // All readings are taken in, so that a failed update leaves nothing half done.
            outcome = outcome.and(advanced);
        }
        outcome?;
        let Some(track) = &self.track else { return Err(LocalizeError::NotStarted) };
        let map_from_base = track.map_from_odom * track.odom_from_base;
        let (stamp, covariance) = (track.stamp.unwrap_or(cx.now), track.uncertainty.covariance());
        let estimate = Estimate::planar(stamp, map_from_base, track.odom_from_base, covariance);
        // Not computed back from the poses: it is constant to the last bit.
        Ok(Estimate { map_from_odom: lift(&track.map_from_odom), ..estimate })
    }
}

impl Plugin<dyn Localizer> for OdometryParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            consumes: vec![vec![ObservationKind::Odometry]],
            needs_start_pose: true,
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Localizer>, BuildError> {
        let robot = &context.robot;
        Ok(Box::new(DeadReckoning::new(self.clone(), robot.max_speed_m_s, robot.max_turn_rad_s())))
    }
}

rumbo_core::register_localizer!(
    OdometryParams,
    "odometry",
    "dead reckoning from a known start; says how unsure the pose becomes on the way"
);
