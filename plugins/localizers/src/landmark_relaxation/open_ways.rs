//! Ways that the robot sees to be open: a turn, and then straight ahead.

use super::panorama::Panorama;
use rumbo_core::frames::{Pose2, pose2, wrap_angle};
use std::f64::consts::TAU;

/// A turn and then a way ahead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NextMove {
    /// First turn by this much, radians.
    pub turn_rad: f64,
    /// Then go so far, meters.
    pub way_m: f64,
}

impl NextMove {
    /// The robot after it, seen from before.
    pub fn base_from_next(&self) -> Pose2 {
        pose2(0.0, 0.0, self.turn_rad) * pose2(self.way_m, 0.0, 0.0)
    }
}

/// Moves of this length in so many directions that nothing bars for a disc of `radius_m`, those with small turns first.
pub fn open_moves(
    panorama: &Panorama,
    n_directions: usize,
    way_m: f64,
    radius_m: f64,
) -> impl Iterator<Item = NextMove> + '_ {
    let turn = move |k: usize| {
        let step = TAU / n_directions.max(1) as f64;
        let turn = step * k.div_ceil(2) as f64;
        wrap_angle(if k % 2 == 1 { turn } else { -turn })
    };
    let turns = (0..n_directions).map(turn);
    let open = turns.filter(move |turn_rad| panorama.is_open(*turn_rad, way_m, radius_m));
    open.map(move |turn_rad| NextMove { turn_rad, way_m })
}
