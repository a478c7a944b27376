//! Compares a run with what its test expects.

use crate::outcome::Outcome;
use rumbo_core::pipeline::Expect;

/// Everything that is not as expected, in words; empty when the test passed.
pub fn failures(expect: &Expect, outcome: &Outcome) -> Vec<String> {
    let mut failures = Vec::new();
    if let Some(limit_s) = expect.arrives_within_s {
        if !outcome.arrived {
            failures
                .push(format!("the robot did not arrive ({}), expected within {limit_s} s", outcome.reason));
        } else if outcome.time_s > limit_s {
            failures.push(format!("arrived after {:.2} s, expected within {limit_s} s", outcome.time_s));
        }
    }
    if let Some(reason) = expect.reason.as_ref().filter(|reason| **reason != outcome.reason.to_string()) {
        failures.push(format!("ended with `{}`, expected `{reason}`", outcome.reason));
    }
    let at_most = [
        ("goal_error_m", outcome.goal_error_m, expect.goal_error_m),
        ("final_error_m", outcome.final_error_m, expect.final_error_m),
        ("final_heading_error_deg", outcome.final_heading_error_deg, expect.final_heading_error_deg),
        ("rms_error_m", outcome.rms_error_m, expect.rms_error_m),
        ("p95_error_m", outcome.p95_error_m, expect.p95_error_m),
        ("map_free_m2", outcome.map_free_m2, expect.map_free_at_most_m2),
    ];
    for (name, found, limit) in at_most {
        let Some(limit) = limit else { continue };
        match found {
            None => failures.push(format!("{name} is not known, expected at most {limit}")),
            Some(found) if found <= limit => {}
            Some(found) => failures.push(format!("{name} is {found:.4}, expected at most {limit}")),
        }
    }
    if expect.no_contact && outcome.contacts != Some(0) {
        failures.push(match outcome.contacts {
            Some(n) => format!("the hull touched something {n} times, expected no contact"),
            None => "nobody knows whether the hull touched something, expected no contact".into(),
        });
    }
    if let Some(least_m) = expect.min_clearance_m
        && outcome.min_clearance_m.is_none_or(|found| found < least_m)
    {
        let found = outcome.min_clearance_m.map_or("not known".into(), |found| format!("{found:.4}"));
        failures.push(format!("min_clearance_m is {found}, expected at least {least_m}"));
    }
    if let Some(least_m2) = expect.map_free_at_least_m2
        && outcome.map_free_m2.is_none_or(|found| found < least_m2)
    {
        let found = outcome.map_free_m2.map_or("not known".into(), |found| format!("{found:.1}"));
        failures.push(format!("map_free_m2 is {found}, expected at least {least_m2}"));
    }
    let replans = outcome.replans;
    if expect.replans_at_least.is_some_and(|least| replans < least) {
        failures
            .push(format!("{replans} new plans, expected at least {}", expect.replans_at_least.unwrap_or(0)));
    }
    if expect.replans_at_most.is_some_and(|most| replans > most) {
        failures
            .push(format!("{replans} new plans, expected at most {}", expect.replans_at_most.unwrap_or(0)));
    }
    failures
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::test_record;

    #[test]
    fn a_run_that_is_as_expected_has_no_failures() {
        let outcome = test_record().outcome.unwrap();
        let expect = Expect {
            arrives_within_s: Some(3.0),
            reason: Some("arrived".into()),
            goal_error_m: Some(0.05),
            final_error_m: Some(0.022),
            final_heading_error_deg: Some(3.0),
            rms_error_m: Some(0.022),
            p95_error_m: Some(0.023),
            map_free_at_least_m2: Some(11.7),
            map_free_at_most_m2: Some(11.7),
            no_contact: true,
            min_clearance_m: Some(0.1),
            replans_at_least: Some(1),
            replans_at_most: Some(1),
        };
        assert!(failures(&expect, &outcome).is_empty());
    }

    #[test]
    fn each_expectation_fails_by_itself() {
        let outcome = test_record().outcome.unwrap();
        let wrong = [
            ("within", Expect { arrives_within_s: Some(2.9), ..Expect::default() }),
            ("`unreachable`", Expect { reason: Some("unreachable".into()), ..Expect::default() }),
            ("goal_error_m", Expect { goal_error_m: Some(0.04), ..Expect::default() }),
            ("final_error_m", Expect { final_error_m: Some(0.02), ..Expect::default() }),
            ("final_heading_error_deg", Expect { final_heading_error_deg: Some(1e-9), ..Expect::default() }),
            ("rms_error_m", Expect { rms_error_m: Some(0.02), ..Expect::default() }),
            ("p95_error_m", Expect { p95_error_m: Some(0.02), ..Expect::default() }),
            ("at least 12", Expect { map_free_at_least_m2: Some(12.0), ..Expect::default() }),
            ("at most 11", Expect { map_free_at_most_m2: Some(11.0), ..Expect::default() }),
            ("min_clearance_m", Expect { min_clearance_m: Some(0.2), ..Expect::default() }),
            ("at least 2", Expect { replans_at_least: Some(2), ..Expect::default() }),
            ("at most 0", Expect { replans_at_most: Some(0), ..Expect::default() }),
        ];
        for (words, expect) in wrong {
            let failures = failures(&expect, &outcome);
            assert!(failures.len() == 1 && failures[0].contains(words), "{words}: {failures:?}");
        }
    }

    #[test]
    fn what_nobody_knows_is_no_success() {
        let outcome = Outcome { contacts: None, final_error_m: None, ..test_record().outcome.unwrap() };
        let expect = Expect { no_contact: true, final_error_m: Some(1.0), ..Expect::default() };
        assert_eq!(failures(&expect, &outcome).len(), 2);
    }
}
