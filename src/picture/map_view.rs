//! The map with everything that happened on it, seen from above.

use super::sketch::{Anchor, Role, Shape, Sketch};
use crate::record::{RunRecord, Sample};
use rumbo_core::frames::{Point2, pose2};

/// An entry of the legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sign {
    /// What it shows.
    pub role: Role,
    /// In words.
    pub words: &'static str,
}

/// The legend, in reading order.
pub const SIGNS: [Sign; 14] = [
    Sign { role: Role::Start, words: "start" },
    Sign { role: Role::Goal, words: "goal" },
    Sign { role: Role::Truth, words: "true way" },
    Sign { role: Role::Estimate, words: "estimated way" },
    Sign { role: Role::AtTheTime, words: "thought at the time" },
    Sign { role: Role::Ellipse, words: "95 % of the estimate" },
    Sign { role: Role::Path, words: "planned path" },
    Sign { role: Role::OldPath, words: "earlier path" },
    Sign { role: Role::Draft, words: "way before it was straightened" },
    Sign { role: Role::Level, words: "levels of the potential" },
    Sign { role: Role::Mark, words: "fictitious charge" },
    Sign { role: Role::Obstacle, words: "obstacle found" },
    Sign { role: Role::Wall, words: "wall of the map" },
    Sign { role: Role::Seen, words: "seen from the start" },
];

/// Ellipses that are drawn at most.
const MOST_ELLIPSES: usize = 24;
/// Squared radius that holds 95 % of a normal distribution in the plane (chi-squared, two degrees of freedom).
const RADIUS_95: f64 = 5.991;
/// Free space around everything, meters.
const MARGIN_M: f64 = 0.3;

/// Where the map lies on the paper.
pub struct MapView<'a> {
    record: &'a RunRecord,
    left_m: f64,
    top_m: f64,
    pixels_per_m: f64,
    width: f64,
    height: f64,
    roles: Vec<Role>,
}

