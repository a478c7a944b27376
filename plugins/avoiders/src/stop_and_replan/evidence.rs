//! Sonar evidence over time: a grid around the robot, fixed in the map, in which echoes add up and clear cones take away.
//!
//! Hernández Alamilla (2005), section 6.2, looks at single readings and misses most panes: glass returns sound only where
//! it meets the pane squarely, so a robot that passes hears it for a moment. Here what was heard stays for a while. What
//! differs from an occupancy grid: a cone that reads farther takes evidence away only where it looks along the direction
//! in which the echo came, since a pane mirrors sound from all others and they hear nothing of it; and evidence never
//! falls below none, so that long hearing nothing does not delay what is heard at last.

use super::cones::Cone;
use rumbo_core::frames::{Point2, wrap_angle};
use rumbo_core::time::Time;

/// Numbers of the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EvidenceTuning {
    /// Echoes from farther are of no interest, meters.
    pub reach_m: f64,
    /// After so long without an echo the surest cell is forgotten, seconds.
    pub decay_s: f64,
}

/// What is known of one cell.
#[derive(Debug, Clone, Copy)]
struct Cell {
    /// Which cell of the endless plane stands here now.
    place: (i32, i32),
    /// Echoes more than clear cones.
    level: f64,
    /// It was sure, and did not fall to nothing since.
    is_sure: bool,
    /// When it last changed.
    stamp: Time,
    /// When it was last heard.
    heard: Time,
    /// Mean of the arcs' points.
    point: Point2,
    /// From the transducer to the cell, radians.
    heard_along_rad: f64,
    /// The last cone that added to it: none adds twice.
    cone: u64,
}

/// A sure place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heard {
    /// Where it is in the map.
    pub point: Point2,
    /// When it was last heard.
    pub stamp: Time,
}

/// The grid.
#[derive(Debug)]
pub struct SonarEvidence {
    tuning: EvidenceTuning,
    /// A window of the endless plane that rolls with the robot: cell (i, j) stands at (i mod n, j mod n).
    cells: Vec<Cell>,
    n_edge: i32,
    n_cones: u64,
}

impl SonarEvidence {
    /// Edge of a cell, meters (the source's successor names 0.10 m).
    pub const CELL_M: f64 = 0.10;
    /// So many echoes more than clear cones are sure: three in a row, since one or two may be another transducer's sound.
    const SURE: f64 = 3.0;
    /// No more than this is counted.
    const MOST: f64 = 5.0;
    /// What is left of a sure cell that is sure no more.
    const NOTHING: f64 = 0.5;
    /// A cone is clear up to this much before its echo, meters.
    const BEFORE_ECHO_M: f64 = 0.10;
    /// A pane answers within 6 degrees of its normal; a cone that looks along another direction says nothing of it.
    const SQUARE_RAD: f64 = 8.0 * std::f64::consts::PI / 180.0;
    /// The border of a cone belongs to it, radians.
    const BORDER_RAD: f64 = 0.01;
    /// Points of an arc are this close, meters: no cell is left out.
    const SPACING_M: f64 = 0.025;
    /// The window goes this far beyond the reach, for the robot's size and its way within the decay, meters.
    const BESIDE_REACH_M: f64 = 3.0;

    /// An empty grid.
    pub fn new(tuning: EvidenceTuning) -> SonarEvidence {
        let n_edge = (2.0 * (tuning.reach_m + Self::BESIDE_REACH_M) / Self::CELL_M).ceil().clamp(1.0, 400.0);
        let empty = Cell {
            place: (0, 0),
            level: 0.0,
            is_sure: false,
            stamp: Time::ZERO,
            heard: Time::ZERO,
            point: Point2::origin(),
            heard_along_rad: 0.0,
            cone: 0,
        };
        let n_edge = n_edge as i32;
        SonarEvidence { tuning, cells: vec![empty; (n_edge * n_edge) as usize], n_edge, n_cones: 0 }
    }

    /// Whether an echo is near enough to be of interest.
    pub fn is_in_reach(&self, cone: &Cone) -> bool {
        cone.range_m <= self.tuning.reach_m
    }

    /// What lies before the echo is clear of all that was heard along this direction.
    pub fn clear(&mut self, now: Time, cone: &Cone) {
        let clear_m = cone.range_m.min(self.tuning.reach_m + Self::BEFORE_ECHO_M) - Self::BEFORE_ECHO_M;
        if clear_m <= 0.0 {
            return;
        }
        let (low, high) = (place_of(cone.tip, -clear_m), place_of(cone.tip, clear_m));
        for place in (low.1..=high.1).flat_map(|j| (low.0..=high.0).map(move |i| (i, j))) {
            let decay_s = self.tuning.decay_s;
            let Some(cell) = self.cell_at(place).filter(|cell| cell.place == place && cell.level > 0.0)
            else {
                continue;
            };
            let to_cell = cell.point - cone.tip;
            let along_rad = to_cell.y.atan2(to_cell.x);
            let is_clear = to_cell.norm() <= clear_m && cone.covers(along_rad, Self::BORDER_RAD);
            if is_clear && wrap_angle(along_rad - cell.heard_along_rad).abs() <= Self::SQUARE_RAD {
                cell.change(now, decay_s, -1.0);
            }
        }
    }

