//! The depth camera as one row of 64 columns.

use crate::place::Place;
use rand::RngExt;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Pose3};
use rumbo_core::messages::{Data, LaserScan, Observation, PointCloud, SensorId};
use rumbo_core::rng::Rng;
use rumbo_core::time::Time;

/// What the camera gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gives {
    /// A scan with one beam a column.
    Scan,
    /// A cloud with one point a column.
    Cloud,
}

/// What the camera does not see.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Faults {
    /// Share of the pixels without a reading.
    pub lost: f64,
    /// Nothing nearer is read, meters.
    pub least_m: f64,
}

const N_COLUMNS: usize = 64;
const HALF_VIEW_RAD: f64 = 28.5 * std::f64::consts::PI / 180.0;
const NEAR_PLANE_M: f64 = 0.2;
const REACH_M: f64 = 3.5;

/// Bearing of a column, from right to left.
fn bearing_rad(column: usize) -> f64 {
    ((column as f64 + 0.5) / (N_COLUMNS as f64 / 2.0) - 1.0) * HALF_VIEW_RAD
}

/// What the camera sees.
pub fn look(
    place: &Place,
    map_from_base: &Pose2,
    stamp: Time,
    gives: Gives,
    faults: Faults,
    rng: &mut Rng,
) -> Observation {
    let ranges: Vec<f32> = (0..N_COLUMNS)
        .map(|column| {
            let bearing_rad = bearing_rad(column);
            let yaw_rad = map_from_base.rotation.angle();
            let range_m = place.range_m(map_from_base.translation.vector.into(), yaw_rad + bearing_rad);
            let depth_m = (range_m * bearing_rad.cos()).max(NEAR_PLANE_M);
            if (faults.lost > 0.0 && rng.random::<f64>() < faults.lost) || depth_m < faults.least_m {
                f32::NAN
            } else if depth_m > REACH_M {
                f32::INFINITY
            } else {
                (depth_m / bearing_rad.cos()) as f32
            }
        })
        .collect();
    let data = match gives {
        Gives::Scan => Data::LaserScan(LaserScan {
            first_bearing_rad: bearing_rad(0),
            bearing_step_rad: bearing_rad(1) - bearing_rad(0),
            max_range_m: 4.5,
            ranges_m: Buffer::from(ranges),
            ..LaserScan::default()
        }),
        Gives::Cloud => {
            let point = |(column, range): (usize, &f32)| {
                let (sin, cos) = bearing_rad(column).sin_cos();
                let is_hit = range.is_finite();
                let point = [range * cos as f32, range * sin as f32, 0.2];
                if is_hit { point } else { [f32::NAN; 3] }
            };
            let points: Vec<[f32; 3]> = ranges.iter().enumerate().map(point).collect();
            Data::PointCloud(PointCloud { points_m: Buffer::from(points) })
        }
    };
    Observation { sensor: SensorId(0), stamp, base_from_sensor: Pose3::identity(), valid: true, data }
}
