//! What was found in the way and is not on the map: kept for one goal.

use crate::frames::{Point2, Pose2};
use crate::map::Grid;
use crate::messages::{Data, LaserScan, Observation, Obstacle};
use crate::pipeline::Mission;
use crate::time::{Span, Time};

/// Obstacles of the present goal.
#[derive(Debug)]
pub struct ObstacleMemory {
    obstacles: Vec<Obstacle>,
    keep_for: Span,
    forget_seen_through: bool,
}

impl ObstacleMemory {
    /// Two points nearer than this are the same obstacle where there is no grid, meters.
    const SAME_M: f64 = 0.05;
    /// No more than this are remembered.
    const MOST: usize = 50_000;
    /// A beam that goes this far beyond an obstacle's middle has seen through it, meters.
    const BEYOND_M: f64 = 0.15;

    /// What is nearer than this to the robot's middle is beside it, meters.
    const BESIDE_M: f64 = 1.0;

    /// Nothing remembered.
    pub fn new(mission: &Mission) -> ObstacleMemory {
        ObstacleMemory {
            obstacles: Vec::new(),
            keep_for: Span::from_secs(mission.obstacle_memory_s),
            forget_seen_through: mission.forget_seen_through,
        }
    }

    /// All of them.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.obstacles.clear();
    }

    /// Remembers these; one that is known already is only seen again.
    pub fn add(&mut self, found: &[Obstacle], grid: Option<&Grid>) {
        for obstacle in found {
            let same = |known: &&mut Obstacle| match grid {
                Some(grid) => {
                    known.radius_m >= obstacle.radius_m
                        && grid.cell_at(known.position) == grid.cell_at(obstacle.position)
                }
                None => (known.position - obstacle.position).norm() < Self::SAME_M,
            };
            if let Some(known) = self.obstacles.iter_mut().find(same) {
                known.stamp = known.stamp.max(obstacle.stamp);
            } else if self.obstacles.len() < Self::MOST {
                self.obstacles.push(*obstacle);
            }
        }
    }

    /// Removes what this observation, made from `map_from_base`, sees through. Returns how many.
    pub fn look(&mut self, observation: &Observation, map_from_base: &Pose2) -> usize {
        let (Data::LaserScan(scan), true) = (&observation.data, self.forget_seen_through) else { return 0 };
        let map_from_sensor = map_from_base * crate::frames::flatten(&observation.base_from_sensor);
        let before = self.obstacles.len();
        self.obstacles.retain_mut(|obstacle| {
            if obstacle.stamp >= observation.stamp {
                return true;
            }
            let in_sensor = map_from_sensor.inverse() * obstacle.position;
            match sight(scan, in_sensor, obstacle.radius_m) {
                Sight::Through => return false,
                Sight::There => obstacle.stamp = observation.stamp,
                Sight::Hidden => {}
            }
            true
        });
        before - self.obstacles.len()
    }

    /// Whether waiting can change anything: something is remembered, and sensors may see that it is gone.
    pub fn may_change(&self) -> bool {
        self.forget_seen_through && !self.obstacles.is_empty()
    }

    /// Removes what is beside the robot and was not seen since: who walks by leaves the field of view, and nothing ever
    /// sees through the place where he was. Returns how many.
    pub fn forget_unseen(&mut self, position: Point2, since: Time) -> usize {
        let before = self.obstacles.len();
        let is_beside =
            |obstacle: &Obstacle| (obstacle.position - position).norm() - obstacle.radius_m <= Self::BESIDE_M;
        self.obstacles.retain(|obstacle| obstacle.stamp >= since || !is_beside(obstacle));
        before - self.obstacles.len()
    }

    /// Removes what nothing has seen for long. Returns how many.
    pub fn forget_old(&mut self, now: Time) -> usize {
        let before = self.obstacles.len();
        let keep_for = self.keep_for;
        self.obstacles.retain(|obstacle| now - obstacle.stamp <= keep_for);
        before - self.obstacles.len()
    }
}

/// What a scan says of an obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sight {
    /// Both beams next to its middle read farther.
    Through,
    /// One of them ends at it.
    There,
    /// Something is before it, or no beam goes there.
    Hidden,
}

