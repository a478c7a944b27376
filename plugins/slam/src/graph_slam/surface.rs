//! A scan as pieces of surface: points with the direction that the surface faces.

use rumbo_core::frames::{Pose2, Pose3};
use rumbo_core::messages::LaserScan;
use rumbo_kit::scan_match::{ScanShape, shape_of};
use std::ops::Deref;

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SurfacePoint {
    /// Place, meters.
    pub at: [f32; 2],
    /// Where the surface faces, toward the sensor that saw it; zero where the points around it are no surface.
    pub normal: [f32; 2],
    /// Variance across the surface beside that of every point, square meters.
    pub variance_m2: f32,
}

impl SurfacePoint {
    /// The points around it lie on a line.
    pub fn is_flat(&self) -> bool {
        self.normal != [0.0; 2]
    }

    /// The same point from another frame.
    pub fn seen_from(&self, frame: &Turn) -> SurfacePoint {
        SurfacePoint { at: frame.place(self.at), normal: frame.direction(self.normal), ..*self }
    }

    /// The same point of a surface that can be seen from here.
    fn facing(self, sensor: [f32; 2]) -> SurfacePoint {
        let [x, y] = [sensor[0] - self.at[0], sensor[1] - self.at[1]];
        let is_away = x * self.normal[0] + y * self.normal[1] < 0.0;
        SurfacePoint { normal: if is_away { self.normal.map(|v| -v) } else { self.normal }, ..self }
    }
}

/// What one scan shows.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Surface {
    /// In the base frame.
    pub points: Vec<SurfacePoint>,
    /// What it tells by its own shape, where it does not tell all directions many times over.
    pub shape: Option<ScanShape>,
}

impl Deref for Surface {
    type Target = [SurfacePoint];

    fn deref(&self) -> &[SurfacePoint] {
        &self.points
    }
}

impl Surface {
    /// Of a scan; roll and pitch of the sensor count.
    pub fn of(scan: &LaserScan, base_from_sensor: &Pose3, limits: &SurfaceLimits) -> Surface {
        let ranges_m = [limits.min_range_m, limits.max_range_m];
        let shape = shape_of(scan, base_from_sensor, ranges_m);
        let mut points = surface_of(scan, base_from_sensor, limits);
        if let Some(shape) = shape.as_ref().filter(|shape| limits.on_all_lines || shape.is_weak()) {
            put_on_lines(&mut points, shape);
        }
        Surface { points, shape }
    }

    /// A place to begin from other than the expected one, but along directions that the scan cannot tell: there it would stay.
    pub fn start(&self, expected: &Pose2, start: &Pose2) -> Pose2 {
        let blind = self.shape.as_ref().and_then(ScanShape::blind);
        blind.map_or(*start, |blind| blind.turned(&expected.rotation).held(expected, start))
    }
}

/// A pose ready to be applied to many points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turn {
    cos: f32,
    sin: f32,
    shift: [f32; 2],
}

impl Turn {
    pub fn new(pose: &Pose2) -> Turn {
        let shift = [pose.translation.x as f32, pose.translation.y as f32];
        Turn { cos: pose.rotation.re as f32, sin: pose.rotation.im as f32, shift }
    }

    pub fn place(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let [x, y] = self.direction([x, y]);
        [x + self.shift[0], y + self.shift[1]]
    }

    pub fn direction(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        [self.cos * x - self.sin * y, self.sin * x + self.cos * y]
    }
}

/// Which readings become points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SurfaceLimits {
    /// Nearer readings are left out, meters.
    pub min_range_m: f64,
    /// Farther ones too.
    pub max_range_m: f64,
    /// A surface reaches this far around a point, meters.
    pub window_m: f64,
    /// Points that lie farther from their line (root mean square) are no surface, meters.
    pub most_rough_m: f64,
    /// A surface reaches so many times what two beams are apart on a wall seen straight on, if that is more: far along a
    /// corridor beams meet the walls at a slant, and points with fewer than three on their surface tell no direction.
    pub reach_beams: f32,
    /// Noise of a reading grows by this times the square of the range, 1/m: a depth camera's.
    pub noise_growing_1_m: f32,
    /// Neighbors farther apart than so many times what their beams would be on a wall seen straight on are parts of
    /// different things.
    pub steepest: f32,
    /// Points that these limits put on no surface lie on the lines of the scan's shape wherever that is kept, not only where few
    /// points tell some direction.
    pub on_all_lines: bool,
}

impl SurfaceLimits {
    /// Of a laser that looks along corridors.
    pub const SLANTED: SurfaceLimits = SurfaceLimits {
        min_range_m: 0.1,
        max_range_m: 40.0,
        window_m: 0.25,
        most_rough_m: 0.03,
        reach_beams: 15.0,
        noise_growing_1_m: 0.0,
        steepest: 15.0,
        on_all_lines: false,
    };
}

/// Beams to each side that tell the direction of a surface at most.
const MOST_NEIGHBORS: usize = 8;
/// Points with more noise than this are on no surface, meters: the error of a map of rubble was least with it (0.03 to 0.06).
const MOST_NOISE_M: f32 = 0.05;
/// A line's points may lie so many times their noise off it.
const ROUGH_BY_NOISE: f32 = 1.5;
/// Lines of neighboring points are of much the same points, and err alike: they count as so many points of their own.
const OWN_SHARE: f32 = 0.3;

