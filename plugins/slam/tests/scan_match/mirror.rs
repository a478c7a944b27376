//! The same world in a mirror, whose walls lie on the edges of cells.

use super::course::Mapper;
use super::world::{LoopWorld, laser, observation};
use rumbo_core::frames::{Pose2, Twist, pose2};
use rumbo_core::messages::{Data, LaserScan, Odometry};
use rumbo_slam::scan_match_slam::ScanMatchSlamParams;

/// Left and lower, right and upper edge of a room and of what stands in it, meters.
const ROOM: [[f64; 4]; 4] =
    [[0.5, 0.5, 9.5, 5.5], [3.5, 4.5, 4.0, 5.5], [7.5, 3.0, 8.5, 4.0], [3.0, 1.0, 4.0, 2.0]];

fn room(side: f64) -> LoopWorld {
    let edges = |[x0, y0, x1, y1]: [f64; 4]| {
        let (y0, y1) = (side * y0, side * y1);
        [[x0, y0, x1, y0], [x1, y0, x1, y1], [x1, y1, x0, y1], [x0, y1, x0, y0]]
    };
    LoopWorld::of(ROOM.into_iter().flat_map(edges).collect())
}

/// Half a turn in steps of one degree, without noise, from the robot's right to its left; in the mirror the reverse.
fn scan(world: &LoopWorld, map_from_base: &Pose2, side: f64) -> LaserScan {
    let range = |k: i32| world.range_m(map_from_base, side * f64::from(k - 90).to_radians()) as f32;
    LaserScan {
        first_bearing_rad: side * -90f64.to_radians(),
        bearing_step_rad: side * 1f64.to_radians(),
        max_range_m: 15.0,
        ranges_m: (0..181).map(range).collect::<Vec<f32>>().into(),
        ..LaserScan::default()
    }
}

/// Estimates of an arc, seen from this side and turned back.
fn way(side: f64) -> Vec<Pose2> {
    let world = room(side);
    let start = pose2(1.75, side * 2.75, 0.0);
    let mut mapper = Mapper::start_at(&ScanMatchSlamParams::default(), start);
    let step = |k: u32| {
        let odom_from_base = Twist::new(0.2, side * 0.05).integrate(0.1 * f64::from(k));
        let time_s = 0.1 * f64::from(k);
        let odometry = Odometry { odom_from_base, ..Odometry::default() };
        let seen = [
            observation(0, time_s, Data::Odometry(odometry)),
            laser(time_s, scan(&world, &(start * odom_from_base), side)),
        ];
        let estimate = mapper.see(&seen).pose2();
        pose2(estimate.translation.x, side * estimate.translation.y, side * estimate.rotation.angle())
    };
    (0..150).map(step).collect()
}

#[test]
fn a_world_in_the_mirror_gives_the_way_in_the_mirror() {
    for (k, (one, other)) in way(1.0).iter().zip(way(-1.0)).enumerate() {
        let apart = one.inverse() * other;
        let [away_m, away_rad] = [apart.translation.vector.norm(), apart.rotation.angle().abs()];
        assert!(away_m < 0.01 && away_rad < 0.009, "{k}: {away_m} m, {away_rad} rad");
    }
}
