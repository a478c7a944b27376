use super::*;

/// One concept a file: at most this many lines of code, not counting comments and empty lines.
const MOST_LINES: usize = 260;
/// Kernels whose parts make sense only together.
const MAY_BE_LONG: [&str; 1] = ["plugins/kit/src/cost_field.rs"];

#[test]
fn files_are_short() {
    let mut long = Vec::new();
    for path in rust_files() {
        let (name, text) = (short(&path), text(&path));
        let is_code = |line: &&str| !line.trim().is_empty() && !line.trim_start().starts_with("//");
        let n_lines = production(&text).lines().filter(is_code).count();
        if is_shipped(&name) && n_lines > MOST_LINES && !MAY_BE_LONG.contains(&name.as_str()) {
            long.push(format!("{name}: {n_lines} lines"));
        }
    }
    assert!(long.is_empty(), "part these files:\n{}", long.join("\n"));
}

#[test]
fn no_file_is_a_drawer_for_odds_and_ends() {
    for path in rust_files() {
        let name = short(&path);
        for drawer in ["utils", "common", "types", "helpers", "misc"] {
            assert!(!name.ends_with(&format!("/{drawer}.rs")), "{name}: name what it holds");
        }
    }
}
