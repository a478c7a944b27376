//! A search, and a robot that does what it wishes.

use super::{CELL_M, Laser, Office};
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::messages::Wish;
use rumbo_core::rng::{Rng, stream};
use rumbo_core::time::Time;
use rumbo_localizers::landmark_relaxation::LandmarkRelaxationParams;
use rumbo_localizers::landmark_relaxation::locator::Locator;
use rumbo_localizers::landmark_relaxation::matching::Knowledge;
use rumbo_localizers::landmark_relaxation::search::{Progress, Search};

/// The robot in its surroundings.
pub struct Course<'o> {
    /// The floor.
    pub office: &'o Office,
    /// What is known of it.
    pub known: &'o Knowledge,
    /// The scanner.
    pub laser: Laser,
    /// What stands around that the map does not show.
    pub boxes: Vec<[f64; 4]>,
    /// Where the robot is.
    pub map_from_base: Pose2,
}

/// What a search said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Said {
    /// One place.
    Found,
    /// One that fits not well enough.
    Doubtful,
    /// Several.
    Ambiguous,
    /// None.
    Lost,
}

/// How a search went.
#[derive(Debug, Clone, Copy)]
pub struct Ending {
    /// After the first look all around.
    pub first: Said,
    /// At last.
    pub last: Said,
    /// How often it looked from elsewhere.
    pub n_moves: u32,
    /// Way that was driven to the first look from elsewhere, meters.
    pub first_way_m: f64,
    /// Distance of the place that was found from the truth, meters.
    pub off_m: f64,
    /// While several places fitted, one of them was always the right one (within 0.30 m).
    pub kept_the_truth: bool,
}

impl Ending {
    /// Found within 0.10 m.
    pub fn is_success(&self) -> bool {
        self.last == Said::Found && self.off_m <= 0.10
    }

    /// A wrong place was believed.
    pub fn is_wrong(&self) -> bool {
        self.last == Said::Found && self.off_m > 0.10
    }
}

/// What a wish moves between two readings: meters, and radians.
const STEP: [f64; 2] = [0.02, 0.08];
/// The robot, meters.
const RADIUS_M: f64 = 0.20;

impl Course<'_> {
    /// Searches until the robot is found or nothing more is wished; the odometer misjudges way and turns by one percent.
    pub fn run(mut self, params: &LandmarkRelaxationParams, seed: u64) -> Ending {
        let mut rng = stream(seed, "course");
        let errors: [f64; 2] = [0; 2].map(|_| 0.01 * Distribution::<f64>::sample(&StandardNormal, &mut rng));
        let locator = Locator::new(params.locator(), stream(seed, "noise"));
        let mut search = Search::new(params.search(RADIUS_M), locator);
        let (mut odom_from_base, mut now) = (pose2(3.0, -2.0, 1.0), 0.0);
        let mut first = None;
        let (mut way_m, mut first_way_m, mut kept_the_truth) = (0.0, 0.0, true);
        loop {
            now += 0.2;
            search.follow(odom_from_base, Time::from_secs(now));
            let (said, wish, off_m) = self.said(&search, &mut kept_the_truth);
            first = first.or(said);
            if search.n_moves() == 1 {
                first_way_m = way_m;
            }
            match wish {
                Some(Wish::HoldStill) => self.look(&mut search, odom_from_base, now, &mut rng),
                Some(wish) => way_m += self.obey(wish, errors, &mut odom_from_base),
                None => {
                    let [first, last] = [first, said].map(|said| said.expect("it has looked"));
                    let n_moves = search.n_moves();
                    return Ending { first, last, n_moves, first_way_m, off_m, kept_the_truth };
                }
            }
        }
    }

    /// What it says, and its wish; none when it is over.
    fn said(&self, search: &Search, kept_the_truth: &mut bool) -> (Option<Said>, Option<Wish>, f64) {
        let off_m = |pose: &Pose2| (pose.translation.vector - self.map_from_base.translation.vector).norm();
        match search.progress() {
            Progress::Looking(wish) if search.n_moves() > 0 => {
                (Some(Said::Doubtful), Some(wish), f64::INFINITY)
            }
            Progress::Looking(wish) => (None, Some(wish), f64::INFINITY),
            Progress::Found(place, _) => (Some(Said::Found), None, off_m(&place.map_from_base)),
            Progress::Lost(wish) => (Some(Said::Lost), wish, f64::INFINITY),
            Progress::Ambiguous(places, wish) => {
                *kept_the_truth &= places.iter().any(|place| off_m(&place.map_from_base) <= 0.30);
                (Some(Said::Ambiguous), wish, f64::INFINITY)
            }
        }
    }

    fn look(&self, search: &mut Search, odom_from_base: Pose2, now: f64, rng: &mut Rng) {
        let ranges_m = self.laser.ranges_m(self.office, &self.map_from_base, &self.boxes, rng);
        let sighting = self.laser.sighting(ranges_m, odom_from_base, now);
        search.look(self.known, sighting, Time::from_secs(now));
    }

    /// One step of a motion, if nothing is in the way; gives the way.
    fn obey(&mut self, wish: Wish, errors: [f64; 2], odom_from_base: &mut Pose2) -> f64 {
        let [way_m, turn_rad] = match wish {
            Wish::TurnBy(left) => [0.0, left.abs().min(STEP[1]).copysign(left)],
            Wish::MoveBy(left) => [left.abs().min(STEP[0]).copysign(left), 0.0],
            _ => [0.0; 2],
        };
        let next = self.map_from_base * pose2(way_m, 0.0, turn_rad);
        let [x, y] = [next.translation.x, next.translation.y];
        let is_clear = |[x0, y0, x1, y1]: &[f64; 4]| {
            (x0 - x).max(x - x1).max(0.0).hypot((y0 - y).max(y - y1).max(0.0)) > RADIUS_M
        };
        let is_open = self.office.is_open(x / CELL_M, y / CELL_M, RADIUS_M / CELL_M);
        if way_m != 0.0 && !(is_open && self.boxes.iter().all(is_clear)) {
            return 0.0;
        }
        self.map_from_base = next;
        *odom_from_base *= pose2(way_m * (1.0 + errors[0]), 0.0, turn_rad * (1.0 + errors[1]));
        way_m.abs()
    }
}
