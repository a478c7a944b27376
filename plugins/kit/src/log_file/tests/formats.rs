use super::*;
use rumbo_core::frames::{Twist, pose2};
use rumbo_core::time::Time;

#[test]
fn old_laser_messages_give_scan_poses_and_stamp() {
    let text = format!("# a comment\n{}R{}", flaser(4, "976052857.337530"), &flaser(2, "7.5")[1..]);
    let (records, faults, tally) = read(text.as_bytes());
    assert_eq!((faults.len(), tally.n_unknown(), records[0].line), (0, 0, 2));
    let found = scans(&records);
    assert_eq!((found[0].side, found[1].side), (LaserSide::Front, LaserSide::Rear));
    assert_eq!(found[0].stamp, Time::from_secs(976_052_857.337_530));
    assert_eq!(found[0].ranges_m.as_slice(), [1.0, 1.01, 1.02, 1.03]);
    assert_eq!(found[0].map_from_base, pose2(1.0, 2.0, 0.5));
    assert_eq!(found[0].odom_from_base, pose2(3.0, 4.0, -0.5));
    assert_eq!((found[1].stamp, found[1].twist), (Time::from_secs(7.5), None));
}

#[test]
fn beams_are_one_or_half_a_degree_apart_and_never_the_field_divided_by_its_gaps() {
    for (n, step_deg) in [(180, 1.0), (181, 1.0), (360, 0.5), (361, 0.5), (90, 2.0)] {
        let (records, _, tally) = read(flaser(n, "1.0").as_bytes());
        let scan = scans(&records)[0];
        assert!((scan.first_bearing_rad.to_degrees() + 90.0).abs() < 1e-9, "{n}");
        assert!((scan.bearing_step_rad.to_degrees() - step_deg).abs() < 1e-9, "{n}");
        assert_eq!(tally.guessed.is_some(), n == 90, "{n}");
    }
}

#[test]
fn what_the_user_knows_of_the_beams_wins() {
    let file = TempFile::new(flaser(90, "1.0").as_bytes());
    let known = BeamOverride {
        first_bearing_rad: Some(f64::to_radians(-135.0)),
        bearing_step_rad: Some(f64::to_radians(270.0 / 89.0)),
        max_range_m: Some(1.5),
    };
    let mut reader = LogReader::open(&file.0, known).unwrap();
    let Told::Scan(scan) = reader.next().unwrap().unwrap().told else { panic!("a scan") };
    let last_deg = (scan.first_bearing_rad + 89.0 * scan.bearing_step_rad).to_degrees();
    assert!((last_deg - 135.0).abs() < 1e-9);
    assert_eq!((scan.ranges_m[49], scan.ranges_m[50]), (1.49, f32::INFINITY));
    assert_eq!(reader.tally().guessed, None);
}

#[test]
fn no_echo_is_infinite_and_not_a_number_is_no_reading() {
    let text = "FLASER 5 81.83 79.99 80.00 nan inf 0 0 0 0 0 0 1 h 1\n";
    let (records, faults, _) = read(text.as_bytes());
    assert!(faults.is_empty());
    let ranges = &scans(&records)[0].ranges_m;
    assert_eq!((ranges[0], ranges[1], ranges[2]), (f32::INFINITY, 79.99, f32::INFINITY));
    assert!(ranges[3].is_nan() && ranges[4] == f32::INFINITY);
    let all_nan = "FLASER 3 nan NaN nan 0 0 0 0 0 0 1 h 1\n";
    let (records, faults, _) = read(all_nan.as_bytes());
    assert!(faults.is_empty() && scans(&records)[0].ranges_m.iter().all(|range| range.is_nan()));
}

#[test]
fn robot_lasers_say_their_own_geometry_and_velocity() {
    let text = "ROBOTLASER1 0 -1.5 3.0 0.01 50.0 0.1 0 3 1 60 2 2 7 8 1 2 0.1 3 4 0.2 0.3 -0.4 0 0 0 99.5 x 700\n\
                ROBOTLASER1 0 -1.5 3.0 0.01 50.0 0.1 0 2 1 2 2 7 8 1 2 0.1 3 4 0.2 0.3 -0.4 0 0 0 99.6 x 700\n";
    let (records, faults, _) = read(text.as_bytes());
    assert_eq!(faults, []);
    let found = scans(&records);
    assert_eq!((found[0].first_bearing_rad, found[0].bearing_step_rad), (-1.5, 0.01));
    assert_eq!(found[0].ranges_m.as_slice(), [1.0, f32::INFINITY, 2.0]);
    assert_eq!(found[0].odom_from_base, pose2(3.0, 4.0, 0.2));
    assert_eq!(found[0].twist, Some(Twist::new(0.3, -0.4)));
    assert_eq!(found[0].stamp, Time::from_secs(99.5));
    assert!(found[0].intensities.is_empty(), "two remissions for three beams");
    assert_eq!(found[1].intensities.as_slice(), [7.0, 8.0]);
}