    /// Adds the arc of an echo that nothing explains. Returns whether any of it is sure.
    pub fn hear(&mut self, now: Time, cone: &Cone) -> bool {
        self.n_cones += 1;
        let (n_cones, decay_s) = (self.n_cones, self.tuning.decay_s);
        let mut is_sure = false;
        for point in cone.arc(Self::SPACING_M) {
            let place = place_of(point, 0.0);
            let Some(cell) = self.cell_at(place) else { continue };
            if cell.place != place || !cell.is_alive(now, decay_s) {
                let (is_sure, level) = (false, 0.0);
                *cell = Cell { place, level, is_sure, stamp: now, point, cone: 0, ..*cell };
            }
            if cell.cone != n_cones {
                let along = point - cone.tip;
                (cell.cone, cell.heard, cell.heard_along_rad) = (n_cones, now, along.y.atan2(along.x));
                cell.point += (point - cell.point) / (cell.level + 1.0);
                cell.change(now, decay_s, 1.0);
            }
            is_sure |= cell.is_sure;
        }
        is_sure
    }

    /// All places that are sure now.
    pub fn sure(&self, now: Time) -> impl Iterator<Item = Heard> + '_ {
        let decay_s = self.tuning.decay_s;
        self.cells
            .iter()
            .filter(move |cell| cell.is_sure && cell.is_alive(now, decay_s))
            .map(|cell| Heard { point: cell.point, stamp: cell.heard })
    }

    /// A sure place lies in the cone, clearly before its echo: a mirror, or something that an opening beside it lets by.
    pub fn is_before(&self, now: Time, cone: &Cone) -> bool {
        self.sure(now).any(|heard| {
            let to_heard = heard.point - cone.tip;
            to_heard.norm() < cone.range_m - Self::BEFORE_ECHO_M
                && cone.covers(to_heard.y.atan2(to_heard.x), Self::BORDER_RAD)
        })
    }

    fn cell_at(&mut self, place: (i32, i32)) -> Option<&mut Cell> {
        let (i, j) = (place.0.rem_euclid(self.n_edge), place.1.rem_euclid(self.n_edge));
        self.cells.get_mut((j * self.n_edge + i) as usize)
    }
}

impl Cell {
    /// What is left of the level now: it falls evenly, from the most to nothing within the decay.
    fn level_at(&self, now: Time, decay_s: f64) -> f64 {
        let fallen = SonarEvidence::MOST * (now - self.stamp).as_secs().max(0.0) / decay_s;
        (self.level - fallen).max(0.0)
    }

    fn is_alive(&self, now: Time, decay_s: f64) -> bool {
        let least = if self.is_sure { SonarEvidence::NOTHING } else { 0.0 };
        self.level_at(now, decay_s) > least
    }

    fn change(&mut self, now: Time, decay_s: f64, by: f64) {
        let level = (self.level_at(now, decay_s) + by).clamp(0.0, SonarEvidence::MOST);
        // Three echoes at ten a second decay by a few percent on the way.
        let is_enough = level >= SonarEvidence::SURE - SonarEvidence::NOTHING;
        self.is_sure = is_enough || (self.is_sure && level > SonarEvidence::NOTHING);
        (self.level, self.stamp) = (level, now);
    }
}

