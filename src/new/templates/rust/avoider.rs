//! The avoider `{{name}}`: drives to a point ahead on the path, and stops where its laser sees something in the way.
//!
//! Replace what [`GoToPath::steer`] does by your own algorithm; the rest can stay.

use rumbo_core::frames::{Point2, Twist, flatten, is_finite2};
use rumbo_core::messages::{Check, Obstacle, ObservationKind, Path};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::robot::{DriveKind, Robot};
use rumbo_core::stages::{AvoidError, AvoidInput, Avoider, BuildContext, BuildError, Cx, Steering};
use rumbo_core::time::Time;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Drives along the path and stops in front of obstacles.
// These comments are what `rumbo plugins describe` and editors show.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// The robot goes for a point of the path this far ahead, meters.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub look_ahead_m: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Parameters { look_ahead_m: 0.3 }
    }
}

impl Params for Parameters {
    fn check(&self) -> Vec<BuildError> {
        let found = self.look_ahead_m;
        let fits = (0.05..=5.0).contains(&found);
        let fault = || BuildError::at("look_ahead_m", format!("is {found}, expected a number from 0.05 to 5"));
        (!fits).then(fault).into_iter().collect()
    }
}

impl Plugin<dyn Avoider> for Parameters {
    fn manifest(&self) -> Manifest {
        Manifest {
            consumes: vec![vec![ObservationKind::LaserScan]],
            // It turns in place.
            drives: vec![DriveKind::Differential, DriveKind::Omnidirectional],
            ..Manifest::default()
        }
    }

    fn build(&self, _: &BuildContext) -> Result<Box<dyn Avoider>, BuildError> {
        Ok(Box::new(GoToPath { parameters: self.clone(), following: None, passed: 0, scan: None }))
    }
}

struct GoToPath {
    parameters: Parameters,
    /// The path that is followed, by its number, and the point of it that was nearest last.
    following: Option<u64>,
    passed: usize,
    /// When the newest scan was taken, and its hits in the odometer's frame, which does not jump.
    scan: Option<(Time, Vec<Point2>)>,
}

/// A scan older than this says nothing about now, seconds.
const STALE_S: f64 = 1.0;
/// More than this off, the robot turns before it goes, radians.
const TURNS_FIRST_RAD: f64 = 0.4;
/// Turn rate for each radian that the robot looks beside its way, 1/s.
const TURN_GAIN: f64 = 2.0;

impl Avoider for GoToPath {
    fn steer(&mut self, cx: &mut Cx<'_>, input: &AvoidInput<'_>) -> Result<Steering, AvoidError> {
        input.twist.check()?;
        if !is_finite2(&input.map_from_base) {
            return Err(AvoidError::Other("the robot's place is not a finite number".to_owned()));
        }
        self.look(input);
        let Some(path) = input.path else { return Ok(Steering::Drive(Twist::ZERO)) };
        if self.following != Some(input.path_number) {
            (self.following, self.passed) = (Some(input.path_number), 0);
        }
        let robot: Point2 = input.map_from_base.translation.vector.into();
        let left_m = (path.end().position - robot).norm();
        if left_m <= input.arrival_radius_m {
            return Ok(Steering::Arrived);
        }
        let Some((stamp, hits)) = &self.scan else { return Ok(Steering::Drive(Twist::ZERO)) };
        let age_s = (cx.now - *stamp).as_secs();
        if age_s > STALE_S {
            return Err(AvoidError::NoReading { kind: "laser scan", age_s });
        }
        let odom_from_base = flatten(&input.estimate.map_from_odom).inverse() * input.map_from_base;
        let hits: Vec<Point2> = hits.iter().map(|hit| odom_from_base.inverse() * hit).collect();
        let target = input.map_from_base.inverse() * self.point_ahead(path, robot);
        let way_rad = target.y.atan2(target.x);
        let fastest = input.robot.max_turn_rad_s();
        let turn_rad_s = (TURN_GAIN * way_rad).clamp(-fastest, fastest);
        if way_rad.abs() > TURNS_FIRST_RAD {
            return Ok(Steering::Drive(Twist::new(0.0, turn_rad_s)));
        }
        let speed_m_s = input.robot.max_speed_m_s.min((2.0 * input.robot.braking_m_s2 * left_m).sqrt());
        let stop_m = stop_m(speed_m_s, input.robot).min(left_m);
        let in_the_way: Vec<&Point2> = hits.iter().filter(|hit| is_in_the_way(hit, stop_m, input.robot)).collect();
        if !in_the_way.is_empty() {
            let obstacle = |hit: &Point2| Obstacle { position: input.map_from_base * hit, radius_m: 0.0, stamp: cx.now };
            return Ok(Steering::Blocked { obstacles: in_the_way.into_iter().map(obstacle).collect() });
        }
        Ok(Steering::Drive(Twist::new(speed_m_s * way_rad.cos(), turn_rad_s)))
    }
}

