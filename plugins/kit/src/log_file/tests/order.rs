use super::*;
use rumbo_core::time::Time;

fn play(text: &str) -> (Vec<f64>, Timeline) {
    let file = TempFile::new(text.as_bytes());
    let mut timeline = Timeline::open(&file.0, BeamOverride::default()).unwrap();
    let stamps = timeline.by_ref().map(|moment| moment.stamp.as_secs()).collect();
    (stamps, timeline)
}

fn odoms(stamps: &[f64]) -> String {
    stamps.iter().map(|stamp| odom(0.0, *stamp)).collect()
}

#[test]
fn records_a_little_out_of_order_are_sorted_and_their_steps_counted() {
    let text = format!("{}{}{}{}", odom(0.0, 1.0), odom(0.0, 1.2), flaser(3, "1.1"), odom(0.0, 1.15))
        + &odom(0.0, 9.0);
    let (stamps, timeline) = play(&text);
    assert_eq!(stamps, [1.0, 1.1, 1.15, 1.2, 9.0]);
    assert_eq!(timeline.origin(), Time::from_secs(1.0));
    let order = timeline.order();
    assert_eq!((order.front_laser.n, order.odometry.n, order.odometry.first_line), (0, 1, 4));
    assert_eq!(
        order.sentences(),
        ["odometry: stamps step backward 1 times, first in line 4, at most 0.050 s"]
    );
}

#[test]
fn the_first_stamp_is_the_smallest_of_the_first_records() {
    let (stamps, timeline) = play(&odoms(&[5.5, 5.0, 5.2, 6.0]));
    assert_eq!((stamps, timeline.origin()), (vec![5.0, 5.2, 5.5, 6.0], Time::from_secs(5.0)));
}

#[test]
fn a_wrong_stamp_costs_only_itself_wherever_it_stands_and_wherever_it_points() {
    let good: Vec<f64> = (0..20).map(|k| 1e6 + f64::from(k)).collect();
    for wrong in [0.0, 1e6 - 100.0, 1e6 + 500.0, 5e8, 8e9] {
        for at in 0..=20 {
            let mut stamps = good.clone();
            stamps.insert(at, wrong);
            let (found, timeline) = play(&odoms(&stamps));
            // 500 s behind the end may as well be the end of a long pause.
            let is_possible = (at == 20 && wrong == 1e6 + 500.0) || (at == 0 && wrong == 1e6 - 100.0);
            let n_expected = 20 + usize::from(is_possible);
            assert_eq!(found.len(), n_expected, "{wrong} at {at}: {found:?}");
            assert!(good.iter().all(|stamp| found.contains(stamp)), "{wrong} at {at}");
            assert_eq!(timeline.order().stray.is_some(), !is_possible);
        }
    }
}

#[test]
fn gaps_are_no_faults() {
    for step in [2.5, 60.0, 3000.0] {
        let stamps: Vec<f64> = (0..10).map(|k| 50.0 + step * f64::from(k)).collect();
        assert_eq!(play(&odoms(&stamps)).0, stamps, "{step}");
    }
    assert_eq!(play(&odoms(&[1.0, 1.1, 9000.0, 9000.1])).0, [1.0, 1.1, 9000.0, 9000.1]);
    assert_eq!(
        play(&odoms(&[10.0, 10.1, 60.0, 0.5, 60.1])).0,
        [10.0, 10.1, 60.0, 60.1],
        "a wrong stamp behind a gap"
    );
    // Keyframes seconds apart whose clock jitters by nearly a second, as in the graph of the Intel log.
    assert_eq!(play(&odoms(&[1.0, 3.9, 3.1, 5.0])).0, [1.0, 3.1, 3.9, 5.0]);
}

#[test]
fn a_clock_that_was_set_ends_the_log() {
    let (stamps, timeline) = play(&odoms(&[1.0, 1.1, 1.2, 1e9, 1e9 + 0.1, 1e9 + 0.2]));
    assert_eq!(stamps, [1.0, 1.1, 1.2]);
    assert_eq!(timeline.order().stray, Some(Count { n: 3, first: 4 }));
}

#[test]
fn equal_stamps_are_dropped_within_a_channel_only() {
    let text = [odom(0.0, 1.0), flaser(3, "1.0"), odom(0.0, 1.0), flaser(3, "1.0"), odom(0.0, 1.1)].concat();
    let (stamps, timeline) = play(&text);
    assert_eq!(stamps, [1.0, 1.0, 1.1]);
    assert_eq!(timeline.order().equal, Some(Count { n: 2, first: 3 }));
}

#[test]
fn a_log_whose_clock_stands_still_costs_no_memory_without_bound() {
    let text = "ODOM 0 0 0 0 0 0 1.01893e+09 pippo 0\n".repeat(20_000);
    let (stamps, timeline) = play(&text);
    assert_eq!((stamps.len(), timeline.order().equal.as_ref().map(|count| count.n)), (1, Some(19_999)));
}
