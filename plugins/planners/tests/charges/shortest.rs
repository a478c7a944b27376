//! Shortest ways among racks by a visibility graph (Lozano-Pérez and Wesley, 1979): an exact solver of a kind that no
//! planner here is. Corners of racks grown by the clearance are arcs; they are taken as circumscribed polygons, which makes
//! ways longer by less than a thousandth.

use rumbo_core::frames::Point2;

/// Tangents that stand for a quarter of a circle.
const N_TANGENTS: usize = 8;

/// Racks as rectangles, and the corners of their grown outlines with the lengths of all clear ways between them.
pub struct ShortestWays {
    racks: Vec<[Point2; 2]>,
    clearance_m: f64,
    corners: Vec<Point2>,
    links: Vec<Vec<(usize, f64)>>,
}

impl ShortestWays {
    pub fn new(racks: Vec<[Point2; 2]>, clearance_m: f64) -> ShortestWays {
        let mut corners = Vec::new();
        for [low, high] in &racks {
            for (quarter, corner) in
                [[high.x, high.y], [low.x, high.y], [low.x, low.y], [high.x, low.y]].into_iter().enumerate()
            {
                let step = std::f64::consts::FRAC_PI_2 / N_TANGENTS as f64;
                // Slightly outside, so that ways along an outline count as clear.
                let radius_m = (clearance_m + 1e-9) / (0.5 * step).cos();
                corners.extend((0..N_TANGENTS).map(|k| {
                    let angle = (quarter * N_TANGENTS + k) as f64 * step + 0.5 * step;
                    Point2::new(corner[0] + radius_m * angle.cos(), corner[1] + radius_m * angle.sin())
                }));
            }
        }
        let mut ways = ShortestWays { racks, clearance_m, links: vec![Vec::new(); corners.len()], corners };
        for a in 0..ways.corners.len() {
            for b in 0..a {
                if ways.is_clear(ways.corners[a], ways.corners[b]) {
                    let length_m = (ways.corners[a] - ways.corners[b]).norm();
                    ways.links[a].push((b, length_m));
                    ways.links[b].push((a, length_m));
                }
            }
        }
        ways
    }

    /// Length of the shortest way between two places that keep the clearance, meters.
    pub fn length_m(&self, from: Point2, to: Point2) -> f64 {
        if self.is_clear(from, to) {
            return (to - from).norm();
        }
        let seen_from = |at: Point2| -> Vec<f64> {
            let length = |corner: &Point2| {
                if self.is_clear(at, *corner) { (corner - at).norm() } else { f64::INFINITY }
            };
            self.corners.iter().map(length).collect()
        };
        let (mut best, last) = (seen_from(from), seen_from(to));
        let mut is_done = vec![false; best.len()];
        while let Some(here) =
            (0..best.len()).filter(|k| !is_done[*k]).min_by(|a, b| best[*a].total_cmp(&best[*b]))
        {
            is_done[here] = true;
            for (there, length_m) in &self.links[here] {
                best[*there] = best[*there].min(best[here] + length_m);
            }
        }
        best.iter().zip(&last).map(|(a, b)| a + b).fold(f64::INFINITY, f64::min)
    }

    /// The straight way keeps the clearance to all racks.
    pub fn is_clear(&self, a: Point2, b: Point2) -> bool {
        self.racks.iter().all(|rack| distance_m(rack, a, b) >= self.clearance_m)
    }
}

/// From a rectangle to a straight way, meters; zero where they meet.
fn distance_m([low, high]: &[Point2; 2], a: Point2, b: Point2) -> f64 {
    if enters(low, high, a, b) {
        return 0.0;
    }
    let to_rectangle = |p: Point2| {
        let beside = |v: f64, low: f64, high: f64| (low - v).max(v - high).max(0.0);
        beside(p.x, low.x, high.x).hypot(beside(p.y, low.y, high.y))
    };
    let to_way = |p: Point2| {
        let along = b - a;
        let t = ((p - a).dot(&along) / along.norm_squared().max(1e-300)).clamp(0.0, 1.0);
        (p - (a + along * t)).norm()
    };
    let corners =
        [*low, *high, Point2::new(low.x, high.y), Point2::new(high.x, low.y)].into_iter().map(to_way);
    corners.fold(to_rectangle(a).min(to_rectangle(b)), f64::min)
}

/// Some point of the way lies in the rectangle (Liang and Barsky, 1984).
fn enters(low: &Point2, high: &Point2, a: Point2, b: Point2) -> bool {
    let (mut t0, mut t1) = (0.0_f64, 1.0_f64);
    for k in 0..2 {
        let (from, along) = (a[k], b[k] - a[k]);
        if along == 0.0 {
            if from < low[k] || from > high[k] {
                return false;
            }
            continue;
        }
        let (u, v) = ((low[k] - from) / along, (high[k] - from) / along);
        t0 = t0.max(u.min(v));
        t1 = t1.min(u.max(v));
    }
    t0 <= t1
}
