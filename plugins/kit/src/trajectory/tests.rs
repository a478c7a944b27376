//! Known answers, brute force, random rigid transforms, cases by hand, and files with every fault.

mod alignments;
mod associations;
mod files;
mod steps;
mod vectors;

use super::*;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_core::frames::Pose3;
use rumbo_core::time::{Span, Time};

fn pose(x: f64, y: f64, z: f64, [roll, pitch, yaw]: [f64; 3]) -> Pose3 {
    Pose3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

fn random_pose(rng: &mut Xoshiro256PlusPlus) -> Pose3 {
    let mut number = |most: f64| rng.random_range(-most..most);
    pose(number(9.0), number(9.0), number(9.0), [number(3.0), number(1.5), number(3.0)])
}

fn stamped(seconds: f64, world_from_body: Pose3) -> StampedPose {
    StampedPose { stamp: Time::from_secs(seconds), world_from_body }
}

fn trajectory(poses: Vec<StampedPose>) -> Trajectory {
    Trajectory::of(poses).0
}

/// A trajectory that stands still at these stamps.
fn at(stamps: &[f64]) -> Trajectory {
    trajectory(stamps.iter().map(|t| stamped(*t, Pose3::identity())).collect())
}

fn pair(seconds: f64, truth: Pose3, estimate: Pose3) -> PosePair {
    PosePair { stamp: Time::from_secs(seconds), truth, estimate }
}
