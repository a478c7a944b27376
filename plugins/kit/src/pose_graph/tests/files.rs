//! Graphs in files of g2o.

use super::*;
use std::path::PathBuf;

fn written(name: &str, text: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("rumbo-g2o-{}-{name}.g2o", std::process::id()));
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn poses_constraints_and_what_is_held_are_read() {
    let text = "# a corner\nVERTEX_SE2 7 1 2 0.5\n\nVERTEX_SE2 3 0 0 0\nVERTEX_SE2 12 4 4 -1\nFIX 7\n\
        EDGE_SE2 7 12 1.5 -0.5 0.25 10 1 2 20 3 30\n  EDGE_SE2 3 7 1 0 0 1 0 0 1 0 1";
    let path = written("corner", text);
    let file = read_g2o(&path).unwrap();
    assert_eq!((&file.ids[..], file.has_poses), (&[3, 7, 12][..], true));
    assert_eq!(file.graph.poses()[1], Vector3::new(1.0, 2.0, 0.5));
    assert_eq!(file.graph.fixed(), [false, true, false]);
    let link = file.graph.constraints()[0];
    assert_eq!((link.from, link.to), (Some(1), 2));
    assert_eq!(link.from_to, pose2(1.5, -0.5, 0.25));
    assert_eq!(link.information, Matrix3::new(10.0, 1.0, 2.0, 1.0, 20.0, 3.0, 2.0, 3.0, 30.0));
    std::fs::write(&path, "EDGE_SE2 0 1 1 0 0.5 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0.5 1 0 0 1 0 1\n").unwrap();
    let edges = read_g2o(&path).unwrap();
    assert!(!edges.has_poses && edges.graph.cost() < 1e-20);
    assert_eq!(edges.graph.pose(2), Some(pose2(1.0, 0.0, 0.5) * pose2(1.0, 0.0, 0.5)));
    std::fs::remove_file(path).unwrap();
}

#[test]
fn a_line_that_makes_no_graph_is_named_with_what_is_expected() {
    let link = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";
    let cases = [
        ("EDGE_SE2 0 1 1 0 0 1 0 0 1 0\n", "1: EDGE_SE2.I33 is missing"),
        ("\nEDGE_SE2 0 x 1 0 0 1 0 0 1 0 1\n", "2: EDGE_SE2.to is `x`, expected a whole number"),
        ("EDGE_SE2 0 1 1 0 0 1 0 0 nan 0 1\n", "EDGE_SE2.I22 is NaN"),
        ("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1 8\n", "EDGE_SE2.end is followed by 1 more words"),
        ("EDGE_SE2 0 1 1 0 0 1 0 0 -1 0 1\n", "not positive semidefinite"),
        ("EDGE_SE2 4 4 1 0 0 1 0 0 1 0 1\n", "constrained by itself"),
        (&format!("{link}VERTEX_SE2 0 0 0 0\n"), "1: EDGE_SE2.to is pose 1, which no VERTEX_SE2 describes"),
        ("VERTEX_SE2 5 0 0 0\nVERTEX_SE2 5 1 0 0\n", "2: VERTEX_SE2.id is 5, which an earlier line has"),
        ("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n", "`VERTEX_SE3:QUAT`, expected VERTEX_SE2, EDGE_SE2 or FIX"),
        ("VERTEX_SE2 5 0 0 0\n", "no EDGE_SE2 in 1 lines"),
        (&format!("{link}FIX 9\n"), "2: FIX.id is pose 9"),
        ("", "the file is empty"),
    ];
    for (k, (text, words)) in cases.iter().enumerate() {
        let path = written(&format!("fault-{k}"), text);
        let error = read_g2o(&path).unwrap_err().to_string();
        assert!(error.contains(words) && error.contains("rumbo-g2o"), "{words}: {error}");
        std::fs::remove_file(path).unwrap();
    }
    assert!(
        read_g2o("no/such.g2o".as_ref()).unwrap_err().to_string().contains("give the path of a g2o file")
    );
}
