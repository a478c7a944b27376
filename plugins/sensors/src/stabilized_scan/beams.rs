//! Which beams of a tilted scan say something about the walls around (specification of the disaster robot, section 5.2).

use nalgebra::Vector3;
use rumbo_core::frames::Pose3;
use rumbo_core::messages::LaserScan;

/// Limits of readings.
#[derive(Debug, Clone, Copy)]
pub struct BeamRules {
    /// Readings are longer than this, meters.
    pub min_range_m: Option<f32>,
    /// And shorter than this, meters.
    pub max_range_m: Option<f32>,
    /// Behind the laser, nearer ones are the robot, meters.
    pub self_filter_m: Option<f32>,
    /// Heights from the laser's own, meters.
    pub heights_m: [f64; 2],
    /// Lower over the floor is the floor, meters.
    pub floor_m: f64,
    /// Sine of the angle by which the tilt may be wrong.
    pub tilt_margin_sine: f64,
}

/// What became of the beams of one scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Readings that are kept.
    pub n_hits: u32,
    /// Directions in which nothing is within reach, that are kept.
    pub n_free: u32,
    /// Too near, too far, below zero, or the robot itself.
    pub n_by_range: u32,
    /// Too low or too high, the floor among them.
    pub n_by_height: u32,
}

/// How a laser is tilted and how high it is, in the level frame.
#[derive(Debug, Clone, Copy)]
pub struct Tilt {
    /// The upward share of the laser's own axes.
    up: Vector3<f64>,
    height_m: f64,
}

impl Tilt {
    /// Of a laser that sits here in the level frame, whose floor is at zero.
    pub fn of(stabilized_from_sensor: &Pose3) -> Tilt {
        let up = stabilized_from_sensor.rotation.inverse() * Vector3::z();
        Tilt { up, height_m: stabilized_from_sensor.translation.z }
    }
}

/// What a beam is worth.
enum Worth {
    Kept(f32),
    OutOfRange,
    OutOfHeight,
    Nothing,
}

impl BeamRules {
    /// Calls `change` with each beam that does not stay as it is, and its new range.
    pub fn apply(&self, scan: &LaserScan, tilt: &Tilt, mut change: impl FnMut(usize, f32)) -> Tally {
        let mut tally = Tally::default();
        for (idx, range_m) in scan.ranges_m.iter().enumerate() {
            let kept_m = match self.worth(scan, idx, *range_m, tilt) {
                Worth::Kept(kept_m) => {
                    let count = if kept_m.is_finite() { &mut tally.n_hits } else { &mut tally.n_free };
                    *count += 1;
                    kept_m
                }
                Worth::OutOfRange => {
                    tally.n_by_range += 1;
                    f32::NAN
                }
                Worth::OutOfHeight => {
                    tally.n_by_height += 1;
                    f32::NAN
                }
                Worth::Nothing => *range_m,
            };
            if kept_m.to_bits() != range_m.to_bits() && !(kept_m.is_nan() && range_m.is_nan()) {
                change(idx, kept_m);
            }
        }
        tally
    }

    fn worth(&self, scan: &LaserScan, idx: usize, range_m: f32, tilt: &Tilt) -> Worth {
        // Nearer than the laser's least range is no reading, and may still tell an avoider that something is there.
        if range_m.is_nan() || (0.0..scan.min_range_m).contains(&range_m) {
            return Worth::Nothing;
        }
        // REP-117: a finite reading beyond the device's reach says that nothing is within it.
        let range_m = if range_m > scan.max_range_m { f32::INFINITY } else { range_m };
        let (sine, cosine) = scan.bearing_rad(idx).sin_cos();
        let is_finite = range_m.is_finite();
        let is_own = self.self_filter_m.is_some_and(|own_m| cosine < -1e-9 && range_m < own_m);
        let is_short = range_m < 0.0 || self.min_range_m.is_some_and(|least_m| range_m <= least_m);
        let is_long = is_finite && self.max_range_m.is_some_and(|most_m| range_m >= most_m);
        if is_own || is_short || is_long {
            return Worth::OutOfRange;
        }
        let rises = tilt.up.x * cosine + tilt.up.y * sine;
        let length_m = f64::from(if is_finite { range_m } else { scan.max_range_m });
        let [lowest_m, highest_m] = self.heights_m;
        let rise_m = rises * length_m;
        let is_level = (lowest_m..=highest_m).contains(&rise_m);
        let floor_m = self.floor_m + length_m * self.tilt_margin_sine;
        let is_floor = rises < -self.tilt_margin_sine && tilt.height_m + rise_m < floor_m;
        if is_level && !is_floor { Worth::Kept(range_m) } else { Worth::OutOfHeight }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion};