#[test]
fn the_pose_of_a_vertex_belongs_to_the_next_scan_only() {
    let laser = |t| format!("ROBOTLASER1 0 -1.5 3 0.01 50 0.1 0 1 1 0 0 0 0 5 6 0.7 0 0 0 0 0 {t} x 0\n");
    let edge = "EDGE2 0 1 1.5 0.5 0.1 1 0 1 2 0 0\n";
    let text = format!("VERTEX2 12 4.78 -5.84 -1.69\n{}{}{edge}#LOOP\n", laser(1), laser(2));
    let (records, faults, _) = read(text.as_bytes());
    assert_eq!(faults, []);
    assert_eq!(records[0].told, Told::Vertex { id: 12, map_from_base: pose2(4.78, -5.84, -1.69) });
    let found = scans(&records);
    assert_eq!(found[0].map_from_base, pose2(4.78, -5.84, -1.69));
    assert_eq!(found[1].map_from_base, pose2(5.0, 6.0, 0.7));
    let Told::Edge(edge) = &records[3].told else { panic!("an edge") };
    assert_eq!((edge.from, edge.to, edge.information), (0, 1, [1.0, 0.0, 1.0, 2.0, 0.0, 0.0]));
}

#[test]
fn odometry_parameters_marks_and_unknown_messages_are_told_apart() {
    let text =
        "PARAM robot_laser on nohost 0\nSYNC a b c\nODOM 1 2 3 0.5 -0.25 0 10.5 nohost 0\nNEFF 30\nNEFF 29\n";
    let (records, faults, tally) = read(text.as_bytes());
    assert_eq!(faults, []);
    assert_eq!(records[0].told, Told::Parameter { name: "robot_laser".into(), value: "on".into() });
    assert_eq!(records[1].told, Told::Sync);
    let Told::Odometry(odometry) = records[2].told else { panic!("odometry") };
    assert_eq!((odometry.stamp, odometry.odom_from_base), (Time::from_secs(10.5), pose2(1.0, 2.0, 3.0)));
    assert_eq!(odometry.twist, Some(Twist::new(0.5, -0.25)));
    assert_eq!(tally.unknown.get("`NEFF`"), Some(&Count { n: 2, first: 4 }));
    assert!(tally.sentences()[0].contains("`NEFF` (2, from line 4)"));
}

#[test]
fn wean_hall_logs_are_in_centimeters() {
    let ranges = vec!["250"; 179].join(" ");
    let text = format!("O -94.2 -139.9 -1.3 0.025\nL 100 200 0.5 122 212 0.5 {ranges} 8191 0.0799\n");
    let (records, faults, _) = read(text.as_bytes());
    assert_eq!(faults, []);
    let Told::Odometry(odometry) = records[0].told else { panic!("odometry") };
    assert_eq!((odometry.odom_from_base, odometry.twist), (pose2(-94.2 * 0.01, -139.9 * 0.01, -1.3), None));
    let scan = scans(&records)[0];
    assert_eq!((scan.ranges_m.len(), scan.ranges_m[0], scan.ranges_m[179]), (180, 2.5, f32::INFINITY));
    assert_eq!((scan.stamp, scan.odom_from_base), (Time::from_secs(0.0799), pose2(1.0, 2.0, 0.5)));
}

#[test]
fn gzip_several_streams_and_windows_line_ends_make_no_difference() {
    let text = format!("{}{}{}", odom(0.0, 1.0), flaser(181, "1.5"), odom(1.0, 2.0));
    let plain = read(text.as_bytes());
    assert_eq!(read(&gzip(text.as_bytes())), plain);
    let (start, end) = text.as_bytes().split_at(100);
    assert_eq!(read(&[gzip(start), gzip(end)].concat()), plain);
    assert_eq!(read(text.replace('\n', "\r\n").as_bytes()), plain);
    assert_eq!(read(text.trim_end().as_bytes()), plain, "no line end in the last line");
}
