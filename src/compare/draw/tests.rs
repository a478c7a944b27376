use super::*;
use crate::compare::ground::Passing;
use rumbo_kit::world_file::parse_world;
use std::path::Path;

/// Two rooms of 4 m by 6 m, joined by two doors of 1.2 m, with furniture.
const ROOMS: &str = "
bounds = [0.0, 0.0, 8.0, 6.0]
box = [
    { name = 'wall left', center = [0.0, 3.0], size = [0.1, 6.0] },
    { name = 'wall right', center = [8.0, 3.0], size = [0.1, 6.0] },
    { name = 'wall top', center = [4.0, 6.0], size = [8.0, 0.1] },
    { name = 'wall bottom', center = [4.0, 0.0], size = [8.0, 0.1] },
    { name = 'wall middle', center = [4.0, 3.0], size = [0.1, 2.4] },
    { name = 'wall low', center = [4.0, 0.3], size = [0.1, 0.6] },
    { name = 'wall high', center = [4.0, 5.7], size = [0.1, 0.6] },
    { name = 'desk', center = [1.5, 3.0], size = [0.8, 0.5] },
    { name = 'shelf', center = [6.5, 3.0], size = [0.8, 0.5] },
]";

fn space() -> FreeSpace {
    FreeSpace::of(&parse_world(ROOMS, Path::new("rooms.toml")).unwrap(), 0.2).unwrap()
}

/// The same with one of the doors walled up.
fn one_door() -> FreeSpace {
    let walled =
        ROOMS.replace("center = [4.0, 0.3], size = [0.1, 0.6]", "center = [4.0, 0.9], size = [0.1, 1.8]");
    assert_ne!(walled, ROOMS);
    FreeSpace::of(&parse_world(&walled, Path::new("rooms.toml")).unwrap(), 0.2).unwrap()
}

/// What a draw says, as a table.
fn drawn(rules: &str, seed: u64) -> Table {
    drawn_in(&space(), rules, seed)
}

fn drawn_in(space: &FreeSpace, rules: &str, seed: u64) -> Table {
    let rules: Rules = toml::from_str(rules).unwrap();
    assert_eq!(rules.faults(), []);
    let sets = draw(space, &rules, seed, 0).unwrap();
    assert_eq!(Ok(&sets), draw(space, &rules, seed, 0).as_ref());
    let text: Vec<String> = sets.iter().map(|set| set.replacen('=', " = ", 1)).collect();
    text.join("\n").parse().unwrap()
}

fn at<'t>(table: &'t Table, path: &str) -> Option<&'t Value> {
    let mut keys = path.split('/');
    let first = table.get(keys.next()?)?;
    keys.try_fold(first, |value, key| match key.parse::<usize>() {
        Ok(idx) => value.as_array()?.get(idx),
        Err(_) => value.get(key),
    })
}

fn number(table: &Table, path: &str) -> f64 {
    at(table, path).and_then(Value::as_float).unwrap_or_else(|| panic!("{path} in {table}"))
}

fn ends(table: &Table) -> [[f64; 2]; 2] {
    [
        [number(table, "world/start/x_m"), number(table, "world/start/y_m")],
        [number(table, "mission/waypoints/0/x_m"), number(table, "mission/waypoints/0/y_m")],
    ]
}

#[test]
fn ways_have_the_length_that_is_asked_for_around_what_stands_there() {
    let ground = space().with(&[]);
    for seed in 1..20 {
        let [start, goal] = ends(&drawn("way_m = [4.0, 5.0]", seed));
        let ways = ground.ways_from(start).unwrap();
        let way = ground.way(&ways, goal);
        let length_m: f64 = way.windows(2).map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1])).sum();
        assert!((4.0..=5.0).contains(&length_m), "{length_m}");
        let refined = ground.refined(&way);
        assert!(refined.iter().all(|place| ground.is_open(*place)));
        let ends = refined.first().zip(refined.last()).unwrap();
        assert!((ends.0[0] - way[0][0]).abs() < 1e-9 && (ends.1[1] - way[way.len() - 1][1]).abs() < 1e-9);
        assert!((goal[0] - start[0]).hypot(goal[1] - start[1]) <= length_m + 1e-9);
    }
}