/// The points of a scan in the base frame; roll and pitch of the sensor count.
pub(crate) fn surface_of(
    scan: &LaserScan,
    base_from_sensor: &Pose3,
    limits: &SurfaceLimits,
) -> Vec<SurfacePoint> {
    let axes = base_from_sensor.rotation.to_rotation_matrix();
    let origin = base_from_sensor.translation;
    let sensor = [origin.x as f32, origin.y as f32];
    let placed: Vec<Option<([f32; 2], f32)>> = (0..)
        .zip(scan.ranges_m.iter())
        .map(|(idx, &reading_m)| {
            let range_m = f64::from(reading_m);
            let is_hit = reading_m >= scan.min_range_m && reading_m <= scan.max_range_m;
            if !is_hit || range_m < limits.min_range_m || range_m > limits.max_range_m {
                return None;
            }
            let (sin, cos) = scan.bearing_rad(idx).sin_cos();
            let (ahead, left) = (range_m * cos, range_m * sin);
            let x = origin.x + axes[(0, 0)] * ahead + axes[(0, 1)] * left;
            let y = origin.y + axes[(1, 0)] * ahead + axes[(1, 1)] * left;
            Some(([x as f32, y as f32], reading_m))
        })
        .collect();
    let step = scan.bearing_step_rad.abs() as f32;
    let point = |(idx, placed_here): (usize, &Option<([f32; 2], f32)>)| {
        let (at, range_m) = (*placed_here)?;
        let noise_m = limits.noise_growing_1_m * range_m * range_m;
        let around = neighbors(&placed, idx, at, range_m, step, limits);
        Some(point_among(&around, at, noise_m, limits).facing(sensor))
    };
    placed.iter().enumerate().filter_map(point).collect()
}

/// Points that are on no surface by its limits, but on a line by those of the scan's shape, face across that: loose, they would tell
/// the way along a wall, too, and where few others do they would decide it.
fn put_on_lines(points: &mut [SurfacePoint], shape: &ScanShape) {
    let mut rest = shape.points();
    for point in points.iter_mut().filter(|point| !point.is_flat()) {
        // Both are in order of bearing.
        let Some(idx) = rest.iter().position(|other| other.at == point.at) else { continue };
        let normal = rest.get(idx).and_then(|other| other.normal);
        rest = rest.get(idx + 1..).unwrap_or_default();
        if let Some(normal) = normal {
            point.normal = normal;
        }
    }
}

/// Where readings are noisy, a point is moved onto the line through those around it.
fn point_among(around: &Sums, at: [f32; 2], noise_m: f32, limits: &SurfaceLimits) -> SurfacePoint {
    let most_rough_m = (limits.most_rough_m as f32).max(ROUGH_BY_NOISE * noise_m);
    let normal = if noise_m > MOST_NOISE_M { [0.0; 2] } else { around.normal(most_rough_m) };
    if noise_m == 0.0 || normal == [0.0; 2] {
        return SurfacePoint { at, normal, variance_m2: noise_m * noise_m };
    }
    let off_m = (around.x * normal[0] + around.y * normal[1]) / around.n;
    let at = [at[0] + off_m * normal[0], at[1] + off_m * normal[1]];
    SurfacePoint { at, normal, variance_m2: noise_m * noise_m / (OWN_SHARE * around.n).max(1.0) }
}

/// What a line through a point and its neighbors is made of, seen from the point.
fn neighbors(
    placed: &[Option<([f32; 2], f32)>],
    idx: usize,
    at: [f32; 2],
    range_m: f32,
    step_rad: f32,
    limits: &SurfaceLimits,
) -> Sums {
    let mut sums = Sums::default();
    sums.add([0.0; 2]);
    let reach_m = (limits.window_m as f32).max(limits.reach_beams * step_rad * range_m);
    let before = placed.get(..idx).unwrap_or_default().iter().rev().take(MOST_NEIGHBORS);
    let after = placed.get(idx + 1..).unwrap_or_default().iter().take(MOST_NEIGHBORS);
    let mut walk = |neighbors: &mut dyn Iterator<Item = &Option<([f32; 2], f32)>>| {
        let mut last = (at, range_m);
        for neighbor in neighbors {
            let Some((place, range_m)) = *neighbor else { return };
            let gap_m = (place[0] - last.0[0]).hypot(place[1] - last.0[1]);
            let off = [place[0] - at[0], place[1] - at[1]];
            let is_far = off[0].hypot(off[1]) > reach_m;
            if is_far || gap_m > (limits.steepest * step_rad * range_m.min(last.1)).max(0.05) {
                return;
            }
            sums.add(off);
            last = (place, range_m);
        }
    };
    walk(&mut before.into_iter());
    walk(&mut after.into_iter());
    sums
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    n: f32,
    x: f32,
    y: f32,
    xx: f32,
    xy: f32,
    yy: f32,
}

impl Sums {
    fn add(&mut self, [x, y]: [f32; 2]) {
        self.n += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    /// Direction across the line through the points; zero where they are too few, or no line.
    fn normal(&self, most_rough_m: f32) -> [f32; 2] {
        if self.n < 3.0 {
            return [0.0; 2];
        }
        let (x, y) = (self.x / self.n, self.y / self.n);
        let (xx, xy, yy) = (self.xx / self.n - x * x, self.xy / self.n - x * y, self.yy / self.n - y * y);
        let half_gap = (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
        let least = (0.5 * (xx + yy) - half_gap).max(0.0);
        if least.sqrt() > most_rough_m || half_gap <= 4.0 * least {
            return [0.0; 2];
        }
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        [-angle.sin(), angle.cos()]
    }
}
