use super::*;

/// One concept a file: about this many lines of production code.
const MOST_LINES: usize = 260;
/// No line is longer than the editor shows.
const MOST_LETTERS: usize = 120;

#[test]
fn files_are_short() {
    let mut long = Vec::new();
    for path in rust_files() {
        let (name, text) = (short(&path), text(&path));
        let n_lines = production(&text).lines().count();
        if is_shipped(&name) && n_lines > MOST_LINES {
            long.push(format!("{name}: {n_lines} lines"));
        }
    }
    assert!(long.is_empty(), "part these files:\n{}", long.join("\n"));
}

#[test]
fn lines_are_short_and_end_where_their_words_end() {
    let mut bad = Vec::new();
    for path in rust_files() {
        for (idx, line) in text(&path).lines().enumerate() {
            if line.chars().count() > MOST_LETTERS || line.ends_with([' ', '\t', '\r']) {
                bad.push(format!("{}:{}", short(&path), idx + 1));
            }
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
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
