//! Parameters, and their translation into the numbers of control and watch.

use super::front_watch::WatchTuning;
use super::lane::LaneTuning;
use super::meeting::MeetingTuning;
use super::people::PeopleParams;
use super::sound_watch::SoundTuning;
use super::speed_profile::SpeedProfile;
use super::tuning::Tuning;
use rumbo_core::robot::Robot;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Turns in place, drives straight, stops in front of what is not on the map and asks for a new path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct StopAndReplanParams {
    /// Behave as published (Hernández Alamilla 2005): switches off `ignore_expected`, `look_ahead_m`, `sonar_decay_s`,
    /// `heading_gain_per_s`, `keep_off_m`, `merge_within_cells` and `people`, stops at `stop_distance_m` at any speed, and reports
    /// obstacles only inside the watched strip.
    pub thesis_mode: bool,
    /// Least, medium and greatest speed of a straight piece, m/s; the robot's own limit caps them.
    pub linear_speeds_m_s: [f64; 3],
    /// Way after which the medium and the greatest speed begin, and before the end of which they cease, meters.
    pub linear_ramps_m: [f64; 2],
    /// Least, medium and greatest rate of a turn in place, degrees per second; the robot's own limit caps them.
    pub turn_speeds_deg_s: [f64; 3],
    /// Turn after which the medium and the greatest rate begin, and before the end of which they cease, degrees.
    pub turn_ramps_deg: [f64; 2],
    /// A checkpoint nearer than this is reached, meters; the last one has the mission's arrival radius.
    pub checkpoint_radius_m: f64,
    /// A heading nearer than this is reached, degrees.
    pub heading_tolerance_deg: f64,
    /// A heading error beyond this stops the robot for another turn, degrees.
    pub max_heading_error_deg: f64,
    /// A distance from the straight piece beyond this stops the robot for another turn, meters.
    pub max_lateral_error_m: f64,
    /// Correction of the heading while driving, degrees per second for each degree of error; 0 for none.
    pub heading_gain_per_s: f64,
    /// Points of the path this near to a straight piece are no checkpoints, cells of the map: planners on a grid make
    /// staircases of slanting ways.
    pub merge_within_cells: f64,
    /// Room between the hull and what the scanner sees beside it, meters: a robot that drives gives way to keep it, up to
    /// 0.8 of `max_lateral_error_m`; 0 for never. More than the guard's margin.
    pub keep_off_m: f64,
    /// The source's M: an unexpected reading nearer than this stops the robot, meters. Laser ranges count from the
    /// scanner, sonar ranges from the transducer. A fast robot stops earlier, as far away as its brakes need.
    pub stop_distance_m: f64,
    /// The source's V: width of the strip ahead in which laser hits count, meters. More than the robot, less than a door.
    pub watched_width_m: f64,
    /// Sonar echoes are fused over time: three that agree on a place are an obstacle there, and after so long without
    /// another it is forgotten, seconds. An echo that is not sure yet makes a driving robot wait for the next reading. 0
    /// does as published: a single echo of a front sonar nearer than `stop_distance_m` is an obstacle.
    pub sonar_decay_s: f64,
    /// Sonars whose axes are within this of straight ahead are fused, degrees. A pane answers only to a sonar that meets it
    /// squarely: those ahead alone miss a pane that stands aslant in the way, and those beside hear how far it goes on.
    /// What is heard nearer than `stop_distance_m` stops the robot only within 60 degrees of straight ahead.
    pub sonar_within_deg: f64,
    /// The front sonars are those whose axes are within this of straight ahead, degrees: where echoes are not fused, only
    /// they count.
    pub front_sonar_within_deg: f64,
    /// Readings that the map (with the obstacles known so far) explains stop the robot only below the hard limits.
    pub ignore_expected: bool,
    /// A laser hit this near to an occupied cell, or an echo not shorter than the map's by more, is expected, meters.
    pub expected_within_m: f64,
    /// An expected laser hit in the robot's way nearer than this stops it, meters.
    pub hard_limit_laser_m: f64,
    /// An expected sonar echo in the robot's way nearer than this stops it, meters.
    pub hard_limit_sonar_m: f64,
    /// An unexpected obstacle in the way to the next checkpoint is noticed this far ahead, meters; 0 for only at
    /// `stop_distance_m`. Less than `insertion_range_m`, so that what is noticed is reported with its sides.
    pub look_ahead_m: f64,
    /// Unexpected laser hits and echoes up to this far are reported as obstacles, meters.
    pub insertion_range_m: f64,
    /// Width of the strip ahead in which unexpected hits are reported, meters. Wider than the watched strip, so that one
    /// new path goes around the whole obstacle.
    pub insertion_width_m: f64,
    /// What is done about people who walk: they are followed by the scanner, and are no obstacles that stand.
    pub people: PeopleParams,
    /// A range reading older than this stops the robot while it drives, seconds. Must exceed the time between two
    /// readings of the slowest range sensor.
    pub stale_after_s: f64,
    /// A robot that hardly moves for this long although it should is blocked, seconds.
    pub stuck_after_s: f64,
}

