//! The plugin as the framework uses it; the filter has its own tests.

use super::EkfLinesParams;
use nalgebra::Matrix3;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::Pose2;
use rumbo_core::map::{Line, Lines, Map};
use rumbo_core::messages::{Prior, Seen};
use rumbo_core::registry::{Params, Plugin, Registry, Stage};
use rumbo_core::stages::{BuildContext, Cx, LocalizeError, Localizer};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

fn built() -> Box<dyn Localizer> {
    EkfLinesParams::default().build(&BuildContext::bare("localizer")).unwrap()
}

fn at(map_from_base: Pose2) -> Prior {
    Prior::Pose { map_from_base, odom_from_base: Pose2::identity(), covariance: Matrix3::identity() * 1e-6 }
}

fn map_of(lines: Vec<Line>) -> Map {
    Map { lines: Some(Lines { lines: Buffer::from(lines) }), ..Map::default() }
}

fn wall() -> Line {
    Line { from: [5.0, 2.0], to: [5.0, -2.0], covariance: [1e-6, 0.0, 1e-6] }
}

#[test]
fn it_starts_on_a_map_with_walls_and_from_a_pose() {
    let mut localizer = built();
    let trace = Trace::counting();
    let mut cx = Cx { now: Time::ZERO, trace: &trace };
    assert_eq!(localizer.update(&mut cx, Seen::NOTHING, &Map::default()), Err(LocalizeError::NotStarted));
    let start = at(Pose2::identity());
    assert_eq!(localizer.start(&start, &Map::default()), Err(LocalizeError::MissingLayer { layer: "lines" }));
    let empty = localizer.start(&start, &map_of(vec![])).unwrap_err();
    assert!(empty.to_string().contains("no wall"), "{empty}");
    let many = localizer.start(&start, &map_of(vec![wall(); 2001])).unwrap_err();
    assert!(many.to_string().contains("2001 walls, expected at most 2000"), "{many}");
    let map = map_of(vec![wall()]);
    for prior in [Prior::Unknown, Prior::Saved(Buffer::from(vec![1, 2, 3]))] {
        assert!(matches!(localizer.start(&prior, &map), Err(LocalizeError::Prior { .. })));
    }
    localizer.start(&start, &map).unwrap();
    let estimate = localizer.update(&mut cx, Seen::NOTHING, &map).unwrap();
    assert!((estimate.pose2().inverse() * Pose2::identity()).translation.vector.norm() < 1e-12);
}

#[test]
fn all_faults_of_the_keys_are_told() {
    assert!(EkfLinesParams::default().check().is_empty());
    let mut params = EkfLinesParams { lost_after_scans: 0, late_s: -1.0, ..EkfLinesParams::default() };
    params.extraction.grazing_deg = 90.0;
    let paths: Vec<String> = params.check().into_iter().map(|fault| fault.path).collect();
    assert_eq!(paths, ["late_s", "extraction.grazing_deg", "lost_after_scans"]);
    assert!(Registry::linked().unwrap().get(Stage::Localizer, "ekf_lines").is_some());
}
