//! A force that leads no nearer to obstacles than a clearance.

use super::Obstacles;
use nalgebra::{Point2, Vector2};

/// The force without its parts into the pieces of obstacles that are nearer than `clearance_m`, which must not be above the
/// obstacles' reach.
///
/// Where taking one part away leads into another piece, both would have to hold: then nothing is left, as in the corner of
/// two walls.
pub fn without_approach(
    force: Vector2<f64>,
    at: Point2<f64>,
    obstacles: &Obstacles,
    clearance_m: f64,
) -> Vector2<f64> {
    let mut kept = force;
    // A piece that is looked at before another may be approached again along the other's face.
    for _ in 0..2 {
        obstacles.pieces_within(at, clearance_m, |_, away| {
            let approach = kept.dot(&away);
            if approach < 0.0 {
                kept -= away * approach;
            }
        });
    }
    let mut is_led_in = false;
    obstacles.pieces_within(at, clearance_m, |_, away| {
        is_led_in |= kept.dot(&away) < -1e-9 * force.norm();
    });
    if is_led_in { Vector2::zeros() } else { kept }
}
