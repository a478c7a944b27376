//! What a related landmark says of the pose and of the place it comes from.

use super::correspondence::Relation;
use super::landmark_errors::{LandmarkErrors, spread};
use super::mapped_marks::MappedMark;
use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};
use rumbo_core::frames::{Point2, Pose2, pose2, wrap_angle};
use rumbo_kit::landmarks::Landmark;

/// A landmark seen, with where the map has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// In the sensor's frame.
    pub seen: Landmark,
    /// On the map.
    pub mapped: MappedMark,
    /// About what an offset of the wall turns it: the middle of the first view. Of a point its place.
    pub pivot: Point2,
    /// Covariance of the difference, but for the offset.
    pub covariance: Matrix2<f64>,
    /// The place's number, if it keeps its offset.
    pub slot: Option<usize>,
}

/// A sighting at a pose: how far off it is, and how that changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// What was seen less what is expected: distance and direction of a wall, x and y of a point.
    pub off: Vector2<f64>,
    /// Change of the expectation with x, y, yaw of the robot on the map.
    pub by_pose: Matrix2x3<f64>,
    /// Change of the expectation with the place's offset.
    pub by_offset: Matrix2<f64>,
}

impl Sighting {
    /// What a relation says; `pivot` and `slot` are the place's.
    pub fn new(
        relation: &Relation,
        mapped: MappedMark,
        pivot: Point2,
        slot: Option<usize>,
        errors: &LandmarkErrors,
    ) -> Sighting {
        let mut covariance = spread(&relation.seen, errors.range_m) + spread(&relation.known, 0.0);
        if slot.is_none() {
            covariance += Matrix2::from_diagonal(&offset_variances(&mapped, errors));
        }
        Sighting { seen: relation.seen, mapped, pivot, covariance, slot }
    }

    /// At a pose of the robot (x, y, yaw) and an offset of the place.
    pub fn residual(&self, pose: &Vector3<f64>, offset: &Vector2<f64>, base_from_sensor: &Pose2) -> Residual {
        let map_from_sensor = pose2(pose.x, pose.y, pose.z) * base_from_sensor;
        let yaw = map_from_sensor.rotation.angle();
        let sensor = Point2::from(map_from_sensor.translation.vector);
        let arm = sensor.coords - Vector2::new(pose.x, pose.y);
        // How the sensor moves when the robot turns.
        let swing = Vector2::new(-arm.y, arm.x);
        if self.mapped.is_wall {
            let (sin, cos) = self.mapped.normal_rad.sin_cos();
            let on_line = self.pivot
                + Vector2::new(cos, sin) * (self.mapped.place - self.pivot).dot(&Vector2::new(cos, sin));
            let (sin, cos) = (self.mapped.normal_rad + offset.y).sin_cos();
            let (normal, tangent) = (Vector2::new(cos, sin), Vector2::new(-sin, cos));
            let way = on_line - sensor;
            let expected_m = normal.dot(&way) + offset.x;
            let turn = wrap_angle(self.seen.bearing_rad - (self.mapped.normal_rad + offset.y - yaw));
            return Residual {
                off: Vector2::new(self.seen.distance_m - expected_m, turn),
                by_pose: Matrix2x3::new(-cos, -sin, -normal.dot(&swing), 0.0, 0.0, -1.0),
                by_offset: Matrix2::new(1.0, tangent.dot(&way), 0.0, 1.0),
            };
        }
        let into_sensor = map_from_sensor.rotation.inverse();
        let expected = into_sensor * (self.mapped.place + offset - sensor);
        let turned = Vector2::new(expected.y, -expected.x) - into_sensor * swing;
        let axes = into_sensor.to_rotation_matrix().into_inner();
        let seen = Vector2::from(self.seen.position());
        Residual {
            off: seen - expected,
            by_pose: Matrix2x3::from_columns(&[-axes.column(0), -axes.column(1), turned]),
            by_offset: axes,
        }
    }
}

/// Variances of the two parts of a place's offset before it was seen.
pub fn offset_variances(mapped: &MappedMark, errors: &LandmarkErrors) -> Vector2<f64> {
    let other = if mapped.is_wall { errors.map_rad } else { errors.map_m };
    Vector2::new(errors.map_m.powi(2), other.powi(2))
}
