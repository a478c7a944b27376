use rumbo_core::frames::{lift, pose2};
use rumbo_kit::map_file::MapImage;
use rumbo_kit::world_file::parse_world;

use super::*;

mod pictures;

fn place(text: &str) -> Place {
    Place::new(&parse_world(text, std::path::Path::new("test.toml")).unwrap(), None)
}

fn mount(x: f64, y: f64, z: f64, yaw: f64, pitch: f64) -> Pose3 {
    lift(&pose2(x, y, yaw))
        * Pose3::from_parts(
            [0.0, 0.0, z].into(),
            nalgebra::UnitQuaternion::from_euler_angles(0.0, pitch, 0.0),
        )
}

fn range(place: &mut Place, mount: &Pose3, bearing_rad: f64) -> f64 {
    let fan = Fan { first_bearing_rad: bearing_rad, bearing_step_rad: 0.1, n_beams: 1 };
    f64::from(Eyes::default().beams(place, mount, fan, 50.0)[0])
}

const ROOM: &str = r#"
[[wall]]
from = [-1, -4]
to = [-1, 4]
[[wall]]
from = [6, -4]
to = [6, 4]
[[wall]]
from = [4, -4]
to = [4, 4]
material = "glass"
[[box]]
center = [3, 0]
size = [1, 1]
z_min_m = 0.70
z_max_m = 0.75
"#;

#[test]
fn light_passes_glass_and_goes_under_a_table() {
    let mut place = place(ROOM);
    assert!((range(&mut place, &mount(0.0, 0.0, 0.3, 0.0, 0.0), 0.0) - 6.0).abs() < 1e-6);
    assert!(
        (range(&mut place, &mount(0.0, 0.0, 0.72, 0.0, 0.0), 0.0) - 2.5).abs() < 1e-6,
        "into the table top"
    );
    assert!((range(&mut place, &mount(0.0, 0.0, 0.3, 1.0, 0.0), -1.0) - 6.0).abs() < 1e-6, "turned");
    assert!((range(&mut place, &mount(0.0, 0.0, 0.3, 0.0, 0.0), std::f64::consts::PI) - 1.0).abs() < 1e-6);
    assert!(range(&mut place, &mount(0.0, 0.0, 2.5, 0.0, 0.0), 0.0).is_infinite(), "above the walls");
}

#[test]
fn a_scanner_that_looks_down_sees_the_floor_and_table_tops_from_above() {
    let mut place = place(ROOM);
    // 30 degrees down from 1 m: the floor after 2 m, over the floor 1.73 m: in front of the table.
    let down = mount(0.0, 0.0, 1.0, 0.0, 30f64.to_radians());
    assert!((range(&mut place, &down, 0.0) - 2.0).abs() < 1e-6);
    // From (1, 0) at 1 m, 0.25 m above the top, at 6 degrees: top after 0.25 / sin(6), 2.38 m over the floor: x = 3.38.
    let onto = mount(1.0, 0.0, 1.0, 0.0, 6f64.to_radians());
    assert!((range(&mut place, &onto, 0.0) - 0.25 / 6f64.to_radians().sin()).abs() < 1e-6);
    // A beam to the left of the tilted fan is level.
    assert!(range(&mut place, &down, std::f64::consts::FRAC_PI_2).is_infinite());
    // Straight down, and straight up into nothing.
    let floor = mount(0.0, 0.0, 1.5, 0.3, std::f64::consts::FRAC_PI_2);
    assert!((range(&mut place, &floor, 0.0) - 1.5).abs() < 1e-6);
    let sky = mount(0.0, 0.0, 1.5, 0.3, -std::f64::consts::FRAC_PI_2);
    assert!(range(&mut place, &sky, 0.0).is_infinite());
}

#[test]
fn an_upside_down_scanner_sees_its_left_on_the_right() {
    let mut place = place("[[wall]]\nfrom = [-9, 2]\nto = [9, 2]\n");
    let roll = nalgebra::UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0);
    let upside_down = Pose3::from_parts([0.0, 0.0, 0.3].into(), roll);
    assert!((range(&mut place, &upside_down, -std::f64::consts::FRAC_PI_2) - 2.0).abs() < 1e-6);
    assert!(range(&mut place, &upside_down, std::f64::consts::FRAC_PI_2).is_infinite());
}

