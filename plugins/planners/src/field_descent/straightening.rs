//! A walk in small steps made into a path of few straight legs.

use super::rounding::{Rounded, rounded};
use nalgebra::Vector2;
use rumbo_core::frames::Point2;
use rumbo_kit::potential::Obstacles;

/// Places of a walk between which short cuts are tried lie this far apart, meters.
const SPACING_M: f64 = 0.25;
/// Points that stray less than this from a straight leg are not needed, meters.
const COLLINEAR_M: f64 = 1e-3;

/// What a straightened path keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightenRules {
    /// Distance that short cuts and rounded corners keep to obstacles, meters.
    pub clearance_m: f64,
    /// Radius of rounded corners where there is room, meters; zero leaves them sharp.
    pub radius_m: f64,
    /// Corners rounded less than this are counted: the robot cannot turn on a smaller radius, meters.
    pub least_radius_m: f64,
}

/// Wider clearances that short cuts are tried with for a robot that cannot turn in place, as shares of its turning radius:
/// a string that is taut around a corner turns on a circle as wide as the clearance.
const WIDER: [f64; 4] = [0.5, 0.75, 1.0, 1.25];

/// Legs of a walk: short cuts forwards and backwards until nothing gets shorter, collinear points removed, corners rounded.
///
/// For a robot that cannot turn in place, the way with the fewest corners that are too tight, of ways that keep different
/// distances; the shortest among equals.
pub fn straightened(walk: &[Point2], obstacles: &Obstacles, rules: &StraightenRules) -> Rounded {
    let mut best = straightened_at(walk, obstacles, rules, rules.clearance_m);
    for share in WIDER {
        let clearance_m = share * rules.least_radius_m;
        if best.n_tight_corners == 0 {
            break;
        }
        if clearance_m > rules.clearance_m && clearance_m < obstacles.reach_m() {
            let way = straightened_at(walk, obstacles, rules, clearance_m);
            let rank = |way: &Rounded| (way.n_tight_corners, length_m(&way.points));
            if rank(&way) < rank(&best) {
                best = way;
            }
        }
    }
    best
}

/// Short cuts keep `apart_m`, arcs the rules' clearance.
fn straightened_at(walk: &[Point2], obstacles: &Obstacles, rules: &StraightenRules, apart_m: f64) -> Rounded {
    let is_clear = |a: Point2, b: Point2| obstacles.is_clear(a, b, apart_m);
    let mut way = short_cut(walk, &is_clear);
    for _ in 0..MOST_PASSES {
        let before_m = length_m(&way);
        let mut back = resampled(&way);
        back.reverse();
        way = short_cut(&back, &is_clear);
        way.reverse();
        way = short_cut(&resampled(&way), &is_clear);
        if length_m(&way) > before_m - SPACING_M * COLLINEAR_M {
            break;
        }
    }
    let has_room = |a: Point2, b: Point2| obstacles.is_clear(a, b, rules.clearance_m);
    rounded(&without_collinear(&way), rules.radius_m, rules.least_radius_m, &has_room)
}

/// Each pass there and back lets corners move by about a spacing; a few take all of the slack.
const MOST_PASSES: usize = 3;

/// From each place straight to the farthest one that a clear leg leads to.
fn short_cut(way: &[Point2], is_clear: &dyn Fn(Point2, Point2) -> bool) -> Vec<Point2> {
    let candidates = spaced(way);
    let mut cut: Vec<Point2> = way.first().copied().into_iter().collect();
    let mut here = 0;
    while here + 1 < way.len() {
        let farther = candidates.iter().rev().take_while(|there| **there > here + 1);
        let next = farther.copied().find(|there| is_clear(way[here], way[*there])).unwrap_or(here + 1);
        cut.push(way[next]);
        here = next;
    }
    cut
}

/// Places about a spacing apart, and the last.
fn spaced(way: &[Point2]) -> Vec<usize> {
    let mut since_m = 0.0;
    let mut spaced = Vec::new();
    for (idx, leg) in way.windows(2).enumerate() {
        since_m += (leg[1] - leg[0]).norm();
        if since_m >= SPACING_M || idx + 2 == way.len() {
            spaced.push(idx + 1);
            since_m = 0.0;
        }
    }
    spaced
}

/// The same way with places in long legs.
fn resampled(way: &[Point2]) -> Vec<Point2> {
    let mut points: Vec<Point2> = way.first().copied().into_iter().collect();
    for leg in way.windows(2) {
        let n = ((leg[1] - leg[0]).norm() / SPACING_M).ceil().max(1.0) as usize;
        points.extend((1..n).map(|k| leg[0] + (leg[1] - leg[0]) * (k as f64 / n as f64)));
        points.push(leg[1]);
    }
    points
}

/// Leaves out points that lie on the straight leg between those that stay.
///
/// One pass: a leg goes on as long as it leads farther away from its begin, and into all the sectors in which it would pass
/// the points before it closely enough.
pub fn without_collinear(way: &[Point2]) -> Vec<Point2> {
    let mut kept: Vec<Point2> = way.first().copied().into_iter().collect();
    let mut sector: Option<Sector> = None;
    for leg in way.windows(2) {
        let begin = kept.last().copied().unwrap_or(leg[0]);
        let goes_on = sector.is_none_or(|sector| sector.holds(leg[1] - begin));
        if goes_on {
            sector = Some(Sector::narrowed(sector, leg[1] - begin));
        } else {
            kept.push(leg[0]);
            sector = Some(Sector::narrowed(None, leg[1] - leg[0]));
        }
    }
    kept.extend(way.last().filter(|_| way.len() > 1));
    kept
}