fn sight(scan: &LaserScan, in_sensor: Point2, radius_m: f64) -> Sight {
    let distance_m = in_sensor.coords.norm();
    let beam = (in_sensor.y.atan2(in_sensor.x) - scan.first_bearing_rad) / scan.bearing_step_rad;
    if !beam.is_finite() || beam < 0.0 {
        return Sight::Hidden;
    }
    let tolerance_m = radius_m + ObstacleMemory::BEYOND_M;
    let beyond_m = [beam.floor(), beam.ceil()].map(|idx| {
        let range = scan.ranges_m.get(idx as usize).copied().unwrap_or(f32::NAN);
        // Nothing within reach says as much as the reach, and not-a-number says nothing.
        let reads_m = if range.is_nan() { f64::NAN } else { f64::from(range.min(scan.max_range_m)) };
        reads_m - distance_m
    });
    if beyond_m.iter().all(|beyond_m| *beyond_m > tolerance_m) {
        Sight::Through
    } else if beyond_m.iter().any(|beyond_m| beyond_m.abs() <= tolerance_m) {
        Sight::There
    } else {
        Sight::Hidden
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::Buffer;
    use crate::frames::{Pose3, pose2};
    use crate::messages::SensorId;

    fn scan(stamp: i64, range_m: f32) -> Observation {
        let scan = LaserScan {
            first_bearing_rad: -1.0,
            bearing_step_rad: 0.5,
            max_range_m: 8.0,
            ranges_m: Buffer::filled(5, range_m),
            ..LaserScan::default()
        };
        Observation {
            sensor: SensorId(0),
            stamp: Time(stamp),
            base_from_sensor: Pose3::identity(),
            valid: true,
            data: Data::LaserScan(scan),
        }
    }

    fn memory_with(x: f64, y: f64, stamp: i64) -> ObstacleMemory {
        let mut memory = ObstacleMemory::new(&Mission::default());
        memory.add(&[Obstacle { position: Point2::new(x, y), radius_m: 0.0, stamp: Time(stamp) }], None);
        memory
    }

    #[test]
    fn an_obstacle_stays_until_a_later_beam_goes_beyond_it() {
        let here = pose2(0.0, 0.0, 0.0);
        assert_eq!(memory_with(2.0, 0.1, 5).look(&scan(9, 2.1), &here), 0, "stands where it stood");
        assert_eq!(memory_with(2.0, 0.1, 5).look(&scan(9, 4.0), &here), 1, "gone");
        assert_eq!(memory_with(2.0, 0.1, 5).look(&scan(9, f32::INFINITY), &here), 1, "nothing within reach");
        assert_eq!(memory_with(2.0, 0.1, 5).look(&scan(9, f32::NAN), &here), 0, "no reading says nothing");
        assert_eq!(memory_with(2.0, 0.1, 5).look(&scan(5, 4.0), &here), 0, "not later");
        assert_eq!(memory_with(-2.0, 0.1, 5).look(&scan(9, 4.0), &here), 0, "behind the scanner");
        assert_eq!(memory_with(9.0, 0.1, 5).look(&scan(9, f32::INFINITY), &here), 0, "out of reach");
    }

    #[test]
    fn what_a_beam_still_meets_counts_as_seen_and_what_passed_the_robot_by_is_forgotten() {
        let here = pose2(0.0, 0.0, 0.0);
        let left = |x: f64, y: f64, range_m: f32| {
            let mut memory = memory_with(x, y, 5);
            memory.look(&scan(9, range_m), &here);
            memory.forget_unseen(Point2::origin(), Time(9));
            memory.obstacles().len()
        };
        assert_eq!(left(0.8, 0.1, 0.7), 1, "still there");
        assert_eq!(left(0.8, 0.1, 0.3), 0, "hidden");
        assert_eq!(left(-0.8, 0.1, 0.7), 0, "behind the scanner");
        assert_eq!(left(-1.2, 0.1, 0.7), 1, "not beside the robot");
        assert_eq!(left(0.8, 0.1, f32::NAN), 0, "no reading sees nothing");
    }

    #[test]
    fn waiting_is_of_use_only_where_something_may_go_away() {
        assert!(memory_with(1.0, 0.0, 5).may_change());
        assert!(!ObstacleMemory::new(&Mission::default()).may_change());
        let mut by_age = ObstacleMemory::new(&Mission { forget_seen_through: false, ..Mission::default() });
        by_age.add(&[Obstacle { position: Point2::origin(), radius_m: 0.0, stamp: Time(5) }], None);
        assert!(!by_age.may_change());
    }

    #[test]
    fn points_of_one_cell_are_one_obstacle_and_age_together() {
        let grid = Grid::unknown(10, 10, 1.0).unwrap();
        let mut memory = memory_with(2.1, 2.1, 5);
        memory
            .add(&[Obstacle { position: Point2::new(2.9, 2.9), radius_m: 0.0, stamp: Time(8) }], Some(&grid));
        assert_eq!((memory.obstacles().len(), memory.obstacles()[0].stamp), (1, Time(8)));
        assert_eq!(memory.forget_old(Time::from_secs(60.0)), 0);
        assert_eq!(memory.forget_old(Time::from_secs(61.0)), 1);
    }
}