#[test]
fn a_background_map_with_a_turned_origin_is_met_where_it_lies() {
    // One wall cell (2, 0) of 0.5 m; the map's corner at (1, 1), turned by 90 degrees: its x axis points to map y.
    let mut cells = vec![0; 12];
    cells[2] = 100;
    let map = MapImage {
        width: 4,
        height: 3,
        resolution_m: 0.5,
        origin: [1.0, 1.0, std::f64::consts::FRAC_PI_2],
        cells,
    };
    let scene =
        parse_world("bounds = [0, 0, 1, 1]\n[[box]]\ncenter = [-3, 1.5]\nsize = [1, 1]\n", "w.toml".as_ref());
    let mut place = Place::new(&scene.unwrap(), Some(&map));
    // The wall covers map x in [0.5, 1], y in [2, 2.5].
    let up = mount(0.75, 0.0, 0.3, std::f64::consts::FRAC_PI_2, 0.0);
    assert!((range(&mut place, &up, 0.0) - 2.0).abs() < 1e-6);
    let back = mount(3.0, 2.25, 0.3, std::f64::consts::PI, 0.0);
    assert!((range(&mut place, &back, 0.0) - 2.0).abs() < 1e-6);
    // The box left of the map widens the lattice.
    let left = mount(3.0, 1.5, 0.3, std::f64::consts::PI, 0.0);
    assert!((range(&mut place, &left, 0.0) - 5.5).abs() < 1e-6);
}

#[test]
fn people_and_doors_are_seen_where_they_are_at_that_time() {
    let mut place = place(
        r#"
[[wall]]
from = [10, -4]
to = [10, 4]
[[door]]
from = [6, -1]
to = [6, 1]
open_at_s = 5.0
[[person]]
route = [[8, 3], [8, -3]]
speed_m_s = 1.0
start_s = 4.0
"#,
    );
    let sensor = mount(0.0, 0.0, 0.3, 0.0, 0.0);
    for (time_s, expected_m) in [(0.0, 6.0), (5.0, 10.0), (7.0, 7.75), (9.0, 10.0)] {
        place.set_time(time_s, &rumbo_core::frames::Pose2::identity());
        assert!((range(&mut place, &sensor, 0.0) - expected_m).abs() < 1e-6, "at {time_s} s");
    }
}

#[test]
fn a_depth_picture_measures_along_the_optical_axis() {
    let mut place = place(ROOM);
    let camera = Intrinsics { width: 9, height: 7, focal_px: [4.0, 4.0], center_px: [4.0, 3.0] };
    let mut eyes = Eyes::default();
    let depths = eyes.depths(&mut place, &mount(0.0, 0.0, 0.5, 0.0, 0.0), &camera, 20.0).to_vec();
    let at = |col: usize, row: usize| f64::from(depths[row * 9 + col]);
    // Every pixel of the wall at x = 6 has depth 6; lower pixels meet the floor at depth z / down = 0.5 * 4 / rows.
    assert!((at(4, 3) - 6.0).abs() < 1e-6 && (at(6, 3) - 6.0).abs() < 1e-6);
    assert!(
        (at(4, 4) - 2.0).abs() < 1e-6 && (at(8, 4) - 2.0).abs() < 1e-6 && (at(4, 6) - 2.0 / 3.0).abs() < 1e-6
    );
    // One row up rises 0.25 per meter: over the wall's 2 m at 6 m? No: 0.5 + 1.5 = 2.0 meets its edge; two rows pass.
    assert!(at(4, 1).is_infinite());
}

#[test]
fn a_cone_hears_the_nearest_thing_in_it_from_the_transducer() {
    let mut place = place("[[wall]]\nfrom = [2, -9]\nto = [2, 9]\n[[wall]]\nfrom = [-9, -3]\nto = [9, -3]\n");
    let mut eyes = Eyes::default();
    let ring = Ring { bearings_rad: &[0.0, -0.1, 1.0], cone_rad: 25f64.to_radians(), ring_radius_m: 0.2 };
    let heard = eyes.cones(&mut place, &mount(0.0, 0.0, 0.3, 0.0, 0.0), ring, 5.0);
    assert!((heard[0] - 1.8).abs() < 1e-6);
    // The perpendicular lies inside the cone, one degree steps find it to within a hair.
    let face_x = 0.2 * 0.1f64.cos();
    assert!((f64::from(heard[1]) - (2.0 - face_x)).abs() < 2e-4, "{}", heard[1]);
    let nearest_edge_rad = 1.0 - 12.5f64.to_radians();
    let expected = (2.0 - 0.2 * 1f64.cos()) / nearest_edge_rad.cos();
    assert!((f64::from(heard[2]) - expected).abs() < 1e-6);
}

#[test]
fn the_warm_eye_gives_the_same_answers_as_a_fresh_one() {
    let mut place = place(ROOM);
    let fan = Fan { first_bearing_rad: -1.5, bearing_step_rad: 0.05, n_beams: 61 };
    let mut warm = Eyes::default();
    for shot in 0..20 {
        let sensor = mount(f64::from(shot) * 0.1, 0.3, 0.3, f64::from(shot), 0.0);
        let seen = warm.beams(&mut place, &sensor, fan, 8.0).to_vec();
        assert_eq!(seen, Eyes::default().beams(&mut place, &sensor, fan, 8.0));
    }
    assert_eq!((warm.fans.len(), warm.ranges_m.len()), (1, 61));
}
