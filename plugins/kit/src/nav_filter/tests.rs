use nalgebra::{DMatrix, Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::{Point3, Pose2, pose2, wrap_angle};
use rumbo_core::time::Time;
use serde_json::Value;

use super::*;

mod behavior;
mod vectors;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn vector3(value: &Value) -> Vector3<f64> {
    Vector3::from_vec(numbers(value))
}

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = value.as_array().unwrap().iter().map(numbers).collect();
    DMatrix::from_fn(rows.len(), rows[0].len(), |row, col| rows[row][col])
}

fn fixed<const R: usize, const C: usize>(value: &Value) -> SMatrix<f64, R, C> {
    let dynamic = matrix(value);
    assert_eq!(dynamic.shape(), (R, C));
    SMatrix::from_fn(|row, col| dynamic[(row, col)])
}

/// A device of a base that lies like this and does not move.
fn at_rest(nav_from_body: &UnitQuaternion<f64>) -> ImuSample {
    let up = nav_from_body.inverse() * Vector3::z();
    ImuSample { rates_rad_s: Vector3::zeros(), forces_m_s2: up * GRAVITY_M_S2 }
}

fn angles(roll_deg: f64, pitch_deg: f64, yaw_deg: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_euler_angles(roll_deg.to_radians(), pitch_deg.to_radians(), yaw_deg.to_radians())
}

fn filter() -> NavFilter {
    NavFilter::new(NavSettings::default()).unwrap()
}
