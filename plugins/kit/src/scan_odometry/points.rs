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
        self.point(scan);
        self.x.clear();
        self.y.clear();
        let [ahead, left] =
            [Vector3::x(), Vector3::y()].map(|axis: Vector3<f64>| base_from_sensor.rotation * axis);
        let at = base_from_sensor.translation.vector;
        self.origin = [at.x, at.y];
        let directions = self.cosines.iter().zip(&self.sines);
        for (&range_m, (cosine, sine)) in scan.ranges_m.iter().zip(directions) {
            if range_m >= scan.min_range_m && range_m <= scan.max_range_m {
                let (along, across) = (f64::from(range_m) * cosine, f64::from(range_m) * sine);
                self.x.push(at.x + along * ahead.x + across * left.x);
                self.y.push(at.y + along * ahead.y + across * left.y);
            }
        }
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
