//! A force that leads no nearer to obstacles than a clearance.

use super::Obstacles;
use nalgebra::{Point2, Vector2};

/// The force without its parts into the obstacles that are nearer than `clearance_m`.
///
/// Where taking one part away leads into another obstacle, both would have to hold: then nothing is left, as in the
/// corner of two walls.
pub fn without_approach(
    force: Vector2<f64>,
    at: Point2<f64>,
    obstacles: &Obstacles,
    clearance_m: f64,
) -> Vector2<f64> {
    let mut kept = force;
    // An obstacle that is looked at before another may be approached again along the other's face.
    for _ in 0..2 {
        obstacles.near(at, |nearest| {
            let approach = kept.dot(&nearest.away);
            if nearest.distance_m < clearance_m && approach < 0.0 {
                kept -= nearest.away * approach;
            }
        });
    }
    let mut is_led_in = false;
    obstacles.near(at, |nearest| {
        let approach = kept.dot(&nearest.away);
        is_led_in |= nearest.distance_m < clearance_m && approach < -1e-9 * force.norm();
    });
    if is_led_in { Vector2::zeros() } else { kept }
}
