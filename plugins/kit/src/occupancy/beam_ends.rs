//! Where the beams of a scan end, in cells of a grid.

use rumbo_core::frames::{Pose2, Pose3};
use rumbo_core::messages::LaserScan;

/// What counts as a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamLimits {
    /// Nearer readings are dropped, meters.
    pub min_range_m: f64,
    /// Farther readings count as nothing seen, meters.
    pub max_range_m: f64,
    /// Space that a beam without an end is taken to have free, meters; zero where such a beam says nothing.
    pub clear_range_m: f64,
}

/// How a beam ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BeamEnd {
    /// At something.
    Hit,
    /// At nothing, up to here.
    Open,
    /// Says nothing.
    Nothing,
}

/// A sensor's pose on a grid, flat: its origin, and where its x and y axes point, in cells a meter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount2 {
    origin: [f64; 2],
    x_axis: [f64; 2],
    y_axis: [f64; 2],
}

impl Mount2 {
    /// The sensor on a grid whose frame is at its lower left corner. A tilted sensor's beams are projected to the
    /// floor; one that hangs upside down turns its beams the other way round.
    pub fn new(grid_from_base: &Pose2, base_from_sensor: &Pose3, resolution_m: f64) -> Mount2 {
        let grid_from_sensor = rumbo_core::frames::lift(grid_from_base) * base_from_sensor;
        let axes = grid_from_sensor.rotation.to_rotation_matrix();
        let cells = |x: f64, y: f64| [x / resolution_m, y / resolution_m];
        Mount2 {
            origin: cells(grid_from_sensor.translation.x, grid_from_sensor.translation.y),
            x_axis: cells(axes[(0, 0)], axes[(1, 0)]),
            y_axis: cells(axes[(0, 1)], axes[(1, 1)]),
        }
    }

    /// Origin of the sensor, cells.
    pub fn origin(&self) -> [f64; 2] {
        self.origin
    }
}

/// The ends of all beams of one scan. Kept between scans, so that a warm one allocates nothing.
#[derive(Debug, Clone, Default)]
pub struct BeamEnds {
    /// The sensor, cells.
    pub origin: [f32; 2],
    /// End of each beam, cells.
    pub x: Vec<f32>,
    /// End of each beam, cells.
    pub y: Vec<f32>,
    /// Length of each beam, cells.
    pub length: Vec<f32>,
    /// How each beam ends.
    pub ends: Vec<BeamEnd>,
    /// Angle between neighbors, radians.
    pub step_rad: f64,
    /// The last beam is the first one's neighbor.
    pub is_closed: bool,
    /// Beams that end at something.
    pub n_hits: usize,
    cosines: Vec<f32>,
    sines: Vec<f32>,
    first_rad: f64,
}

impl BeamEnds {
    /// Places the beams of a scan. Readings follow REP-117: not-a-number says nothing, infinity that nothing is near.
    pub fn place(&mut self, scan: &LaserScan, mount: &Mount2, limits: &BeamLimits) {
        self.point(scan);
        let n = scan.ranges_m.len();
        self.origin = mount.origin.map(|v| v as f32);
        self.is_closed = self.step_rad.abs() * n as f64 >= std::f64::consts::TAU - 0.5 * self.step_rad.abs();
        self.n_hits = 0;
        self.ends.clear();
        self.x.resize(n, 0.0);
        self.y.resize(n, 0.0);
        self.length.resize(n, 0.0);
        let least_m = limits.min_range_m.max(scan.min_range_m.into()) as f32;
        let most_m = limits.max_range_m.min(scan.max_range_m.into()) as f32;
        let open_m = (limits.clear_range_m as f32).min(most_m);
        let axes = [mount.x_axis.map(|v| v as f32), mount.y_axis.map(|v| v as f32)];
        let cells_per_m = axes[0][0].hypot(axes[0][1]);
        let directions = self.cosines.iter().zip(&self.sines);
        for ((idx, &reading_m), (cosine, sine)) in scan.ranges_m.iter().enumerate().zip(directions) {
            let (end, range_m) = read(reading_m, least_m, most_m, open_m);
            self.n_hits += usize::from(end == BeamEnd::Hit);
            self.ends.push(end);
            let (ahead, left) = (range_m * cosine, range_m * sine);
            self.x[idx] = self.origin[0] + ahead * axes[0][0] + left * axes[1][0];
            self.y[idx] = self.origin[1] + ahead * axes[0][1] + left * axes[1][1];
            self.length[idx] = range_m * cells_per_m;
        }
    }

    /// How the beam before the first one ends, where the fan is closed.
    pub(super) fn neighbor_before_first(&self) -> BeamEnd {
        self.ends.last().copied().filter(|_| self.is_closed).unwrap_or(BeamEnd::Nothing)
    }

    /// How the beam after this one ends.
    pub(super) fn after(&self, idx: usize) -> BeamEnd {
        let next = self.ends.get(idx + 1).or_else(|| self.ends.first().filter(|_| self.is_closed));
        next.copied().unwrap_or(BeamEnd::Nothing)
    }

    /// Directions of the beams; made anew only when the scanner changes.
    fn point(&mut self, scan: &LaserScan) {
        let n = scan.ranges_m.len();
        let same = self.cosines.len() == n
            && self.first_rad.to_bits() == scan.first_bearing_rad.to_bits()
            && self.step_rad.to_bits() == scan.bearing_step_rad.to_bits();
        if same {
            return;
        }
        (self.first_rad, self.step_rad) = (scan.first_bearing_rad, scan.bearing_step_rad);
        self.cosines.clear();
        self.sines.clear();
        for idx in 0..n {
            let (sine, cosine) = scan.bearing_rad(idx).sin_cos();
            self.cosines.push(cosine as f32);
            self.sines.push(sine as f32);
        }
    }
}

/// What one reading says, and how far.
fn read(reading_m: f32, least_m: f32, most_m: f32, open_m: f32) -> (BeamEnd, f32) {
    if reading_m >= least_m && reading_m <= most_m {
        (BeamEnd::Hit, reading_m)
    } else if reading_m > most_m && open_m > 0.0 {
        (BeamEnd::Open, open_m)
    } else {
        (BeamEnd::Nothing, 0.0)
    }
}
