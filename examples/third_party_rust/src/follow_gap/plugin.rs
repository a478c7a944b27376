//! The avoider: what is seen, where to go, how fast.

use super::FollowGapParams;
use super::gaps::{Room, direction, free_m, nearest_m};
use super::route::Route;
use rumbo_core::frames::{Point2, Pose2, Twist, flatten, is_finite2, wrap_angle};
use rumbo_core::map::{Cell, CellClass, Grid};
use rumbo_core::messages::{Check, MessageFault, ObservationKind, Obstacle, SensorId};
use rumbo_core::registry::{Manifest, Plugin};
use rumbo_core::robot::{DriveKind, Robot};
use rumbo_core::stages::{AvoidError, AvoidInput, Avoider, BuildContext, BuildError, Cx, Steering};
use rumbo_core::time::{Span, Time};

struct FollowGap {
    params: FollowGapParams,
    route: Route,
    /// The path that is followed, by its number.
    following: Option<u64>,
    /// What each scanner saw last, in the odometer's frame, which does not jump.
    scans: Vec<Scan>,
    /// Hits in the base frame, now; kept for its memory.
    hits: Vec<Point2>,
    first_call: Option<Time>,
    /// The shortest rest of the path so far, and when that was.
    nearest_to_end: Option<(f64, Time)>,
}

struct Scan {
    sensor: SensorId,
    stamp: Time,
    hits_in_odom: Vec<Point2>,
}

/// A scan older than this says nothing about now, seconds.
const STALE_S: f64 = 1.0;
/// What is farther away does not matter to the next meters, meters.
const SEES_M: f64 = 3.0;
/// More than this off, the robot turns before it goes, radians.
const TURNS_FIRST_RAD: f64 = 0.8;
/// Turn rate for each radian that the robot looks beside its way, 1/s.
const TURN_GAIN: f64 = 2.0;
/// Hits this near to an occupied cell are on the map, meters.
const MAPPED_WITHIN_M: f64 = 0.15;
/// Beyond the guard's margin, so that the avoider is the first to stop, meters.
const TO_SPARE_M: f64 = 0.02;
/// The robot has come nearer to the end of its path when it is this much less, meters.
const PROGRESS_M: f64 = 0.1;
/// A final heading counts as reached within this, radians.
const HEADING_WITHIN_RAD: f64 = 0.05;

impl Plugin<dyn Avoider> for FollowGapParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            consumes: vec![vec![ObservationKind::LaserScan]],
            drives: vec![DriveKind::Differential, DriveKind::Omnidirectional],
            ..Manifest::default()
        }
    }

    fn build(&self, _: &BuildContext) -> Result<Box<dyn Avoider>, BuildError> {
        Ok(Box::new(FollowGap {
            params: self.clone(),
            route: Route::default(),
            following: None,
            scans: Vec::new(),
            hits: Vec::new(),
            first_call: None,
            nearest_to_end: None,
        }))
    }
}

impl Avoider for FollowGap {
    fn steer(&mut self, cx: &mut Cx<'_>, input: &AvoidInput<'_>) -> Result<Steering, AvoidError> {
        check(input)?;
        self.look(cx.now, input);
        let Some(path) = input.path else {
            self.following = None;
            return Ok(Steering::Drive(Twist::ZERO));
        };
        if self.following != Some(input.path_number) {
            self.following = Some(input.path_number);
            self.route.follow(path);
            self.nearest_to_end = None;
        }
        let robot: Point2 = input.map_from_base.translation.vector.into();
        let end = path.end();
        if (end.position - robot).norm() <= input.arrival_radius_m {
            return Ok(look_along(end.yaw_rad, input));
        }
        if !self.has_fresh_scan(cx.now)? {
            return Ok(Steering::Drive(Twist::ZERO));
        }
        let ahead = self.route.ahead(robot, self.params.look_ahead_m);
        if self.is_stuck(cx.now, ahead.left_m) {
            return Ok(self.blocked(cx.now, input));
        }
        let target = input.map_from_base.inverse() * ahead.target;
        let Some(way_rad) = self.gap(target, input.robot) else { return Ok(self.blocked(cx.now, input)) };
        Ok(Steering::Drive(self.twist(way_rad, ahead.left_m, input.robot)))
    }
}

