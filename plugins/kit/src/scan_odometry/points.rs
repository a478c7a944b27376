//! The points of a scan in the robot's plane.

use nalgebra::Vector3;
use rumbo_core::frames::Pose3;
use rumbo_core::messages::LaserScan;

/// Where the beams of one scan ended, in the base frame. Kept between scans, so that a warm one allocates nothing.
#[derive(Debug, Clone, Default)]
pub struct ScanPoints {
    /// Ahead of the base, meters.
    pub x: Vec<f64>,
    /// Left of the base, meters.
    pub y: Vec<f64>,
    /// Where the beams came from, meters.
    pub origin: [f64; 2],
    cosines: Vec<f64>,
    sines: Vec<f64>,
    first_rad: f64,
    step_rad: f64,
}

impl ScanPoints {
    /// Places the hits of a scan; a tilted scanner's are projected to the floor.
    pub fn place(&mut self, scan: &LaserScan, base_from_sensor: &Pose3) {
        self.place_above(scan, base_from_sensor, f64::NEG_INFINITY);
    }

    /// The same without what is lower than this, meters: a scanner that looks down sees the floor.
    pub fn place_above(&mut self, scan: &LaserScan, base_from_sensor: &Pose3, lowest_m: f64) {
        self.point(scan);
        let [ahead, left] =
            [Vector3::x(), Vector3::y()].map(|axis: Vector3<f64>| base_from_sensor.rotation * axis);
        let at = base_from_sensor.translation.vector;
        self.clear([at.x, at.y]);
        for (idx, &range_m) in scan.ranges_m.iter().enumerate() {
            let (Some(cosine), Some(sine)) = (self.cosines.get(idx), self.sines.get(idx)) else { break };
            if range_m >= scan.min_range_m && range_m <= scan.max_range_m {
                let (along, across) = (f64::from(range_m) * cosine, f64::from(range_m) * sine);
                let place = at + ahead * along + left * across;
                if place.z >= lowest_m {
                    self.push([place.x, place.y]);
                }
            }
        }
    }

    /// No points, of beams from this place.
    pub fn clear(&mut self, origin: [f64; 2]) {
        self.x.clear();
        self.y.clear();
        self.origin = origin;
    }

    /// One more.
    pub fn push(&mut self, [x, y]: [f64; 2]) {
        self.x.push(x);
        self.y.push(y);
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// There are none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Directions of the beams; made anew only when the scanner changes.
    fn point(&mut self, scan: &LaserScan) {
        let n = scan.ranges_m.len();
        let is_same = self.cosines.len() == n
            && self.first_rad.to_bits() == scan.first_bearing_rad.to_bits()
            && self.step_rad.to_bits() == scan.bearing_step_rad.to_bits();
        if is_same {
            return;
        }
        (self.first_rad, self.step_rad) = (scan.first_bearing_rad, scan.bearing_step_rad);
        let beams = (0..n).map(|idx| scan.bearing_rad(idx).sin_cos());
        (self.sines, self.cosines) = beams.unzip();
    }
}