impl GoToPath {
    /// Keeps the newest scan.
    fn look(&mut self, input: &AvoidInput<'_>) {
        let newest = input.seen.laser_scans().rfind(|(observation, scan)| observation.valid && scan.check().is_ok());
        let Some((observation, scan)) = newest else { return };
        let odom_from_base = flatten(&input.estimate.map_from_odom).inverse() * input.map_from_base;
        let odom_from_sensor = odom_from_base * flatten(&observation.base_from_sensor);
        let point = |(bearing_rad, range_m): (f64, f64)| {
            odom_from_sensor * Point2::new(range_m * bearing_rad.cos(), range_m * bearing_rad.sin())
        };
        self.scan = Some((observation.stamp, scan.hits().map(point).collect()));
    }

    /// The point of the path `look_ahead_m` beyond the one nearest to the robot.
    fn point_ahead(&mut self, path: &Path, robot: Point2) -> Point2 {
        let pieces: Vec<(Point2, Point2)> =
            path.points().windows(2).filter_map(|w| Some((w.first()?.position, w.last()?.position))).collect();
        let share = |(from, to): (Point2, Point2)| {
            let piece = to - from;
            ((robot - from).dot(&piece) / piece.norm_squared().max(1e-12)).clamp(0.0, 1.0)
        };
        let off_m = |piece: (Point2, Point2)| (piece.0 + (piece.1 - piece.0) * share(piece) - robot).norm();
        // Forward only, and no farther than the next corner but one: a path that comes back is not cut short.
        while let (Some(here), Some(next)) = (pieces.get(self.passed), pieces.get(self.passed + 1))
            && off_m(*next) <= off_m(*here)
        {
            self.passed += 1;
        }
        let mut left_m = self.parameters.look_ahead_m;
        for (idx, (from, to)) in pieces.iter().copied().enumerate().skip(self.passed) {
            let begins = if idx == self.passed { share((from, to)) } else { 0.0 };
            let length_m = (to - from).norm() * (1.0 - begins);
            if left_m <= length_m {
                return from + (to - from) * (begins + (1.0 - begins) * left_m / length_m.max(1e-9));
            }
            left_m -= length_m;
        }
        path.end().position
    }
}

/// Length of the way ahead that must be free: to stop in it, and a little more.
fn stop_m(speed_m_s: f64, robot: &Robot) -> f64 {
    speed_m_s.powi(2) / (2.0 * robot.braking_m_s2) + speed_m_s * robot.guard.latency_s + 0.1
}

/// Something in the strip ahead of the hull, which is as wide as what the guard watches.
fn is_in_the_way(hit: &Point2, stop_m: f64, robot: &Robot) -> bool {
    let hull_m = robot.hull().outer_radius_m() + robot.guard.margin_m;
    hit.x > 0.0 && hit.x < hull_m + stop_m && hit.y.abs() < hull_m
}

rumbo_core::register_avoider!(Parameters, "{{name}}", "drives along the path and stops in front of obstacles");

// The line that makes a plugin library of this crate.
rumbo_core::export_plugins!();

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_point_ahead_goes_around_corners() {
        let mut avoider =
            GoToPath { parameters: Parameters { look_ahead_m: 0.5 }, following: None, passed: 0, scan: None };
        let points = [Point2::new(0.0, 0.0), Point2::new(1.0, 0.0), Point2::new(1.0, 1.0)];
        let path = Path::through(points, 2.0).unwrap();
        let ahead = avoider.point_ahead(&path, Point2::new(0.8, 0.1));
        assert!((ahead - Point2::new(1.0, 0.3)).norm() < 1e-9, "{ahead}");
        assert_eq!(avoider.point_ahead(&path, Point2::new(1.0, 0.9)), Point2::new(1.0, 1.0));
    }
}