/// The cell of a point that is moved by so much along both axes.
fn place_of(point: Point2, by_m: f64) -> (i32, i32) {
    let cell = |along_m: f64| ((along_m + by_m) / SonarEvidence::CELL_M).floor() as i32;
    (cell(point.x), cell(point.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> SonarEvidence {
        SonarEvidence::new(EvidenceTuning { reach_m: 1.0, decay_s: 10.0 })
    }

    fn cone(x: f64, range_m: f64) -> Cone {
        Cone { tip: Point2::new(x, 0.05), axis_rad: 0.0, half_rad: 12.5f64.to_radians(), range_m }
    }

    fn at(seconds: f64) -> Time {
        Time::from_secs(seconds)
    }

    fn n_sure(grid: &SonarEvidence, seconds: f64) -> usize {
        grid.sure(at(seconds)).count()
    }

    #[test]
    fn three_echoes_that_agree_are_sure_and_two_are_not() {
        let mut grid = grid();
        assert!(!grid.hear(at(0.0), &cone(0.0, 0.6)) && !grid.hear(at(0.1), &cone(0.0, 0.6)));
        assert_eq!(n_sure(&grid, 0.1), 0);
        assert!(grid.hear(at(0.2), &cone(0.0, 0.6)));
        for heard in grid.sure(at(0.2)) {
            assert!(((heard.point - cone(0.0, 0.6).tip).norm() - 0.6).abs() < 0.01 && heard.stamp == at(0.2));
        }
        let widest_m = grid.sure(at(0.2)).map(|heard| (heard.point.y - 0.05).abs()).fold(0.0, f64::max);
        assert!(widest_m > 0.08 && widest_m < 0.6 * 12.5f64.to_radians().sin() + 1e-9, "{widest_m}");
    }

    #[test]
    fn echoes_at_changing_ranges_are_never_sure() {
        let mut grid = grid();
        for k in 0..200 {
            let range_m = 0.3 + 0.6 * (f64::from(k) * 0.618).fract();
            let echo = cone(0.0, range_m);
            grid.clear(at(f64::from(k) * 0.1), &echo);
            grid.hear(at(f64::from(k) * 0.1), &echo);
        }
        // Of two hundred, spread over six cells: a few pairs agree, but what reads farther takes them away again.
        assert_eq!(grid.sure(at(20.0)).filter(|heard| heard.point.x < 0.7).count(), 0);
    }

    #[test]
    fn another_transducers_sound_now_and_then_is_never_sure() {
        let mut grid = grid();
        for k in 0..3000 {
            let now = at(f64::from(k) * 0.1);
            // Every fifth reading is too short, at always the same range.
            let echo = cone(0.0, if k % 5 == 0 { 0.5 } else { 3.0 });
            grid.clear(now, &echo);
            if grid.is_in_reach(&echo) {
                grid.hear(now, &echo);
            }
            assert_eq!(grid.sure(now).count(), 0);
        }
    }

    #[test]
    fn what_was_sure_stays_for_the_decay_and_no_longer() {
        let mut grid = grid();
        (0..20).for_each(|k| _ = grid.hear(at(f64::from(k) * 0.1), &cone(0.0, 0.6)));
        assert!(n_sure(&grid, 2.0) > 0 && n_sure(&grid, 10.5) > 0);
        assert_eq!(n_sure(&grid, 12.0), 0);
        assert!(!grid.hear(at(13.0), &cone(0.0, 0.6)), "it begins anew");
    }

    #[test]
    fn a_cone_clears_along_the_direction_of_the_echo_and_no_other() {
        let heard = || {
            let mut grid = grid();
            (0..9).for_each(|k| _ = grid.hear(at(f64::from(k) * 0.1), &cone(0.0, 0.6)));
            grid
        };
        let mut same = heard();
        (0..9).for_each(|k| same.clear(at(1.0 + f64::from(k) * 0.1), &cone(0.0, 2.0)));
        assert_eq!(n_sure(&same, 2.0), 0, "it went away");
        let mut short = heard();
        (0..9).for_each(|k| short.clear(at(1.0 + f64::from(k) * 0.1), &cone(0.0, 0.65)));
        assert_eq!(n_sure(&short, 2.0), n_sure(&heard(), 2.0), "the echo itself");
        let mut aslant = heard();
        let other = Cone { tip: Point2::new(0.3, -0.25), axis_rad: 45f64.to_radians(), ..cone(0.0, 2.0) };
        (0..9).for_each(|k| aslant.clear(at(1.0 + f64::from(k) * 0.1), &other));
        assert_eq!(n_sure(&aslant, 2.0), n_sure(&heard(), 2.0), "a pane mirrors this away");
    }

    #[test]
    fn what_is_heard_beyond_a_sure_place_in_the_same_cone_may_be_a_mirror_image() {
        let mut grid = grid();
        (0..4).for_each(|k| _ = grid.hear(at(f64::from(k) * 0.1), &cone(0.0, 0.4)));
        assert!(grid.is_before(at(0.5), &cone(0.0, 0.8)));
        assert!(!grid.is_before(at(0.5), &cone(0.0, 0.45)), "the place itself");
        assert!(!grid.is_before(at(0.5), &Cone { axis_rad: 1.0, ..cone(0.0, 0.8) }), "another cone");
        assert!(!grid.is_before(at(15.0), &cone(0.0, 0.8)), "long ago");
    }

    #[test]
    fn neighbors_that_hear_nothing_narrow_the_arc() {
        let mut grid = grid();
        let neighbor = Cone { axis_rad: 14f64.to_radians(), ..cone(0.0, 2.0) };
        for k in 0..9 {
            let now = at(f64::from(k) * 0.1);
            grid.hear(now, &cone(0.0, 0.95));
            grid.clear(now, &neighbor);
        }
        let (mut left, mut right) = (0.0f64, 0.0f64);
        for heard in grid.sure(at(0.9)) {
            (left, right) = (left.max(heard.point.y - 0.05), right.min(heard.point.y - 0.05));
        }
        assert!(right < -0.15 && left < 0.06, "{right} to {left}");
    }

    #[test]
    fn the_window_rolls_and_forgets_what_is_far() {
        let mut grid = grid();
        let width_m = f64::from(grid.n_edge) * SonarEvidence::CELL_M;
        (0..4).for_each(|k| _ = grid.hear(at(f64::from(k) * 0.1), &cone(0.0, 0.6)));
        assert!(!grid.hear(at(0.5), &cone(width_m, 0.6)), "the same cells, another place");
        assert!(grid.sure(at(0.5)).all(|heard| heard.point.x < 1.0));
    }
}