    const RULES: BeamRules = BeamRules {
        min_range_m: Some(0.4),
        max_range_m: Some(30.0),
        self_filter_m: None,
        heights_m: [-1.0, 1.0],
        floor_m: 0.05,
        tilt_margin_sine: 0.0,
    };

    /// Beams ahead, to the left, behind, to the right.
    fn scan(ranges_m: [f32; 4]) -> LaserScan {
        LaserScan {
            first_bearing_rad: 0.0,
            bearing_step_rad: std::f64::consts::FRAC_PI_2,
            max_range_m: 80.0,
            ranges_m: ranges_m.to_vec().into(),
            ..LaserScan::default()
        }
    }

    fn tilted(roll_rad: f64, pitch_rad: f64) -> Tilt {
        let turn = UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, 0.0);
        Tilt::of(&(turn * Pose3::from_parts(Translation3::new(0.0, 0.0, 0.5), UnitQuaternion::identity())))
    }

    fn kept(rules: &BeamRules, ranges_m: [f32; 4], tilt: &Tilt) -> ([f32; 4], Tally) {
        let mut after = ranges_m;
        let tally = rules.apply(&scan(ranges_m), tilt, |idx, range_m| after[idx] = range_m);
        (after, tally)
    }

    #[test]
    fn limits_are_strict_and_what_is_no_reading_stays_none() {
        let level = tilted(0.0, 0.0);
        let (after, tally) = kept(&RULES, [0.4, 30.0, f32::NAN, 81.0], &level);
        assert!(after[0].is_nan() && after[1].is_nan() && after[2].is_nan());
        assert_eq!((after[3], tally.n_free, tally.n_by_range, tally.n_hits), (f32::INFINITY, 1, 2, 0));
        let (after, tally) = kept(&RULES, [0.41, 29.9, f32::INFINITY, -1.0], &level);
        assert_eq!(after[..3], [0.41, 29.9, f32::INFINITY]);
        assert!(after[3].is_nan());
        assert_eq!(tally, Tally { n_hits: 2, n_free: 1, n_by_range: 1, n_by_height: 0 });
    }

    #[test]
    fn the_robot_itself_is_behind_and_near() {
        let rules = BeamRules { self_filter_m: Some(0.707), ..RULES };
        let (after, _) = kept(&rules, [0.6; 4], &tilted(0.0, 0.0));
        assert_eq!(after.map(f32::is_nan), [false, false, true, false]);
        assert!(!kept(&rules, [0.8; 4], &tilted(0.0, 0.0)).0[2].is_nan());
    }

    /// A laser half a meter high that looks down by 0.1 rad meets the floor after 5 m.
    #[test]
    fn beams_that_end_on_the_floor_or_over_the_walls_are_dropped() {
        let (sine, cosine) = 0.1f64.sin_cos();
        let floor_m = (0.5 * cosine / sine) as f32;
        let tilt = tilted(0.0, 0.1);
        let (after, tally) = kept(&RULES, [floor_m, 9.0, 9.0, 9.0], &tilt);
        assert_eq!(after.map(f32::is_nan), [true, false, false, false]);
        assert_eq!(tally.n_by_height, 1);
        // A wall in front of that is seen at 4 m: the beam is 0.1 m over the floor there.
        assert_eq!(kept(&RULES, [4.0; 4], &tilt).0, [4.0; 4]);
        // Behind, 1.2 m over the laser; and a beam that meets nothing up there clears no walls.
        assert!(kept(&RULES, [1.0, 1.0, 12.0, 1.0], &tilt).0[2].is_nan());
        assert!(kept(&RULES, [1.0, 1.0, f32::INFINITY, 1.0], &tilt).0[2].is_nan());
        // Rolled to the right, the right one meets the floor.
        assert_eq!(kept(&RULES, [5.0; 4], &tilted(0.1, 0.0)).0.map(f32::is_nan), [false, false, false, true]);
    }

    #[test]
    fn with_a_margin_the_floor_comes_nearer_but_never_to_a_level_beam() {
        let rules = BeamRules { tilt_margin_sine: 0.02, ..RULES };
        assert!(kept(&rules, [4.0; 4], &tilted(0.0, 0.1)).0[0].is_nan());
        assert_eq!(kept(&rules, [29.0; 4], &tilted(0.0, 0.015)).0, [29.0; 4]);
    }
}
