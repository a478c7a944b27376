//! Layers of landmarks from each kind of file.

use std::path::PathBuf;

use rumbo_core::registry::{Registry, Stage};

use super::*;

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rumbo-known-marks-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let marks = "[[mark]]\nidentity = 4\nx_m = 1.0\ny_m = 2.0\ndeviation_m = 0.02\n\
                 [[mark]]\nidentity = 2\nx_m = -1.0\ny_m = 0.5\n";
    std::fs::write(folder.join("marks.toml"), marks).unwrap();
    let world = "bounds = [0, 0, 5, 5]\n[[mark]]\nid = 8\nat = [3.0, 4.0]\n";
    std::fs::write(folder.join("world.toml"), world).unwrap();
    std::fs::write(folder.join("bare.toml"), "bounds = [0, 0, 5, 5]\n").unwrap();
    std::fs::write(folder.join("twice.toml"), format!("{world}[[mark]]\nid = 8\nat = [1.0, 1.0]\n")).unwrap();
    let table = "# a comment\n 6 \t 0.5 \t -4.25 \t 0.03 \t 0.0001\n 7 0.75 -4.5 0.0 0.0\n";
    std::fs::write(folder.join("Landmark_Groundtruth.dat"), table).unwrap();
    folder
}

fn layer(params: &KnownMarksParams, context: &BuildContext) -> Vec<(u32, [f64; 2], [f64; 3])> {
    let mut map = Map::default();
    params.build(context).unwrap().start(&mut map).unwrap();
    assert_eq!((map.version, &map.grid), (1, &None));
    let landmarks = map.landmarks.unwrap().landmarks;
    landmarks.iter().map(|mark| (mark.identity, mark.position, mark.covariance)).collect()
}

fn of_file(file: &str, least_deviation_m: f64) -> KnownMarksParams {
    KnownMarksParams { file: Some(file.into()), least_deviation_m }
}

#[test]
fn a_list_of_marks_is_a_layer_with_their_deviations() {
    let context = BuildContext { folder: folder("list"), ..BuildContext::bare("map") };
    let marks = layer(&of_file("marks.toml", 0.01), &context);
    assert_eq!(marks, [(4, [1.0, 2.0], [4e-4, 0.0, 4e-4]), (2, [-1.0, 0.5], [1e-4, 0.0, 1e-4])]);
}

#[test]
fn the_landmarks_of_an_mrclam_folder_are_called_by_their_subject() {
    let folder = folder("mrclam");
    let context = BuildContext { folder: folder.clone(), ..BuildContext::bare("map") };
    let table = layer(&of_file("Landmark_Groundtruth.dat", 0.01), &context);
    assert_eq!(table.len(), 2);
    let (subject, position, [xx, xy, yy]) = table[0];
    assert_eq!((subject, position, xy), (6, [0.5, -4.25], 0.0));
    assert!((xx.sqrt() - 0.03).abs() < 1e-12 && (yy.sqrt() - 0.01).abs() < 1e-12);
    assert_eq!(layer(&of_file(".", 0.01), &context), table);
}

#[test]
fn without_a_file_they_are_those_of_the_worlds_map() {
    let context =
        BuildContext { world_map: Some(folder("world").join("world.toml")), ..BuildContext::bare("map") };
    assert_eq!(layer(&KnownMarksParams::default(), &context), [(8, [3.0, 4.0], [0.0; 3])]);
}

#[test]
fn faults_are_told_with_their_key_and_place() {
    let folder = folder("faults");
    let context = BuildContext { folder: folder.clone(), ..BuildContext::bare("map") };
    let build = |params: &KnownMarksParams, context: &BuildContext| params.build(context).err().unwrap();
    assert!(build(&KnownMarksParams::default(), &context).message.contains("no map of its own"));
    let absent = build(&of_file("absent.toml", 0.0), &context);
    assert!(absent.path == "file" && absent.message.contains("absent.toml") && absent.help.is_some());
    for (world, told) in [("bare.toml", "no [[mark]]"), ("twice.toml", "mark 8 is there twice")] {
        let context = BuildContext { world_map: Some(folder.join(world)), ..context.clone() };
        let fault = build(&KnownMarksParams::default(), &context);
        assert!(fault.message.contains(told), "{}", fault.message);
    }
    let bad = "1 0.0 0.0 0.1 0.1\n2 zero 0.0 0.1 0.1\n";
    std::fs::write(folder.join("Landmark_Groundtruth.dat"), bad).unwrap();
    let fault = build(&of_file(".", 0.0), &context);
    assert!(fault.message.contains("line 2: landmark.x is `zero`, expected a number"), "{}", fault.message);
    assert_eq!(build(&of_file("marks.toml", f64::NAN), &context).path, "least_deviation_m");
    let registry = Registry::linked().unwrap();
    assert!(registry.get(Stage::MapBuilder, "known_marks").is_some());
}