impl Default for StopAndReplanParams {
    fn default() -> Self {
        StopAndReplanParams {
            thesis_mode: false,
            linear_speeds_m_s: [0.05, 0.10, 0.20],
            linear_ramps_m: [0.10, 0.30],
            turn_speeds_deg_s: [2.8, 5.7, 8.5],
            turn_ramps_deg: [5.0, 15.0],
            checkpoint_radius_m: 0.05,
            heading_tolerance_deg: 1.0,
            max_heading_error_deg: 5.0,
            max_lateral_error_m: 0.10,
            heading_gain_per_s: 1.0,
            merge_within_cells: 0.8,
            keep_off_m: 0.08,
            stop_distance_m: 0.30,
            watched_width_m: 0.60,
            sonar_decay_s: 10.0,
            sonar_within_deg: 100.0,
            front_sonar_within_deg: 23.0,
            ignore_expected: true,
            expected_within_m: 0.10,
            hard_limit_laser_m: 0.23,
            hard_limit_sonar_m: 0.05,
            look_ahead_m: 0.7,
            insertion_range_m: 1.0,
            insertion_width_m: 2.0,
            people: PeopleParams::default(),
            stale_after_s: 1.0,
            stuck_after_s: 3.0,
        }
    }
}

impl StopAndReplanParams {
    /// These parameters with the extensions switched off where thesis mode says so.
    pub fn effective(&self) -> StopAndReplanParams {
        if !self.thesis_mode {
            return self.clone();
        }
        StopAndReplanParams {
            ignore_expected: false,
            look_ahead_m: 0.0,
            sonar_decay_s: 0.0,
            heading_gain_per_s: 0.0,
            merge_within_cells: 0.0,
            keep_off_m: 0.0,
            insertion_width_m: self.watched_width_m,
            people: PeopleParams { horizon_s: 0.0, ..self.people },
            ..self.clone()
        }
    }

    /// The numbers of the control for this robot, steered every `period_s`.
    pub fn tuning(&self, robot: &Robot, period_s: f64) -> Tuning {
        // The guard brakes with the robot's acceleration; a part is left for what it does not follow exactly.
        const FOLLOWED: f64 = 0.8;
        let straight = SpeedProfile { levels: self.linear_speeds_m_s, ramps: self.linear_ramps_m };
        let turn = SpeedProfile {
            levels: self.turn_speeds_deg_s.map(f64::to_radians),
            ramps: self.turn_ramps_deg.map(f64::to_radians),
        };
        Tuning {
            straight: straight.capped(robot.max_speed_m_s),
            turn: turn.capped(robot.max_turn_rad_s()),
            period_s,
            slowing_m_s2: FOLLOWED * robot.max_accel_m_s2.min(robot.braking_m_s2),
            slowing_rad_s2: FOLLOWED * robot.max_turn_accel_rad_s2(),
            checkpoint_radius_m: self.checkpoint_radius_m,
            heading_tolerance_rad: self.heading_tolerance_deg.to_radians(),
            max_heading_error_rad: self.max_heading_error_deg.to_radians(),
            max_lateral_error_m: self.max_lateral_error_m,
            heading_gain_per_s: self.heading_gain_per_s,
        }
    }

    /// The numbers of the watch for this robot.
    pub fn watch(&self, robot: &Robot) -> WatchTuning {
        WatchTuning {
            stop_distance_m: self.stop_distance_m,
            watched_width_m: self.watched_width_m,
            front_sonar_within_rad: self.front_sonar_within_deg.to_radians(),
            heeds_single_echoes: self.sonar_decay_s == 0.0,
            ignores_expected: self.ignore_expected,
            expected_within_m: self.expected_within_m,
            hard_limit_laser_m: self.hard_limit_laser_m,
            hard_limit_sonar_m: self.hard_limit_sonar_m,
            half_hull_m: half_hull_m(robot),
            look_ahead_m: self.look_ahead_m,
            insertion_range_m: self.insertion_range_m,
            insertion_width_m: self.insertion_width_m,
        }
    }