impl<'a> MapView<'a> {
    /// Fits everything into a sheet of at most this size.
    pub fn new(record: &'a RunRecord, most_width: f64, most_height: f64) -> MapView<'a> {
        let [left, bottom, right, top] = extent(record);
        let pixels_per_m = (most_width / (right - left)).min(most_height / (top - bottom));
        let (width, height) = ((right - left) * pixels_per_m, (top - bottom) * pixels_per_m);
        MapView { record, left_m: left, top_m: top, pixels_per_m, width, height, roles: Vec::new() }
    }

    /// Pixels that a meter takes.
    pub fn pixels_per_m(&self) -> f64 {
        self.pixels_per_m
    }

    /// The picture, and the legend's entries that occur in it.
    pub fn draw(mut self) -> (Sketch, Vec<Sign>) {
        let mut sketch = Sketch::sheet(self.width, self.height);
        self.map(&mut sketch);
        for wall in &self.record.walls {
            self.chain(&mut sketch, Role::Wall, wall.iter().copied());
        }
        for region in &self.record.seen {
            self.ring(&mut sketch, Role::Seen, region.outline.iter().copied());
        }
        self.plan_drawings(&mut sketch);
        self.earlier_paths(&mut sketch);
        self.ways(&mut sketch);
        self.last_path(&mut sketch);
        self.obstacles(&mut sketch);
        self.hulls(&mut sketch);
        self.goals(&mut sketch);
        let signs = SIGNS.into_iter().filter(|sign| self.roles.contains(&sign.role)).collect();
        (sketch, signs)
    }

    fn at(&self, [x_m, y_m]: [f64; 2]) -> [f64; 2] {
        [(x_m - self.left_m) * self.pixels_per_m, (self.top_m - y_m) * self.pixels_per_m]
    }

    fn chain(&mut self, sketch: &mut Sketch, role: Role, points: impl Iterator<Item = [f64; 2]>) {
        let points: Vec<_> = points.map(|point| self.at(point)).collect();
        if points.len() > 1 {
            self.roles.push(role);
        }
        sketch.chain(role, points);
    }

    fn ring(&mut self, sketch: &mut Sketch, role: Role, points: impl Iterator<Item = [f64; 2]>) {
        let points: Vec<_> = points.map(|point| self.at(point)).collect();
        self.roles.push(role);
        sketch.ring(role, points);
    }

    fn map(&self, sketch: &mut Sketch) {
        let Some(image) = &self.record.map else { return };
        let (map_from_image, pixel_m) = (image.map_from_image(), image.pixel_m);
        // From the image's pixels (top row first) over its own frame (y up) and the map's to the paper.
        let [origin, right, up] = [[0.0, 0.0], [pixel_m, 0.0], [0.0, pixel_m]].map(|[x, y]| {
            let point = map_from_image * Point2::new(x, y);
            self.at([point.x, point.y])
        });
        let (a, b) = (right[0] - origin[0], right[1] - origin[1]);
        let (c, d) = (origin[0] - up[0], origin[1] - up[1]);
        let n_rows = f64::from(image.height);
        let matrix = [a, b, c, d, origin[0] - c * n_rows, origin[1] - d * n_rows];
        sketch.shapes.push(Shape::Image { image: image.clone(), matrix });
    }

    /// On top of the way that follows it, or nobody would see it.
    fn last_path(&mut self, sketch: &mut Sketch) {
        let points = self.record.paths.last().map(|path| path.points.as_slice()).unwrap_or_default();
        self.chain(sketch, Role::Path, points.iter().copied());
    }

    /// Behind the paths. Drawings of names that are not known here belong to whoever looks at them elsewhere.
    fn plan_drawings(&mut self, sketch: &mut Sketch) {
        for drawing in &self.record.plan_drawings {
            let role = match (drawing.name.as_str(), drawing.is_points) {
                ("level of the potential", false) => Role::Level,
                ("walk before it is straightened" | "path before refinement", false) => Role::Draft,
                ("charges", true) => Role::Mark,
                _ => continue,
            };
            if drawing.is_points {
                for point in &drawing.points {
                    sketch.circle(role, self.at(*point), 4.0);
                    self.roles.push(role);
                }
            } else {
                self.chain(sketch, role, drawing.points.iter().copied());
            }
        }
    }

    fn earlier_paths(&mut self, sketch: &mut Sketch) {
        let Some((_, earlier)) = self.record.paths.split_last() else { return };
        // Many plans would hide the map: the latest earlier ones tell enough.
        for path in earlier.iter().rev().take(12) {
            self.chain(sketch, Role::OldPath, path.points.iter().copied());
        }
    }

    fn ways(&mut self, sketch: &mut Sketch) {
        let record = self.record;
        self.chain(
            sketch,
            Role::Truth,
            record.samples.iter().filter_map(|s| s.truth).map(|[x, y, _]| [x, y]),
        );
        let located = || record.samples.iter().filter(|sample| sample.is_located);
        let stride = record.samples.len().div_ceil(MOST_ELLIPSES).max(1);
        for sample in located().step_by(stride) {
            if let Some(outline) = ellipse(sample) {
                self.ring(sketch, Role::Ellipse, outline.into_iter());
            }
        }
        // What it knows at the end lies where the map was drawn from; what it thought before does not.
        let knows_better = !record.known_way.is_empty();
        let role = if knows_better { Role::AtTheTime } else { Role::Estimate };
        self.chain(sketch, role, located().map(|s| [s.estimate[0], s.estimate[1]]));
        if knows_better {
            self.chain(sketch, Role::Estimate, record.known_way.iter().copied());
        }
    }

    fn obstacles(&mut self, sketch: &mut Sketch) {
        for [x, y, radius_m] in &self.record.obstacles {
            let radius = (radius_m * self.pixels_per_m).max(1.8);
            sketch.circle(Role::Obstacle, self.at([*x, *y]), radius);
            self.roles.push(Role::Obstacle);
        }
    }

    fn hulls(&mut self, sketch: &mut Sketch) {
        let record = self.record;
        let pose = |sample: &Sample| sample.truth.unwrap_or(sample.estimate);
        let first = record.start.or(record.samples.first().map(pose));
        let last = record.samples.last().filter(|_| record.samples.len() > 1).map(pose);
        for (role, place) in [(Role::End, last), (Role::Start, first)] {
            let Some([x, y, yaw]) = place else { continue };
            let map_from_base = pose2(x, y, yaw);
            let corners = record.hull.iter().map(|[x, y]| map_from_base * Point2::new(*x, *y));
            self.ring(sketch, role, corners.map(|p| [p.x, p.y]));
            let reach_m = record.hull.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
            let nose = map_from_base * Point2::new(reach_m, 0.0);
            self.chain(sketch, role, [[x, y], [nose.x, nose.y]].into_iter());
        }
    }

    fn goals(&mut self, sketch: &mut Sketch) {
        let record = self.record;
        for (idx, goal) in record.goals.iter().enumerate() {
            let [x, y] = self.at(*goal);
            for arm in [[5.0, 5.0], [5.0, -5.0]] {
                sketch.chain(Role::Goal, vec![[x - arm[0], y - arm[1]], [x + arm[0], y + arm[1]]]);
            }
            sketch.circle(Role::Goal, [x, y], (record.arrival_radius_m * self.pixels_per_m).max(7.0));
            self.roles.push(Role::Goal);
            if record.goals.len() > 1 {
                let number = (idx + 1).to_string();
                sketch.text(Role::Text, [x + 10.0, y - 8.0], 13.0, Anchor::Start, number);
            }
        }
    }
}

/// Left, bottom, right and top edge of everything, meters; never empty.
fn extent(record: &RunRecord) -> [f64; 4] {
    let mut edges = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    let mut take = |[x, y]: [f64; 2], margin_m: f64| {
        if x.is_finite() && y.is_finite() {
            edges[0] = edges[0].min(x - margin_m);
            edges[1] = edges[1].min(y - margin_m);
            edges[2] = edges[2].max(x + margin_m);
            edges[3] = edges[3].max(y + margin_m);
        }
    };
    let map = record.map.iter().flat_map(|image| image.corners());
    map.for_each(|corner| take([corner.x, corner.y], 0.0));
    record.walls.iter().flatten().for_each(|end| take(*end, MARGIN_M));
    for sample in &record.samples {
        sample.truth.iter().for_each(|[x, y, _]| take([*x, *y], MARGIN_M));
        if sample.is_located {
            take([sample.estimate[0], sample.estimate[1]], MARGIN_M);
        }
    }
    record.known_way.iter().for_each(|place| take(*place, MARGIN_M));
    record.goals.iter().for_each(|goal| take(*goal, MARGIN_M));
    record.start.iter().for_each(|[x, y, _]| take([*x, *y], MARGIN_M));
    if edges[0] < edges[2] { edges } else { [-1.0, -1.0, 1.0, 1.0] }
}

/// The outline that holds 95 % of an estimate's position; none where it is larger than any room.
fn ellipse(sample: &Sample) -> Option<Vec<[f64; 2]>> {
    let [xx, xy, yy] = sample.covariance;
    let (middle, half) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
    let (long_m, short_m) =
        (((middle + half) * RADIUS_95).sqrt(), ((middle - half).max(0.0) * RADIUS_95).sqrt());
    if !(long_m > 1e-6 && long_m < 20.0) {
        return None;
    }
    let turn = 0.5 * (2.0 * xy).atan2(xx - yy);
    let (sin, cos) = turn.sin_cos();
    let [x, y, _] = sample.estimate;
    let corner = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / 24.0;
        let (along, across) = (long_m * angle.cos(), short_m * angle.sin());
        [x + along * cos - across * sin, y + along * sin + across * cos]
    };
    Some((0..24).map(corner).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::test_record;

    #[test]
    fn everything_lies_on_the_paper_and_north_is_up() {
        let record = test_record();
        let view = MapView::new(&record, 400.0, 300.0);
        let (low, high) = (view.at([0.0, 0.0]), view.at([0.0, 1.0]));
        assert!(high[1] < low[1]);
        let (sketch, signs) = view.draw();
        assert!(sketch.width <= 400.0 && sketch.height <= 300.0);
        assert!(signs.iter().any(|sign| sign.role == Role::Truth));
        let walls =
            sketch.shapes.iter().filter(|shape| matches!(shape, Shape::Chain { role: Role::Wall, .. }));
        assert!(walls.count() == record.walls.len() && signs.iter().any(|sign| sign.role == Role::Wall));
        for shape in &sketch.shapes {
            let Shape::Chain { points, .. } = shape else { continue };
            let inside = |[x, y]: &[f64; 2]| (0.0..=400.0).contains(x) && (0.0..=300.0).contains(y);
            assert!(points.iter().all(inside), "{shape:?}");
        }
    }

    #[test]
    fn a_map_of_walls_alone_fills_the_paper() {
        let mut record = test_record();
        (record.map, record.samples, record.goals) = (None, Vec::new(), Vec::new());
        record.walls = vec![[[10.0, 5.0], [30.0, 5.0]], [[30.0, 5.0], [30.0, 15.0]]];
        let [left, bottom, right, top] = extent(&record);
        assert!(
            (left, bottom, right, top) == (10.0 - MARGIN_M, 5.0 - MARGIN_M, 30.0 + MARGIN_M, 15.0 + MARGIN_M)
        );
        let (sketch, _) = MapView::new(&record, 400.0, 300.0).draw();
        let Some(Shape::Chain { points, .. }) = sketch.shapes.first() else { panic!("no wall") };
        assert!((points[1][0] - points[0][0]) > 350.0, "{points:?}");
    }

    #[test]
    fn a_way_that_is_known_better_at_the_end_is_the_estimate() {
        let mut record = test_record();
        let of = |record: &RunRecord, role: Role| -> Vec<Vec<[f64; 2]>> {
            let (sketch, signs) = MapView::new(record, 400.0, 300.0).draw();
            let chains: Vec<Vec<[f64; 2]>> = sketch
                .shapes
                .into_iter()
                .filter_map(|shape| match shape {
                    Shape::Chain { role: found, points, .. } if found == role => Some(points),
                    _ => None,
                })
                .filter(|points| points.len() > 1)
                .collect();
            assert_eq!(chains.is_empty(), !signs.iter().any(|sign| sign.role == role));
            chains
        };
        assert!(of(&record, Role::AtTheTime).is_empty());
        let at_the_time = of(&record, Role::Estimate);
        record.known_way = vec![[0.0, 0.0], [0.5, 0.5], [1.0, 0.5]];
        assert_eq!(of(&record, Role::AtTheTime), at_the_time);
        assert_eq!(of(&record, Role::Estimate)[0].len(), 3);
    }

    #[test]
    fn the_ellipse_of_a_diagonal_covariance_has_its_half_axes_along_x_and_y() {
        let sample = Sample { covariance: [0.04, 0.0, 0.01], ..test_record().samples[0] };
        let outline = ellipse(&sample).unwrap();
        let [x, y, _] = sample.estimate;
        let along = outline.iter().map(|p| (p[0] - x).abs()).fold(0.0, f64::max);
        let across = outline.iter().map(|p| (p[1] - y).abs()).fold(0.0, f64::max);
        assert!(
            (along - 0.2 * RADIUS_95.sqrt()).abs() < 1e-9 && (across - 0.1 * RADIUS_95.sqrt()).abs() < 1e-9
        );
    }

    #[test]
    fn an_image_of_the_map_meets_its_corners_on_the_paper() {
        let record = test_record();
        let view = MapView::new(&record, 400.0, 300.0);
        let mut sketch = Sketch::sheet(400.0, 300.0);
        view.map(&mut sketch);
        let (image, Shape::Image { matrix: [a, b, c, d, e, f], .. }) =
            (record.map.clone().unwrap(), &sketch.shapes[0])
        else {
            panic!("no image")
        };
        let top_left = image.map_from_image() * Point2::new(0.0, f64::from(image.height) * image.pixel_m);
        let expected = view.at([top_left.x, top_left.y]);
        assert!((expected[0] - e).abs() < 1e-9 && (expected[1] - f).abs() < 1e-9);
        let bottom_right = image.map_from_image() * Point2::new(f64::from(image.width) * image.pixel_m, 0.0);
        let expected = view.at([bottom_right.x, bottom_right.y]);
        let (w, h) = (f64::from(image.width), f64::from(image.height));
        assert!((expected[0] - (a * w + c * h + e)).abs() < 1e-9);
        assert!((expected[1] - (b * w + d * h + f)).abs() < 1e-9);
    }
}
