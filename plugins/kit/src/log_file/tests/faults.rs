use super::*;

/// The message of the only fault of a line that stands between two good ones.
fn fault(line: &str) -> String {
    let text = format!("{}{line}\n{}", odom(0.0, 1.0), odom(0.0, 2.0));
    let (records, faults, tally) = read(text.as_bytes());
    assert_eq!((records.len(), faults.len(), tally.n_faults()), (2, 1, 1), "{line:.60}: {faults:?}");
    faults[0].to_string()
}

#[test]
fn every_fault_of_a_line_names_the_line_the_field_what_was_found_and_what_was_expected() {
    let cases = [
        ("ODOM 1 2", "line 2: ODOM.theta is missing at the end of the line, expected a value"),
        ("ODOM 1 2 x 0 0 0 5 h 0", "line 2: ODOM.theta is `x`, expected a number"),
        ("ODOM nan 2 3 0 0 0 5 h 0", "line 2: ODOM.x is NaN, expected a finite number of at most 1e9"),
        ("ODOM 1 -inf 3 0 0 0 5 h 0", "line 2: ODOM.y is -inf, expected a finite number of at most 1e9"),
        (
            "ODOM 1 2 3 0 1e99 0 5 h 0",
            "line 2: ODOM.rv is 1000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000, expected a finite number of at most 1e9",
        ),
        (
            "ODOM 1 2 3 0 0 0 1e18 h 0",
            "line 2: ODOM.ipc_time is 1000000000000000000, expected seconds between -9e9 and 9e9",
        ),
        (
            "FLASER 2 1 -0.5 0 0 0 0 0 0 5 h 0",
            "line 2: FLASER.ranges[1] is -0.5, expected a number of at least 0",
        ),
        ("FLASER 2 1 1,5 0 0 0 0 0 0 5 h 0", "line 2: FLASER.ranges[1] is `1,5`, expected a number"),
        (
            "FLASER 2 1 2 0 0 nan 0 0 0 5 h 0",
            "line 2: FLASER.theta is NaN, expected a finite number of at most 1e9",
        ),
        (
            "FLASER 3 1 2 0 0 0 0 0 0 5 h 0",
            "line 2: FLASER.num_readings is followed by 11 words, expected 12 words of readings, poses and stamps",
        ),
        (
            "FLASER 1 1 2 0 0 0 0 0 0 5 h 0",
            "line 2: FLASER.num_readings is followed by 11 words, expected 10 words of readings, poses and stamps",
        ),
        (
            "FLASER 90000 1 2",
            "line 2: FLASER.num_readings is followed by 2 words, expected 90009 words of readings, poses and stamps",
        ),
        (
            "FLASER 1000000 1 2",
            "line 2: FLASER.num_readings is 1000000, expected a whole number from 1 to 100000",
        ),
        (
            "FLASER 0 0 0 0 0 0 0 5 h 0",
            "line 2: FLASER.num_readings is 0, expected a whole number from 1 to 100000",
        ),
        ("FLASER -3 1", "line 2: FLASER.num_readings is -3, expected a whole number from 1 to 100000"),
        ("FLASER 1.5 1", "line 2: FLASER.num_readings is 1.5, expected a whole number from 1 to 100000"),
        ("FLASER", "line 2: FLASER.num_readings is missing at the end of the line, expected a value"),
        ("RLASER 1 x 0 0 0 0 0 0 5 h 0", "line 2: RLASER.ranges[0] is `x`, expected a number"),
        (
            "ROBOTLASER1 0 -90 3 0.01 50 0.1 0 1 1 0 0 0 0 5 6 0.7 0 0 0 0 0 1 x 0",
            "line 2: ROBOTLASER1.start_angle is -90, expected an angle in radians",
        ),
        (
            "ROBOTLASER1 0 -1 3 0.01 50 0.1 0 1 1 2 0 0 0 5 6 0.7 0 0 0 0 0 1 x 0",
            "line 2: ROBOTLASER1.num_remissions is followed by 14 words, expected 16 words of readings, poses and stamps",
        ),
        ("VERTEX2 1 2 3", "line 2: VERTEX2.theta is missing at the end of the line, expected a value"),
        ("O 1 2 0.5 t", "line 2: O.t is `t`, expected a number"),
        (
            "L 1 2 0.5 1 2 0.5 60 60 1.5",
            "line 2: L.r[3] is missing at the end of the line, expected 180 values",
        ),
    ];
    for (line, expected) in cases {
        assert_eq!(fault(line), expected, "{line}");
    }
}

