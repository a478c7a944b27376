use super::*;

#[test]
fn the_help_names_every_verb_and_every_exit_code() {
    let help = give(&["--help"]);
    assert_eq!(help.code, 0);
    for word in [
        "run",
        "check",
        "config",
        "schema",
        "plugins",
        "test",
        "compare",
        "eval",
        "plot",
        "emulate",
        "completions",
    ] {
        assert!(help.stdout.contains(&format!("\n  {word} ")), "{word}: {}", help.stdout);
    }
    for code in ["  0 ", "  1 ", "  2 ", "  3 ", "  130 "] {
        assert!(help.stdout.contains(code), "{code}");
    }
}

#[test]
fn a_verb_that_does_not_exist_is_a_fault_of_the_input_and_a_near_one_is_named() {
    let given = give(&["chek", OFFICE]);
    assert_eq!(given.code, 2);
    assert!(given.stderr.contains("check"), "{}", given.stderr);
}

#[test]
fn completions_know_the_verbs_and_their_options() {
    for shell in ["bash", "zsh", "fish"] {
        let script = give(&["completions", shell]);
        assert_eq!(script.code, 0);
        assert!(script.stdout.contains("save-run") && script.stdout.contains("plugins"), "{shell}");
    }
}

#[test]
fn colors_come_only_when_they_are_wanted() {
    let plain = give(&["check", OFFICE]);
    assert!(!plain.stderr.contains('\u{1b}'));
    let painted = give(&["check", OFFICE, "--color", "always"]);
    assert!(painted.stderr.contains('\u{1b}'));
    let refused = given(rumbo(&["check", OFFICE]).env("NO_COLOR", "1"));
    assert!(!refused.stderr.contains('\u{1b}'));
}

#[test]
fn a_reader_that_stops_reading_is_no_error() {
    let mut child = rumbo(&["schema"]).stdout(std::process::Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
