//! What was found in the way and is not on the map: kept for one goal.

use super::sight::{Light, NewestScans, Sight, sight};
use crate::frames::{Point2, Pose2};
use crate::map::Grid;
use crate::messages::{Data, Observation, Observations, Obstacle};
use crate::pipeline::Mission;
use crate::time::{Span, Time};

/// Obstacles of the present goal.
///
/// Only what light once met is forgotten because light goes through: a pane of glass that sonar heard, a box below the
/// scanner's plane that a bumper touched stay, however far a laser sees beyond them.
#[derive(Debug)]
pub struct ObstacleMemory {
    obstacles: Vec<Obstacle>,
    /// What light says of each of them.
    lights: Vec<Light>,
    scans: NewestScans,
    keep_for: Span,
    forget_seen_through: bool,
}

impl ObstacleMemory {
    /// Two points nearer than this are the same obstacle where there is no grid, meters.
    const SAME_M: f64 = 0.05;
    /// No more than this are remembered.
    const MOST: usize = 50_000;
    /// What is nearer than this to the robot's middle is beside it, meters.
    const BESIDE_M: f64 = 1.0;

    /// Nothing remembered.
    pub fn new(mission: &Mission) -> ObstacleMemory {
        ObstacleMemory {
            obstacles: Vec::new(),
            lights: Vec::new(),
            scans: NewestScans::default(),
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
        self.lights.clear();
    }

    /// Remembers these; one that is known already is only seen again.
    pub fn add(&mut self, found: &[Obstacle], grid: Option<&Grid>) {
        for obstacle in found {
            let same = |known: &Obstacle| match grid {
                Some(grid) => {
                    known.radius_m >= obstacle.radius_m
                        && grid.cell_at(known.position) == grid.cell_at(obstacle.position)
                }
                None => (known.position - obstacle.position).norm() < Self::SAME_M,
            };
            let light = self.scans.light_at(obstacle);
            let mut known = self.obstacles.iter_mut().zip(&mut self.lights);
            if let Some((known, known_light)) = known.find(|(known, _)| same(known)) {
                known.stamp = known.stamp.max(obstacle.stamp);
                *known_light = known_light.or(light);
            } else if self.obstacles.len() < Self::MOST {
                self.obstacles.push(*obstacle);
                self.lights.push(light);
            }
        }
    }

    /// Removes what this observation, made from `map_from_base`, sees through. Returns how many. Scans that are no longer
    /// the newest go back to the pool.
    pub fn look(
        &mut self,
        observation: &Observation,
        map_from_base: &Pose2,
        pool: &mut Observations,
    ) -> usize {
        let (Data::LaserScan(scan), true) = (&observation.data, self.forget_seen_through) else { return 0 };
        let map_from_sensor = map_from_base * crate::frames::flatten(&observation.base_from_sensor);
        self.scans.keep(observation, &map_from_sensor, pool);
        let sensor_from_map = map_from_sensor.inverse();
        self.retain(|obstacle, light| {
            if obstacle.stamp >= observation.stamp {
                return true;
            }
            match sight(scan, sensor_from_map * obstacle.position, obstacle.radius_m) {
                Sight::Through if *light == Light::Stops => return false,
                Sight::Through => *light = light.or(Light::Passes),
                Sight::There => {
                    *light = light.or(Light::Stops);
                    obstacle.stamp = observation.stamp;
                }
                Sight::Hidden => {}
            }
            true
        })
    }

    /// Keeps those for which `stays` holds. Returns how many go.
    fn retain(&mut self, mut stays: impl FnMut(&mut Obstacle, &mut Light) -> bool) -> usize {
        let before = self.obstacles.len();
        let mut lights = std::mem::take(&mut self.lights);
        let mut n_kept = 0;
        let mut idx = 0;
        self.obstacles.retain_mut(|obstacle| {
            let mut light = lights.get(idx).copied().unwrap_or(Light::Unknown);
            idx += 1;
            let kept = stays(obstacle, &mut light);
            if let (true, Some(place)) = (kept, lights.get_mut(n_kept)) {
                *place = light;
                n_kept += 1;
            }
            kept
        });
        lights.truncate(n_kept);
        self.lights = lights;
        before - self.obstacles.len()
    }

    /// Whether waiting can change anything: something is remembered, and sensors may see that it is gone.
    pub fn may_change(&self) -> bool {
        self.forget_seen_through && !self.obstacles.is_empty()
    }

    /// Removes what is beside the robot and was not seen since: who walks by leaves the field of view, and nothing ever
    /// sees through the place where he was. What light never met does not walk by. Returns how many.
    pub fn forget_unseen(&mut self, position: Point2, since: Time) -> usize {
        let is_beside =
            |obstacle: &Obstacle| (obstacle.position - position).norm() - obstacle.radius_m <= Self::BESIDE_M;
        self.retain(|obstacle, light| {
            *light == Light::Passes || obstacle.stamp >= since || !is_beside(obstacle)
        })
    }

    /// Removes what nothing has seen for long. Returns how many.
    pub fn forget_old(&mut self, now: Time) -> usize {
        let keep_for = self.keep_for;
        self.retain(|obstacle, _| now - obstacle.stamp <= keep_for)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::Buffer;
    use crate::frames::{Pose3, pose2};
    use crate::messages::SensorId;

    fn scan(stamp: i64, range_m: f32) -> Observation {
        let scan = crate::messages::LaserScan {
            first_bearing_rad: -1.0,
            bearing_step_rad: 0.5,
            max_range_m: 8.0,
            ranges_m: Buffer::filled(5, range_m),
            ..crate::messages::LaserScan::default()
        };
        Observation {
            sensor: SensorId(0),
            stamp: Time(stamp),
            base_from_sensor: Pose3::identity(),
            valid: true,
            data: Data::LaserScan(scan),
        }
    }

    /// An obstacle that a beam of `stamp` ended at.
    fn memory_with(x: f64, y: f64, stamp: i64) -> ObstacleMemory {
        let mut memory = ObstacleMemory::new(&Mission::default());
        look(&mut memory, &scan(stamp, f64::hypot(x, y) as f32));
        memory.add(&[Obstacle { position: Point2::new(x, y), radius_m: 0.0, stamp: Time(stamp) }], None);
        memory
    }

    fn look(memory: &mut ObstacleMemory, scan: &Observation) -> usize {
        memory.look(scan, &pose2(0.0, 0.0, 0.0), &mut Observations::default())
    }

    #[test]
    fn what_light_never_met_does_not_go_because_light_goes_through() {
        let pane = |x: f64| Obstacle { position: Point2::new(x, 0.1), radius_m: 0.0, stamp: Time(5) };
        let mut memory = ObstacleMemory::new(&Mission::default());
        look(&mut memory, &scan(4, 4.0));
        memory.add(&[pane(2.0)], None);
        assert_eq!((look(&mut memory, &scan(9, 4.0)), memory.obstacles().len()), (0, 1), "glass");
        assert_eq!(look(&mut memory, &scan(10, 2.0)), 0, "somebody stands there");
        assert_eq!(look(&mut memory, &scan(11, 4.0)), 0, "and left: the pane is still there");
        memory.add(&[pane(-0.3)], None);
        assert_eq!(look(&mut memory, &scan(12, 4.0)), 0);
        assert_eq!(memory.forget_unseen(Point2::new(2.0, 0.0), Time(13)), 0, "panes do not walk by");
        assert_eq!(memory.forget_unseen(Point2::origin(), Time(13)), 1, "no beam went to what is behind");
        assert_eq!(memory.forget_old(Time::from_secs(61.0)), 1, "but nothing stays for ever");
        // Touched behind the scanner's back, and looked at only later.
        let mut memory = ObstacleMemory::new(&Mission::default());
        memory.add(&[pane(2.0)], None);
        assert_eq!((look(&mut memory, &scan(9, 4.0)), look(&mut memory, &scan(12, 4.0))), (0, 0));
        // The scan is too old to say what light does there.
        let mut memory = ObstacleMemory::new(&Mission::default());
        look(&mut memory, &scan(0, 4.0));
        memory.add(&[Obstacle { stamp: Time::from_secs(9.0), ..pane(2.0) }], None);
        assert_eq!(look(&mut memory, &scan(9_100_000_000, 2.0)), 0);
        assert_eq!(look(&mut memory, &scan(9_200_000_000, 4.0)), 1, "light ends at it, and it left");
    }

    #[test]
    fn what_a_bumper_met_beside_a_beam_that_ended_goes_with_it() {
        let mut memory = ObstacleMemory::new(&Mission::default());
        // One beam straight ahead ends at a leg; the bumper says that it stands 0.1 m beside it.
        let mut legs = scan(5, 4.0);
        if let Data::LaserScan(scan) = &mut legs.data {
            scan.ranges_m.make_mut()[2] = 0.3;
        }
        look(&mut memory, &legs);
        let touched =
            |x: f64, y: f64| Obstacle { position: Point2::new(x, y), radius_m: 0.0, stamp: Time(5) };
        memory.add(&[touched(0.28, 0.14), touched(0.2, -0.25)], None);
        assert_eq!(look(&mut memory, &scan(9, 4.0)), 1, "the other is no part of it");
    }

    #[test]
    fn what_light_does_stays_with_its_obstacle_when_others_go() {
        let mut memory = memory_with(2.0, 0.0, 5);
        memory.add(&[Obstacle { position: Point2::new(0.5, 0.0), radius_m: 0.0, stamp: Time(5) }], None);
        memory.add(&[Obstacle { position: Point2::new(2.05, 0.3), radius_m: 0.0, stamp: Time(5) }], None);
        assert_eq!(look(&mut memory, &scan(9, 4.0)), 2, "both that a beam ended at");
        assert_eq!(memory.obstacles()[0].position.x, 0.5);
        assert_eq!(look(&mut memory, &scan(12, 4.0)), 0);
    }

    #[test]
    fn an_obstacle_stays_until_a_later_beam_goes_beyond_it() {
        assert_eq!(look(&mut memory_with(2.0, 0.1, 5), &scan(9, 2.1)), 0, "stands where it stood");
        assert_eq!(look(&mut memory_with(2.0, 0.1, 5), &scan(9, 4.0)), 1, "gone");
        assert_eq!(look(&mut memory_with(2.0, 0.1, 5), &scan(9, f32::INFINITY)), 1, "nothing within reach");
        assert_eq!(look(&mut memory_with(2.0, 0.1, 5), &scan(9, f32::NAN)), 0, "no reading says nothing");
        assert_eq!(look(&mut memory_with(2.0, 0.1, 5), &scan(5, 4.0)), 0, "not later");
        assert_eq!(look(&mut memory_with(-2.0, 0.1, 5), &scan(9, 4.0)), 0, "behind the scanner");
        assert_eq!(look(&mut memory_with(9.0, 0.1, 5), &scan(9, f32::INFINITY)), 0, "out of reach");
    }

    #[test]
    fn what_a_beam_still_meets_counts_as_seen_and_what_passed_the_robot_by_is_forgotten() {
        let left = |x: f64, y: f64, range_m: f32| {
            let mut memory = memory_with(x, y, 5);
            look(&mut memory, &scan(9, range_m));
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