#[test]
fn what_is_in_the_way_closes_it_and_leaves_or_closes_the_other() {
    for (kind, another_way) in
        [("box", true), ("chair", true), ("glass", true), ("door", true), ("door", false), ("person", true)]
    {
        for seed in 1..5 {
            let rules = format!(
                "in_the_way = {{ kind = '{kind}', another_way = {another_way} }}\nway_m = [4.0, 9.0]"
            );
            let space = if another_way { space() } else { one_door() };
            let table = drawn_in(&space, &rules, seed);
            let [start, goal] = ends(&table);
            if kind == "person" {
                assert!(at(&table, "world/add/person/0/route").is_some());
                continue;
            }
            let things: rumbo_kit::world_file::Things = at(&table, "world/add")
                .unwrap_or_else(|| panic!("{kind}: {table}"))
                .clone()
                .try_into()
                .unwrap();
            let boxes = things.read().unwrap().boxes;
            assert_eq!(boxes.len(), if kind == "chair" { 5 } else { 1 });
            assert_eq!(space.with(&boxes).are_joined(start, goal), another_way, "{kind} {seed}");
            assert!(another_way || !space.ground_for(Passing::Narrowly, &boxes).are_joined(start, goal));
            let ground = space.with(&[]);
            let way = ground.refined(&ground.way(&ground.ways_from(start).unwrap(), goal));
            let blocked = space.with(&boxes);
            assert!(way.iter().any(|place| !blocked.is_open(*place)), "{kind} {seed} is in the way");
        }
    }
}

#[test]
fn furniture_moves_by_name_and_boxes_stand_around_the_robot() {
    let table = drawn("moved_furniture = 0.5", 3);
    let without = at(&table, "world/without/0").and_then(Value::as_str).unwrap();
    assert!(["desk", "shelf"].contains(&without));
    assert_eq!(
        at(&table, "world/add/box/0/name").and_then(Value::as_str).unwrap(),
        format!("{without}, moved")
    );
    let clutter = "without_goal = true\nclutter = { every = 2 }";
    let table = drawn(clutter, 1);
    assert!(at(&table, "mission").is_none());
    let start = [number(&table, "world/start/x_m"), number(&table, "world/start/y_m")];
    for idx in 0..3 {
        let center = [0, 1].map(|axis| number(&table, &format!("world/add/box/{idx}/center/{axis}")));
        let nearest_m = (center[0] - start[0]).hypot(center[1] - start[1]) - 0.15 * 2f64.sqrt();
        assert!((0.6..=2.0).contains(&nearest_m), "{nearest_m}");
    }
    assert!(at(&drawn(clutter, 2), "world/add").is_none(), "only in every other run");
}

#[test]
fn people_walk_on_free_floor_and_not_where_the_robot_stands() {
    let ground = space().with(&[]);
    for seed in 1..10 {
        let table = drawn("people = { n = [2, 2] }", seed);
        let [start, _] = ends(&table);
        for person in 0..2 {
            let corner = |idx| {
                [0, 1].map(|axis| number(&table, &format!("world/add/person/{person}/route/{idx}/{axis}")))
            };
            let [from, to] = [corner(0), corner(1)];
            for share in 0..=10 {
                let place = [0, 1].map(|k| from[k] + (to[k] - from[k]) * f64::from(share) / 10.0);
                assert!(ground.is_open(place), "{place:?}");
                assert!((place[0] - start[0]).hypot(place[1] - start[1]) > 0.9);
            }
        }
    }
}

#[test]
fn careful_people_walk_where_the_others_do() {
    let blind = drawn("people = { n = [2, 2] }", 3);
    let careful = drawn("people = { n = [2, 2], personal_space_m = 0.4, turn_back_after_s = 5.0 }", 3);
    for person in 0..2 {
        let of = |key: &str| format!("world/add/person/{person}/{key}");
        assert_eq!(at(&blind, &of("personal_space_m")), None);
        assert_eq!(number(&careful, &of("personal_space_m")), 0.4);
        assert_eq!(number(&careful, &of("turn_back_after_s")), 5.0);
        assert_eq!(at(&blind, &of("route")), at(&careful, &of("route")));
        assert_eq!(at(&blind, &of("speed_m_s")), at(&careful, &of("speed_m_s")));
    }
}

#[test]
fn what_finds_no_room_is_said() {
    let rules: Rules = toml::from_str("way_m = [100.0, 110.0]").unwrap();
    assert!(draw(&space(), &rules, 1, 0).unwrap_err().contains("no room"));
}

#[test]
fn faults_of_rules_are_named() {
    for (text, words) in [
        ("way_m = [5.0, 4.0]", "way_m"),
        ("moved_furniture = 2.0", "moved_furniture"),
        ("clutter = { every = 0 }", "clutter"),
        ("without_goal = true\nway_m = [1.0, 2.0]", "without_goal"),
        ("people = { speed_m_s = [-1.0, 2.0] }", "people.speed_m_s"),
        ("people = { personal_space_m = -1.0 }", "people.personal_space_m"),
        ("people = { turn_back_after_s = 1.0 }", "people.turn_back_after_s"),
    ] {
        let faults = toml::from_str::<Rules>(text).unwrap().faults();
        assert!(faults.len() == 1 && faults[0].0 == words, "{text}: {faults:?}");
    }
}
