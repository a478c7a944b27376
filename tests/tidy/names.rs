//! The page that says what parameters of other systems are called here.

use super::root;

fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|fault| panic!("{path}: {fault}"))
}

/// Cells of a row, without the space around them.
fn cells(row: &str) -> Vec<&str> {
    let inner = row.strip_prefix('|').and_then(|row| row.strip_suffix('|')).unwrap_or(row);
    inner.split('|').map(str::trim).collect()
}

#[test]
fn keys_and_defaults_of_the_page_for_those_who_come_from_elsewhere_are_those_of_the_plugins() {
    let page = read("docs/names-of-others.md");
    let (mut of_plugin, mut n_rows) = (None, 0);
    for line in page.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            let name = heading.split('`').nth(1);
            of_plugin = name.map(|name| read(&format!("docs/plugins/{name}.md")));
        }
        let (Some(plugin), true) = (&of_plugin, line.starts_with("| ")) else { continue };
        let row = cells(line);
        let [_, _, key, default, _] = row[..] else { panic!("not five cells: {line}") };
        if !key.starts_with('`') {
            continue;
        }
        let documented = plugin.lines().find(|row| row.starts_with(&format!("| {key} |")));
        let documented = documented.unwrap_or_else(|| panic!("no parameter {key}: {line}"));
        assert_eq!(cells(documented)[2], default, "{line}");
        n_rows += 1;
    }
    assert!(n_rows > 25, "{n_rows} rows");
}