impl FollowGap {
    /// Keeps the newest scan of every scanner.
    fn look(&mut self, now: Time, input: &AvoidInput<'_>) {
        let odom_from_base = flatten(&input.estimate.map_from_odom).inverse() * input.map_from_base;
        for (observation, scan) in input.seen.laser_scans().filter(|(observation, _)| observation.valid) {
            if scan.check().is_err() {
                continue;
            }
            // Where the robot was when it saw this: back along its present velocity.
            let age_s = (now - observation.stamp).as_secs().clamp(0.0, STALE_S);
            let odom_from_base_then = odom_from_base * input.twist.integrate(-age_s);
            let odom_from_sensor = odom_from_base_then * flatten(&observation.base_from_sensor);
            let near = scan.hits().filter(|(_, range_m)| *range_m <= SEES_M);
            let in_odom = near.map(|(bearing_rad, range_m)| {
                odom_from_sensor * Point2::new(range_m * bearing_rad.cos(), range_m * bearing_rad.sin())
            });
            let at = self.scans.iter().position(|scan| scan.sensor == observation.sensor);
            let at = at.unwrap_or_else(|| {
                let (sensor, stamp) = (observation.sensor, Time(i64::MIN));
                self.scans.push(Scan { sensor, stamp, hits_in_odom: Vec::new() });
                self.scans.len() - 1
            });
            if let Some(kept) = self.scans.get_mut(at).filter(|kept| kept.stamp < observation.stamp) {
                kept.stamp = observation.stamp;
                kept.hits_in_odom.clear();
                kept.hits_in_odom.extend(in_odom);
            }
        }
        self.hits.clear();
        let base_from_odom = odom_from_base.inverse();
        self.hits
            .extend(self.scans.iter().flat_map(|scan| &scan.hits_in_odom).map(|hit| base_from_odom * hit));
    }

    /// Every scanner that ever gave a scan still does; false while the first is waited for.
    fn has_fresh_scan(&mut self, now: Time) -> Result<bool, AvoidError> {
        let first_call = *self.first_call.get_or_insert(now);
        let oldest = self.scans.iter().map(|scan| scan.stamp).min();
        let age_s = (now - oldest.unwrap_or(first_call)).as_secs();
        if age_s > STALE_S {
            return Err(AvoidError::NoReading { kind: "laser scan", age_s });
        }
        Ok(oldest.is_some())
    }

    fn is_stuck(&mut self, now: Time, left_m: f64) -> bool {
        let (nearest_m, since) = *self.nearest_to_end.get_or_insert((left_m, now));
        if left_m < nearest_m - PROGRESS_M {
            self.nearest_to_end = Some((left_m, now));
            return false;
        }
        now - since > Span::from_secs(self.params.stuck_after_s)
    }

    /// The way to go, radians from straight ahead: with comfort where there is such a gap, else as narrow as the guard lets
    /// through.
    fn gap(&self, target: Point2, robot: &Robot) -> Option<f64> {
        let (wanted_rad, length_m) = (target.y.atan2(target.x), target.coords.norm());
        let least_m = least_half_width_m(robot);
        let comfortable_m = robot.hull().outer_radius_m() + self.params.side_clearance_m;
        let max_detour_rad = self.params.max_detour_deg.to_radians();
        [comfortable_m.max(least_m), least_m].into_iter().find_map(|half_width_m| {
            direction(&self.hits, wanted_rad, length_m, &Room { half_width_m, max_detour_rad })
        })
    }

    /// Turns to the way, and goes as fast as the brakes and what is beside allow.
    fn twist(&self, way_rad: f64, left_m: f64, robot: &Robot) -> Twist {
        let way_rad = wrap_angle(way_rad);
        let fastest_turn = robot.max_turn_rad_s();
        let turn_rad_s = (TURN_GAIN * way_rad).clamp(-fastest_turn, fastest_turn);
        if way_rad.abs() > TURNS_FIRST_RAD {
            return Twist::new(0.0, turn_rad_s);
        }
        // The robot moves where it looks, not yet where it wants to go: both ways must be free.
        let half_width_m = least_half_width_m(robot);
        let free_m = free_m(&self.hits, way_rad, half_width_m).min(free_m(&self.hits, 0.0, half_width_m));
        let beside_m = (nearest_m(&self.hits) - robot.hull().outer_radius_m()).max(0.0);
        let share =
            if beside_m < self.params.slow_within_m { beside_m / self.params.slow_within_m } else { 1.0 };
        let speed_m_s = (robot.max_speed_m_s * share.max(0.25))
            .min(braked_m_s(free_m, robot))
            .min((2.0 * robot.braking_m_s2 * left_m).sqrt());
        Twist::new(speed_m_s * way_rad.cos(), turn_rad_s)
    }