#[test]
fn lines_are_counted_by_reason_with_the_first_of_each() {
    let text = format!("{}ODOM 1\nODOM 1 2\nODOM x\n{}", odom(0.0, 1.0), odom(0.0, 2.0));
    let (_, faults, tally) = read(text.as_bytes());
    assert_eq!(faults.len(), 3);
    assert_eq!(
        tally.faults.get(&FaultKind::TooFewFields).map(|count| (count.n, count.first.line)),
        Some((2, 2))
    );
    let sentences = tally.sentences();
    assert_eq!(
        sentences[0],
        "skipped 2 lines with too few fields, first line 2: ODOM.y is missing at the end of the line, expected a value"
    );
    assert!(sentences[1].starts_with("skipped 1 line with no number, first line 4"), "{sentences:?}");
}

#[test]
fn a_line_without_end_is_jumped_over_and_keeps_no_memory() {
    let long = "FLASER 3 ".to_owned() + &"1 ".repeat(20 << 20);
    let text = format!("{}{long}\n{}", odom(0.0, 1.0), odom(0.0, 2.0));
    let (records, faults, _) = read(&gzip(text.as_bytes()));
    assert_eq!((records.len(), records[1].line), (2, 3));
    assert_eq!(
        faults[0].to_string(),
        "line 2: the line is longer than 16777216 bytes, expected a line of text"
    );
    // The end of the file inside such a line.
    let (records, faults, _) = read(format!("{}{long}", odom(0.0, 1.0)).as_bytes());
    assert_eq!((records.len(), faults.len()), (1, 1));
}

#[test]
fn what_is_no_log_is_refused_with_what_was_found() {
    let expected = "expected a CARMEN log (FLASER, RLASER, ROBOTLASER1, ODOM, VERTEX2, PARAM) or a Wean Hall log (L, O), \
                    plain or gzip";
    let cases: [(&[u8], String); 5] = [
        (b"", "FILE: the file is empty, expected a robot log".into()),
        (b"# nothing\n\n", format!("FILE: no record found: 2 empty lines and comments; {expected}")),
        (b"a,b\nc,d\n", format!("FILE: no record found: 2 lines, line 1 begins with `a,b`; {expected}")),
        (
            b"ODOM 1 2\n",
            format!(
                "FILE: no record found: line 1: ODOM.theta is missing at the end of the line, expected a value; {expected}"
            ),
        ),
        (
            b"\x1f\x8bgarbage of some length",
            format!(
                "FILE: no record found: line 1: the file is damaged: invalid gzip header; what comes before was read; {expected}"
            ),
        ),
    ];
    for (bytes, message) in cases {
        assert_eq!(open_error(bytes), message);
    }
    let garbage: Vec<u8> = (0..100_000_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    assert!(open_error(&garbage).contains("no record found"));
    assert!(open_error(&gzip(b"")).contains("0 empty lines"));
    assert!(open_error(&"a b c\n".repeat(2_000_000).into_bytes()).contains("10000 lines"), "read to its end");
    let folder = LogReader::open(&std::env::temp_dir(), BeamOverride::default()).unwrap_err();
    assert!(folder.to_string().contains("is a folder, expected a file"), "{folder}");
    let missing = LogReader::open("no/such.clf".as_ref(), BeamOverride::default()).unwrap_err();
    assert!(missing.to_string().contains("no/such.clf: cannot read the log"), "{missing}");
}
