//! What a plugin may be called.

use crate::exit::Failure;
use rumbo_core::registry::Registry;

/// What a crate cannot be called: words of the language, and crates that it needs itself.
const NOT_A_CRATE: [&str; 53] = [
    "abstract",
    "alloc",
    "as",
    "async",
    "await",
    "become",
    "box",
    "break",
    "const",
    "continue",
    "core",
    "crate",
    "do",
    "dyn",
    "else",
    "enum",
    "extern",
    "false",
    "final",
    "fn",
    "for",
    "gen",
    "if",
    "impl",
    "in",
    "let",
    "loop",
    "macro",
    "match",
    "mod",
    "move",
    "mut",
    "override",
    "priv",
    "proc_macro",
    "pub",
    "ref",
    "return",
    "rumbo_core",
    "schemars",
    "self",
    "serde",
    "static",
    "std",
    "struct",
    "super",
    "test",
    "trait",
    "true",
    "try",
    "type",
    "use",
    "while",
];

/// A name that pipelines, file systems and compilers take, and that nobody has.
pub fn check(name: &str, shipped: &Registry) -> Result<(), Failure> {
    let is_fine = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    let wrong = |why: String| Err(Failure::Usage(format!("a plugin cannot be called `{name}`: {why}")));
    if !(1..=64).contains(&name.len()) || !name.chars().all(is_fine) {
        return wrong("a name has 1 to 64 of the characters a-z, 0-9 and _".into());
    }
    if !name.starts_with(|c: char| c.is_ascii_lowercase()) {
        return wrong("a name begins with a letter".into());
    }
    if NOT_A_CRATE.contains(&name) {
        return wrong(
            "this word means something else to the compiler; try another one, such as my_".to_owned() + name,
        );
    }
    if let Some(entry) = shipped.iter().find(|entry| entry.name == name) {
        return wrong(format!("the {} plugin that is shipped has this name", entry.stage.section()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_words_that_nobody_has() {
        let shipped = crate::load::linked().unwrap();
        for fine in ["a", "my_planner", "rrt2", &"x".repeat(64)] {
            assert!(check(fine, &shipped).is_ok(), "{fine}");
        }
        let long = "x".repeat(65);
        for (name, why) in [
            ("", "1 to 64"),
            (long.as_str(), "1 to 64"),
            ("My_planner", "a-z"),
            ("my-planner", "a-z"),
            ("../planner", "a-z"),
            ("größe", "a-z"),
            ("2d", "begins with a letter"),
            ("_", "begins with a letter"),
            ("match", "my_match"),
            ("dp", "the planner plugin"),
            ("sim", "the world plugin"),
        ] {
            let error = check(name, &shipped).unwrap_err().to_string();
            assert!(error.contains(why) && error.contains(&format!("`{name}`")), "{error}");
        }
    }
}
