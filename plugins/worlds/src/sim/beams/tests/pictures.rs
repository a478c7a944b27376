//! Depth pictures of a furnished room against a search through everything in it, with formulas of their own.

use nalgebra::Vector3;
use rumbo_core::frames::Pose2;

use super::*;

/// A wall with a door frame (jambs and a lintel), a table (top and legs), a cabinet, people and a pane of glass.
const FURNISHED: &str = r#"
bounds = [-2, -5, 9, 5]
wall_height_m = 2.5
[[wall]]
from = [7, -4]
to = [7, 4]
[[wall]]
from = [4, -4]
to = [4, -0.5]
[[wall]]
from = [4, 0.5]
to = [4, 4]
[[box]]
center = [4, 0]
size = [0.1, 1]
z_min_m = 2.0
z_max_m = 2.5
[[wall]]
from = [1, -3]
to = [3, -3]
material = "glass"
[[box]]
center = [2, 1]
size = [1.2, 0.8]
z_min_m = 0.70
z_max_m = 0.74
[[box]]
center = [1.45, 0.65]
size = [0.05, 0.05]
z_max_m = 0.70
[[box]]
center = [2.6, -1.2]
size = [0.5, 0.4]
yaw_deg = 30.0
z_max_m = 1.1
[[person]]
route = [[3.2, -2.5], [3.2, 3.5]]
radius_m = 0.25
speed_m_s = 1.0
"#;

type Vec3 = Vector3<f64>;

/// A box by its middle, half sizes and yaw: the slabs of the box's own frame.
fn slabs(from: Vec3, along: Vec3, [x, y, yaw]: [f64; 3], half: [f64; 2], z: [f64; 2]) -> f64 {
    let turn = nalgebra::Rotation3::from_axis_angle(&Vec3::z_axis(), -yaw);
    let (from, along) = (turn * (from - Vec3::new(x, y, 0.0)), turn * along);
    let bounds = [[-half[0], half[0]], [-half[1], half[1]], z];
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let [a, b] = bounds[axis].map(|bound| (bound - from[axis]) / along[axis]);
        (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
    }
    if enter <= leave && enter > 0.0 { enter } else { f64::INFINITY }
}

/// A plane across x, from one y to another.
fn wall(from: Vec3, along: Vec3, x: f64, y: [f64; 2]) -> f64 {
    let way = (x - from.x) / along.x;
    let at = from + along * way;
    let is_met = way > 0.0 && at.y >= y[0] && at.y <= y[1] && at.z >= 0.0 && at.z <= 2.5;
    if is_met { way } else { f64::INFINITY }
}

/// An upright cylinder: its side, and its lids.
fn cylinder(from: Vec3, along: Vec3, [x, y, radius]: [f64; 3], height: f64) -> f64 {
    let (offset, flat) = (from.xy() - nalgebra::Vector2::new(x, y), along.xy());
    let (a, b, c) = (flat.norm_squared(), offset.dot(&flat), offset.norm_squared() - radius * radius);
    let root = (b * b - a * c).sqrt();
    let side = (-b - root) / a;
    let on_side = (from.z + along.z * side) >= 0.0 && (from.z + along.z * side) <= height;
    let lid = (height - from.z) / along.z;
    let on_lid = (offset + flat * lid).norm() <= radius && lid > 0.0;
    let side = if on_side && side > 0.0 { side } else { f64::INFINITY };
    side.min(if on_lid { lid } else { f64::INFINITY })
}

/// The depth of a ray with one meter along the axis; people are 1.8 m.
fn depth_slowly(from: Vec3, along: Vec3, person_y: f64) -> f64 {
    let floor = if along.z < 0.0 { -from.z / along.z } else { f64::INFINITY };
    [
        floor,
        wall(from, along, 7.0, [-4.0, 4.0]),
        wall(from, along, 4.0, [-4.0, -0.5]),
        wall(from, along, 4.0, [0.5, 4.0]),
        slabs(from, along, [4.0, 0.0, 0.0], [0.05, 0.5], [2.0, 2.5]),
        slabs(from, along, [2.0, 1.0, 0.0], [0.6, 0.4], [0.70, 0.74]),
        slabs(from, along, [1.45, 0.65, 0.0], [0.025, 0.025], [0.0, 0.70]),
        slabs(from, along, [2.6, -1.2, 30f64.to_radians()], [0.25, 0.2], [0.0, 1.1]),
        cylinder(from, along, [3.2, person_y, 0.25], PERSON_M),
    ]
    .into_iter()
    .fold(f64::INFINITY, f64::min)
}

/// How tall people are in world files that do not say.
const PERSON_M: f64 = 1.8;

#[test]
fn pictures_show_all_heights_tables_people_and_door_frames() {
    let camera = Intrinsics { width: 64, height: 48, focal_px: [59.0, 59.0], center_px: [31.5, 23.5] };
    let mut place = place(FURNISHED);
    for (time_s, person_y) in [(0.0, -2.5), (2.5, 0.0)] {
        place.set_time(time_s, &Pose2::identity());
        for (height_m, yaw, pitch) in [(0.3, 0.0, 0.0), (1.0, 0.1, 0.3), (0.4, -0.2, -0.4), (1.9, 0.4, 0.5)] {
            let mount = mount(-1.0, -0.3, height_m, yaw, pitch);
            let found = Eyes::default().depths(&mut place, &mount, &camera, 20.0).to_vec();
            let mut n_off = 0;
            for (pixel, depth_m) in found.iter().enumerate() {
                let (row, column) = (pixel / 64, pixel % 64);
                let ray = Vec3::new(1.0, (31.5 - column as f64) / 59.0, (23.5 - row as f64) / 59.0);
                let exact_m = depth_slowly(mount.translation.vector, mount.rotation * ray, person_y);
                // Rays that pass an edge within a rounding may go either way.
                let is_same = (f64::from(*depth_m) - exact_m).abs() < 1e-5
                    || (depth_m.is_infinite() && exact_m.is_infinite());
                n_off += usize::from(!is_same);
            }
            assert!(n_off <= 3, "{n_off} pixels of {time_s} s, {height_m} m, {pitch}");
        }
    }
}