/// Directions from the begin of a leg that pass all its points closely enough, and how far away the last one is.
#[derive(Clone, Copy)]
struct Sector {
    /// Of length one.
    middle: Vector2<f64>,
    /// Tangents of the angles from the middle to both sides.
    right: f64,
    left: f64,
    reached_m: f64,
}

impl Sector {
    fn holds(&self, to: Vector2<f64>) -> bool {
        let (ahead, aside) = (self.middle.dot(&to), self.middle.perp(&to));
        to.norm() >= self.reached_m
            && ahead > 0.0
            && aside >= self.right * ahead
            && aside <= self.left * ahead
    }

    fn narrowed(sector: Option<Sector>, to: Vector2<f64>) -> Sector {
        let reached_m = to.norm();
        let all = Sector { middle: to / reached_m.max(1e-12), right: f64::MIN, left: f64::MAX, reached_m };
        let sector = sector.unwrap_or(all);
        let (ahead, aside) = (sector.middle.dot(&to), sector.middle.perp(&to));
        // Every direction passes a point that is as near as this.
        if ahead <= COLLINEAR_M {
            return Sector { reached_m, ..sector };
        }
        Sector {
            right: sector.right.max((aside - COLLINEAR_M) / ahead),
            left: sector.left.min((aside + COLLINEAR_M) / ahead),
            reached_m,
            ..sector
        }
    }
}

/// Length of all legs, meters.
pub fn length_m(way: &[Point2]) -> f64 {
    way.windows(2).map(|leg| (leg[1] - leg[0]).norm()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_kit::potential::Piece;

    fn points(way: &[[f64; 2]]) -> Vec<Point2> {
        way.iter().copied().map(Point2::from).collect()
    }

    const RULES: StraightenRules = StraightenRules { clearance_m: 0.3, radius_m: 0.0, least_radius_m: 0.0 };

    #[test]
    fn points_on_a_leg_go_and_turns_back_stay() {
        let way = points(&[[0.0, 0.0], [1.0, 0.0005], [2.0, 0.0], [3.0, 1.0], [4.0, 2.0], [3.5, 1.5]]);
        let kept = without_collinear(&way);
        assert_eq!(kept, points(&[[0.0, 0.0], [2.0, 0.0], [4.0, 2.0], [3.5, 1.5]]));
        assert_eq!(without_collinear(&way[..1]).len(), 1);
        // A slow bend strays no farther than that from what is kept.
        let bend: Vec<Point2> =
            (0..=3000).map(|k| f64::from(k) * 0.001).map(|x| Point2::new(x, 0.1 * x * x)).collect();
        let kept = without_collinear(&bend);
        assert!((10..60).contains(&kept.len()), "{}", kept.len());
        for point in &bend {
            let off = |leg: &[Point2]| {
                let along = leg[1] - leg[0];
                let share = ((point - leg[0]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                (point - (leg[0] + along * share)).norm()
            };
            assert!(kept.windows(2).map(off).fold(f64::INFINITY, f64::min) <= 2.0 * COLLINEAR_M);
        }
        assert!(without_collinear(&[]).is_empty());
    }

    #[test]
    fn a_detour_around_a_wall_becomes_nearly_as_short_as_it_can_be() {
        let wall = vec![Piece::between(Point2::new(0.0, -1.0), Point2::new(0.0, 1.0))];
        let obstacles = Obstacles::new(&[wall], 2.0).unwrap();
        // A wide half circle in small steps.
        let walk: Vec<Point2> = (0..=400)
            .map(|k| std::f64::consts::PI * (1.0 - f64::from(k) / 400.0))
            .map(|angle| Point2::new(3.0 * angle.cos(), 3.0 * angle.sin()))
            .collect();
        let way = straightened(&walk, &obstacles, &RULES).points;
        assert!((way[0] - walk[0]).norm() < 1e-12 && (way[way.len() - 1] - walk[400]).norm() < 1e-12);
        // Two tangents to the circle of 0.3 m around the end of the wall, and the arc between them.
        let (to_end, radius) = (3.0_f64.hypot(1.0), 0.3_f64);
        let wrapped = std::f64::consts::PI + 2.0 * (1.0_f64 / 3.0).atan() - 2.0 * (radius / to_end).acos();
        let shortest = 2.0 * (to_end * to_end - radius * radius).sqrt() + radius * wrapped;
        let found = length_m(&way);
        assert!(found > shortest && found < 1.03 * shortest, "{shortest} {found}");
        for leg in way.windows(2) {
            for k in 0..=1000 {
                let at = leg[0] + (leg[1] - leg[0]) * (f64::from(k) / 1000.0);
                assert!(obstacles.clearance_m(at) >= 0.3);
            }
        }
    }

    #[test]
    fn a_walk_that_is_nearer_than_a_short_cut_may_be_is_kept() {
        let wall = vec![Piece::between(Point2::new(-9.0, 0.0), Point2::new(9.0, 0.0))];
        let obstacles = Obstacles::new(&[wall], 2.0).unwrap();
        let walk: Vec<Point2> =
            (0..100).map(|k| Point2::new(0.02 * f64::from(k), 0.1 + 0.05 * f64::from(k % 2))).collect();
        assert_eq!(straightened(&walk, &obstacles, &RULES).points, walk);
        assert_eq!(straightened(&walk[..1], &obstacles, &RULES).points, walk[..1]);
        assert!(straightened(&[], &obstacles, &RULES).points.is_empty());
    }
}