    /// The numbers of the watch by sound for this robot; none where echoes are not fused.
    pub fn sound(&self, robot: &Robot) -> Option<SoundTuning> {
        (self.sonar_decay_s > 0.0).then(|| SoundTuning {
            within_rad: self.sonar_within_deg.to_radians(),
            reach_m: self.insertion_range_m,
            decay_s: self.sonar_decay_s,
            expected_within_m: self.expected_within_m,
            hull_radius_m: robot.hull().outer_radius_m(),
            half_hull_m: half_hull_m(robot),
            look_ahead_m: self.look_ahead_m,
        })
    }

    /// The numbers of meetings with people; none where they are obstacles like others.
    pub fn meeting(&self, robot: &Robot) -> Option<MeetingTuning> {
        (self.people.horizon_s > 0.0).then(|| {
            let back_m_s = self.linear_speeds_m_s[1].min(robot.max_speed_m_s);
            self.people.tuning(robot, self.expected_within_m, back_m_s)
        })
    }

    /// The room beside this robot.
    pub fn lane(&self, robot: &Robot) -> LaneTuning {
        LaneTuning { half_hull_m: half_hull_m(robot), keep_off_m: self.keep_off_m }
    }

    /// Every impossible value at once.
    pub fn faults(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        let levels =
            [("linear_speeds_m_s", self.linear_speeds_m_s), ("turn_speeds_deg_s", self.turn_speeds_deg_s)];
        for (key, [least, medium, greatest]) in levels {
            if !(least > 0.0 && least <= medium && medium <= greatest && greatest.is_finite()) {
                let wrong = format!("is [{least}, {medium}, {greatest}], expected rising numbers above zero");
                faults.push(BuildError::at(key, wrong));
            }
        }
        for (key, [near, far]) in
            [("linear_ramps_m", self.linear_ramps_m), ("turn_ramps_deg", self.turn_ramps_deg)]
        {
            if !(near >= 0.0 && near <= far && far.is_finite()) {
                let wrong = format!("is [{near}, {far}], expected two rising numbers of at least zero");
                faults.push(BuildError::at(key, wrong));
            }
        }
        self.number_faults(&mut faults);
        self.people.add_faults(&mut faults);
        if self.heading_tolerance_deg >= self.max_heading_error_deg {
            let (tolerance, most) = (self.heading_tolerance_deg, self.max_heading_error_deg);
            let wrong = format!("is {tolerance}, expected less than max_heading_error_deg ({most})");
            faults.push(BuildError::at("heading_tolerance_deg", wrong));
        }
        faults
    }

    fn number_faults(&self, faults: &mut Vec<BuildError>) {
        let above_zero = [
            ("checkpoint_radius_m", self.checkpoint_radius_m),
            ("heading_tolerance_deg", self.heading_tolerance_deg),
            ("max_heading_error_deg", self.max_heading_error_deg),
            ("max_lateral_error_m", self.max_lateral_error_m),
            ("stop_distance_m", self.stop_distance_m),
            ("watched_width_m", self.watched_width_m),
            ("insertion_range_m", self.insertion_range_m),
            ("insertion_width_m", self.insertion_width_m),
            ("stale_after_s", self.stale_after_s),
            ("stuck_after_s", self.stuck_after_s),
        ];
        let from_zero = [
            ("heading_gain_per_s", self.heading_gain_per_s),
            ("merge_within_cells", self.merge_within_cells),
            ("keep_off_m", self.keep_off_m),
            ("sonar_decay_s", self.sonar_decay_s),
            ("sonar_within_deg", self.sonar_within_deg),
            ("front_sonar_within_deg", self.front_sonar_within_deg),
            ("expected_within_m", self.expected_within_m),
            ("hard_limit_laser_m", self.hard_limit_laser_m),
            ("hard_limit_sonar_m", self.hard_limit_sonar_m),
            ("look_ahead_m", self.look_ahead_m),
        ];
        for (key, value) in above_zero {
            if !(value > 0.0 && value.is_finite()) {
                faults.push(BuildError::at(key, format!("is {value}, expected a finite number above zero")));
            }
        }
        for (key, value) in from_zero {
            if !(value >= 0.0 && value.is_finite()) {
                faults.push(BuildError::at(
                    key,
                    format!("is {value}, expected a finite number of at least zero"),
                ));
            }
        }
    }
}

/// Half the width that the hull sweeps while it drives ahead, meters.
fn half_hull_m(robot: &Robot) -> f64 {
    let corners = robot.footprint_m.iter().map(|[_, y]| y.abs());
    if robot.footprint_m.len() < 3 { robot.radius_m } else { corners.fold(0.0, f64::max) }
}