    /// Says what stands near and is not on the map, and stops.
    fn blocked(&mut self, now: Time, input: &AvoidInput<'_>) -> Steering {
        let reach_m = self.params.look_ahead_m + input.robot.hull().outer_radius_m();
        let near = self.hits.iter().filter(|hit| hit.x > 0.0 && hit.coords.norm() <= reach_m);
        let in_map = near.map(|hit| input.map_from_base * hit);
        let unknown = in_map.filter(|hit| !input.map.grid.as_ref().is_some_and(|grid| is_mapped(grid, *hit)));
        let obstacles = unknown.map(|position| Obstacle { position, radius_m: 0.0, stamp: now }).collect();
        self.nearest_to_end = None;
        Steering::Blocked { obstacles }
    }
}

/// Half of the narrowest way that the guard lets the robot through.
fn least_half_width_m(robot: &Robot) -> f64 {
    robot.hull().outer_radius_m() + robot.guard.margin_m + TO_SPARE_M
}

/// The speed from which the robot stops within this distance, its reaction included.
fn braked_m_s(free_m: f64, robot: &Robot) -> f64 {
    let reaction = robot.braking_m_s2 * robot.guard.latency_s;
    let left_m = (free_m - TO_SPARE_M).max(0.0);
    ((reaction.powi(2) + 2.0 * robot.braking_m_s2 * left_m).sqrt() - reaction).max(0.0)
}

/// At the end of the path: the robot has arrived when it also looks as it shall.
fn look_along(yaw_rad: Option<f64>, input: &AvoidInput<'_>) -> Steering {
    let off_rad = yaw_rad.map_or(0.0, |yaw_rad| wrap_angle(yaw_rad - input.map_from_base.rotation.angle()));
    if off_rad.abs() <= HEADING_WITHIN_RAD {
        return Steering::Arrived;
    }
    let fastest = input.robot.max_turn_rad_s();
    Steering::Drive(Twist::new(0.0, (TURN_GAIN * off_rad).clamp(-fastest, fastest)))
}

/// An occupied cell of the map is near: a new path knows of it already.
fn is_mapped(grid: &Grid, hit: Point2) -> bool {
    let reach = (MAPPED_WITHIN_M / grid.resolution_m()).ceil() as u32;
    let Some(Cell { col, row }) = grid.cell_at(hit) else { return false };
    let mut cells = (row.saturating_sub(reach)..=row + reach)
        .flat_map(|row| (col.saturating_sub(reach)..=col + reach).map(move |col| Cell { col, row }));
    cells.any(|cell| {
        grid.class(cell) == CellClass::Occupied && (grid.center_of(cell) - hit).norm() <= MAPPED_WITHIN_M
    })
}

/// Numbers that are none end here.
fn check(input: &AvoidInput<'_>) -> Result<(), AvoidError> {
    input.twist.check()?;
    let finite = |pose: &Pose2, field: &'static str| {
        let (message, expected) = ("avoid_input", "finite numbers");
        let fault = || MessageFault { message, field, found: pose.to_string(), expected };
        if is_finite2(pose) { Ok(()) } else { Err(fault()) }
    };
    finite(&input.map_from_base, "map_from_base")?;
    finite(&flatten(&input.estimate.map_from_odom), "map_from_odom")?;
    input.path.map_or(Ok(()), Check::check)?;
    Ok(())
}

rumbo_core::register_avoider!(
    FollowGapParams,
    "follow_gap",
    "goes through the gap between obstacles that is nearest to the path's direction"
);

#[cfg(test)]
mod tests;
