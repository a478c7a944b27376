use super::*;

/// Spellings, notes to oneself, and places that exist on one machine only.
const FORBIDDEN: [&str; 22] = [
    "colour",
    "neighbour",
    "centre",
    "behaviour",
    "metre",
    "favour",
    "analyse",
    "normalise",
    "initialise",
    "optimise",
    "grey",
    "TO\u{44}O",
    "FIX\u{4d}E",
    "XX\u{58}",
    "HAC\u{4b}:",
    "/\u{68}ome/",
    "/\u{72}oot/",
    "/\u{74}mp/",
    "/\u{77}ork/",
    "C:\\",
    "localhost:",
    "192.168.",
];

#[test]
fn words_are_american_and_point_nowhere_private() {
    let folders = ["src", "core", "plugins", "tests", "pipelines", "docs"];
    let mut paths: Vec<PathBuf> =
        folders.iter().flat_map(|folder| files(folder, &[".rs", ".toml", ".md", ".sh"])).collect();
    paths
        .extend(["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "Cargo.toml"].map(|name| root().join(name)));
    let mut found = Vec::new();
    for path in paths {
        let name = short(&path);
        // Test data comes from elsewhere as it is.
        if name == "tests/tidy/words.rs" || name.contains("/data/") {
            continue;
        }
        for (idx, line) in text(&path).lines().enumerate() {
            let words = FORBIDDEN.iter().filter(|word| line.contains(**word));
            found.extend(words.map(|word| format!("{name}:{}: {word}", idx + 1)));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Files that may say `unsafe`: the boundary with its tests, one file of vector instructions, and tests that count
/// allocations.
const MAY_BE_UNSAFE: [&str; 7] = [
    "core/src/boundary/",
    "core/tests/boundary/",
    "tests/boundary/",
    "benches/",
    "plugins/kit/src/simd",
    "core/tests/warm_step.rs",
    "plugins/worlds/tests/warm_world.rs",
];

/// One reason above holds for everything in its function where it says so.
fn is_explained_for_all(above: &[&str]) -> bool {
    let same_item = above.iter().rev().take_while(|line| **line != "}");
    let reasons =
        ["SAFETY: for all blocks below", "SAFETY: for the whole block", "SAFETY: for the four texts"];
    same_item.into_iter().any(|line| reasons.iter().any(|reason| line.contains(reason)))
}

/// Types of the ABI, and functions of such a type: what callers promise is written with the types.
fn is_of_the_abi(name: &str, code: &str) -> bool {
    name.starts_with("core/src/boundary/") && code.contains("unsafe extern") && !code.contains("unsafe {")
}

#[test]
fn unsafe_code_stays_where_it_is_allowed_and_gives_its_reason() {
    let mut wrong = Vec::new();
    for path in rust_files() {
        let name = short(&path);
        let text = text(&path);
        let lines: Vec<&str> = text.lines().collect();
        for (idx, line) in lines.iter().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            let opens = ["unsafe {", "unsafe impl", "unsafe fn", "unsafe extern"]
                .iter()
                .any(|word| code.contains(word));
            if !opens || name.starts_with("tests/tidy/") {
                continue;
            }
            let allowed = MAY_BE_UNSAFE.iter().any(|place| name.starts_with(place));
            let above = &lines[idx.saturating_sub(8)..idx];
            let is_explained = above.iter().any(|line| line.contains("SAFETY:") || line.contains("# Safety"))
                || is_explained_for_all(&lines[..idx])
                || is_of_the_abi(&name, code);
            if !(allowed && (is_explained || !is_shipped(&name))) {
                wrong.push(format!("{name}:{}", idx + 1));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
