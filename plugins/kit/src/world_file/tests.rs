use super::*;

fn parse(text: &str) -> Result<WorldScene, WorldFileError> {
    parse_world(text, Path::new("hall.toml"))
}

#[test]
fn ramps_and_steps_are_raised_floor_and_their_faults_are_told() {
    let scene = parse(
        "bounds = [0, 0, 9, 9]\n[[ramp]]\nname = 'up'\ncenter = [2, 1]\nsize = [2, 1]\nyaw_deg = 90\nz_to_m = 0.5\n\
         [[step]]\ncenter = [5, 1]\nsize = [2, 1]\nheight_m = 0.15\n",
    )
    .unwrap();
    let [up, step] = scene.ramps.as_slice() else { panic!("{:?}", scene.ramps) };
    assert_eq!((up.name.as_str(), up.z_from_m, up.z_to_m), ("up", 0.0, 0.5));
    assert!((up.yaw_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!((step.name.as_str(), step.z_from_m, step.z_to_m), ("step", 0.15, 0.15));
    let bad = "bounds = [0, 0, 9, 9]\n[[ramp]]\ncenter = [2, 1]\nsize = [2, 0]\n[[ramp]]\ncenter = [2, 1]\n\
               size = [2, 1]\nz_to_m = 0\n[[ramp]]\ncenter = [2, 1]\nsize = [2, 1]\nz_to_m = -1\n[[step]]\n\
               center = [2, 1]\nsize = [2, 1]\nhigh_m = 1\n";
    let Err(WorldFileError::Faults { faults, .. }) = parse(bad) else { panic!("no faults") };
    let mut keys: Vec<&str> = faults.iter().map(|fault| fault.key.as_str()).collect();
    keys.sort_unstable();
    assert_eq!(
        keys,
        [
            "ramp[0].size",
            "ramp[0].z_to_m",
            "ramp[1].z_to_m",
            "ramp[2].z_to_m",
            "step[0].height_m",
            "step[0].high_m"
        ]
    );
}

#[test]
fn every_kind_of_thing_is_read_with_its_defaults() {
    let scene = parse(
        r#"
name = "hall"
wall_height_m = 2.5
bounds = [-1, -1, 9, 9]
[[wall]]
from = [0, 0]
to = [8, 0]
[[wall]]
from = [0, 0]
to = [0, 8]
height_m = 1.2
material = "glass"
mapped = false
[[box]]
name = "table top"
center = [2, 3]
size = [1.2, 0.8]
yaw_deg = 90
z_min_m = 0.70
z_max_m = 0.75
[[person]]
route = [[1, 1], [5, 1]]
speed_m_s = 1.0
shape = "legs"
at_end = "circle"
personal_space_m = 0.4
turn_back_after_s = 5
[[door]]
from = [3, 0]
to = [4, 0]
open_at_s = 10.0
[[mark]]
id = 7
at = [0, 4.5]
"#,
    )
    .unwrap();
    assert_eq!((scene.name.as_str(), scene.bounds), ("hall", Some([-1.0, -1.0, 9.0, 9.0])));
    assert_eq!((scene.walls[0].z_max_m, scene.walls[0].material), (2.5, Material::Opaque));
    assert_eq!((scene.walls[1].z_max_m, scene.walls[1].material), (1.2, Material::Glass));
    assert!(scene.walls[0].mapped && !scene.walls[1].mapped);
    let corner = scene.boxes[0].corners()[0];
    assert!((corner[0] - 2.4).abs() < 1e-12 && (corner[1] - 2.4).abs() < 1e-12, "{corner:?}");
    assert!(scene.persons[0].legs && scene.persons[0].circular);
    let care = (scene.persons[0].personal_space_m, scene.persons[0].turn_back_after_s);
    assert_eq!(care, (Some(0.4), Some(5.0)));
    assert_eq!(scene.marks, [WorldMark { id: 7, at: [0.0, 4.5] }]);
    assert!(scene.doors[0].is_closed(9.9) && !scene.doors[0].is_closed(10.0));
}

#[test]
fn a_door_follows_its_times() {
    let door = |open_at_s, close_at_s| Door {
        name: String::new(),
        from: [0.0; 2],
        to: [1.0, 0.0],
        height_m: 2.0,
        material: Material::Opaque,
        open_at_s,
        close_at_s,
    };
    let closed = |door: &Door| [0.0, 5.0, 15.0, 25.0].map(|time_s| door.is_closed(time_s));
    assert_eq!(closed(&door(None, None)), [true, true, true, true]);
    assert_eq!(closed(&door(Some(10.0), None)), [true, true, false, false]);
    assert_eq!(closed(&door(None, Some(10.0))), [false, false, true, true]);
    assert_eq!(closed(&door(Some(10.0), Some(20.0))), [true, true, false, true]);
    assert_eq!(closed(&door(Some(20.0), Some(10.0))), [false, false, true, false]);
}

#[test]
fn all_faults_come_at_once_with_line_and_key() {
    let text = r#"nam = "hall"
map = "absent.yaml"
bounds = [1, 0, 0, 1]
[[wall]]
from = [0, nan]
to = [1, 0]
heigth_m = 2
[[wall]]
from = [1, 1]
to = [1, 1]
material = "paper"
[[box]]
center = [0, 0, 0]
size = [1, -1]
z_min_m = 3.0
[[person]]
route = [[1, 1]]
speed_m_s = -1
[[person]]
speed_m_s = "fast"
[[person]]
route = [[1, 1]]
speed_m_s = 1
turn_back_after_s = 3
[[door]]
from = [0, 0]
to = [0, 1]
open_at_s = inf
[[mark]]
id = -3
at = [0, 0]
[robot]
"#;
    let Err(WorldFileError::Faults { faults, .. }) = parse(text) else { panic!("accepted") };
    let found: Vec<String> = faults.iter().map(ToString::to_string).collect();
    let expected = [
        "1:1 nam: unknown key, did you mean name?",
        "2:7 map: no file absent.yaml; expected a map_server YAML file beside the world file",
        "3:10 bounds: is [1, 0, 0, 1], expected [left, bottom, right, top] with left < right, bottom < top",
        "5:8 wall[0].from: found a list with a number that is not finite, expected a list of 2 finite numbers",
        "7:1 wall[0].heigth_m: unknown key, did you mean height_m?",
        "10:6 wall[1].to: is [1.0, 1.0] like from; a wall needs two different ends",
        "11:12 wall[1].material: is \"paper\", expected \"opaque\" or \"glass\"",
        "12:1 box[0].z_max_m: the upper edge is at 2 m, expected above z_min_m = 3",
        "13:10 box[0].center: found a list of 3, expected a list of 2 finite numbers",
        "14:8 box[0].size: is [1.0, -1.0], expected two lengths above 0",
        "18:13 person[0].speed_m_s: is -1, expected a finite number, 0 or more",
        "19:1 person[1].route: missing; expected a list of points [[x, y], ...]",
        "20:13 person[1].speed_m_s: found \"fast\", expected a number",
        "22:9 person[2].route: never leaves its first point; expected at least two different points, or speed_m_s = 0",
        "24:21 person[2].turn_back_after_s: is for who waits for the robot; expected personal_space_m as well",
        "28:13 door[0].open_at_s: is inf, expected a finite number, 0 or more",
        "30:6 mark[0].id: found -3, expected a whole number from 0 to 4294967295",
        "32:2 robot: unknown key, did you mean robot_map?",
    ];
    for (found, expected) in found.iter().zip(expected) {
        assert_eq!(found, expected);
    }
    assert_eq!(found.len(), expected.len(), "{found:#?}");
}

#[test]
fn syntax_and_empty_files_are_told() {
    let message = parse("[[wall]\nfrom = [0, 0]\n").unwrap_err().to_string();
    assert!(message.starts_with("hall.toml:1:"), "{message}");
    let message = parse("").unwrap_err().to_string();
    assert_eq!(
        message,
        "hall.toml:1:1 map: missing; expected a map, or at least one [[wall]] or [[box]], or bounds"
    );
    assert!(matches!(load_world(Path::new("absent.toml")), Err(WorldFileError::Unreadable { .. })));
}

#[test]
fn a_segment_visits_exactly_the_cells_it_passes() {
    let cells = |from, to, margin| {
        let mut cells = Vec::new();
        segment_cells(from, to, margin, |col, row| cells.push((col, row)));
        cells
    };
    assert_eq!(cells([0.5, 0.5], [2.5, 0.5], 0.0), [(0, 0), (1, 0), (2, 0)]);
    assert_eq!(cells([2.5, 0.5], [0.5, 1.5], 0.0), [(0, 1), (1, 0), (1, 1), (2, 0)]);
    assert_eq!(cells([0.5, 2.5], [0.5, 0.5], 0.0), [(0, 0), (0, 1), (0, 2)]);
    assert_eq!(cells([0.2, 1.0], [0.8, 1.0], 0.0), [(0, 1)]);
    assert_eq!(cells([0.2, 1.0], [0.8, 1.0], 1e-6), [(0, 0), (0, 1)]);
}

#[test]
fn a_mapped_world_is_drawn_and_what_is_unexpected_is_not() {
    let scene = parse(
        r#"
bounds = [0, 0, 2, 1]
[[wall]]
from = [0, 0]
to = [2, 0]
[[box]]
center = [1.0, 0.6]
size = [0.4, 0.4]
[[box]]
center = [1.7, 0.6]
size = [0.2, 0.2]
mapped = false
"#,
    )
    .unwrap();
    let map = raster_map(&scene, 0.1, 10_000).unwrap();
    assert_eq!((map.width, map.height, map.origin), (23, 13, [-0.1, -0.1, 0.0]));
    let drawn: Vec<String> = map
        .cells
        .chunks(map.width)
        .rev()
        .map(|row| row.iter().map(|&cell| if cell > 50 { '#' } else { '.' }).collect())
        .collect();
    assert_eq!(drawn[11], ".".to_string() + &"#".repeat(21) + ".", "{drawn:#?}");
    assert_eq!(drawn[5], ".........#####.........", "{drawn:#?}");
    assert!(map.occupancy(18, 7) == 0, "the unexpected box is drawn: {drawn:#?}");
    assert!(raster_map(&scene, 0.001, 10_000).is_none());
}
