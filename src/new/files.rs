//! What is written: the templates with their blanks filled in.
//!
//! A blank is a word in two pairs of braces. The templates are files beside this one, so that they can be read, and their
//! code compiled.

use super::{Kind, Language};
use crate::exit::Failure;

/// A file to write.
#[derive(Debug)]
pub struct Filled {
    /// Below the plugin's folder.
    pub path: &'static str,
    /// What it has.
    pub text: String,
}

/// All files of a new plugin. `rumbo` is the dependency of a Rust plugin.
pub fn filled(kind: Kind, lang: Language, name: &str, rumbo: &str) -> Result<Vec<Filled>, Failure> {
    let (sections, library_folder) = (sections(kind, name), library_folder(lang));
    let blanks = [
        ("name", name),
        ("stage", kind.section()),
        ("rumbo", rumbo),
        ("library_folder", library_folder),
        ("sensor", &sections.sensor),
        ("map_and_place", &sections.map_and_place),
        ("planner", &sections.planner),
        ("avoider", &sections.avoider),
    ];
    let templates = match lang {
        Language::Rust => rust(kind),
        Language::C => c(kind)?,
    };
    let fill = |(path, template): (&'static str, &str)| {
        let text = blanks.iter().fold(template.to_owned(), |text, (blank, value)| {
            text.replace(&format!("{{{{{blank}}}}}"), value)
        });
        Filled { path, text }
    };
    Ok(templates.into_iter().chain(EVERY_LANGUAGE).map(fill).collect())
}

const EVERY_LANGUAGE: [(&str, &str); 2] = [
    ("pipeline.toml", include_str!("templates/pipeline.toml")),
    ("world.toml", include_str!("templates/world.toml")),
];

/// Where the build puts the library.
fn library_folder(lang: Language) -> &'static str {
    match lang {
        Language::Rust => "target/release",
        Language::C => ".",
    }
}

fn rust(kind: Kind) -> Vec<(&'static str, &'static str)> {
    let library = match kind {
        Kind::Sensor => include_str!("templates/rust/sensor.rs"),
        Kind::MapBuilder => include_str!("templates/rust/map_builder.rs"),
        Kind::Localizer => include_str!("templates/rust/localizer.rs"),
        Kind::Slam => include_str!("templates/rust/slam.rs"),
        Kind::Planner => include_str!("templates/rust/planner.rs"),
        Kind::Avoider => include_str!("templates/rust/avoider.rs"),
    };
    vec![
        ("Cargo.toml", include_str!("templates/rust/manifest.toml")),
        ("src/lib.rs", library),
        ("README.md", include_str!("templates/rust/readme.md")),
        (".gitignore", include_str!("templates/rust/gitignore")),
    ]
}

fn c(kind: Kind) -> Result<Vec<(&'static str, &'static str)>, Failure> {
    let plugin = match kind {
        Kind::Sensor => include_str!("templates/c/sensor.c"),
        Kind::MapBuilder => include_str!("templates/c/map_builder.c"),
        Kind::Localizer => include_str!("templates/c/localizer.c"),
        Kind::Planner => include_str!("templates/c/planner.c"),
        Kind::Avoider => include_str!("templates/c/avoider.c"),
        Kind::Slam => {
            return Err(Failure::Usage(
                "there is no SLAM plugin in C to begin with; write a map_builder and a localizer, and see rumbo_slam_table in \
                 their rumbo_plugin.h"
                    .into(),
            ));
        }
    };
    Ok(vec![
        ("plugin.c", plugin),
        ("rumbo_plugin.h", include_str!("../../include/rumbo_plugin.h")),
        ("build.sh", include_str!("templates/c/build.sh")),
        ("README.md", include_str!("templates/c/readme.md")),
        (".gitignore", include_str!("templates/c/gitignore")),
    ])
}

/// The parts of a pipeline that differ from stage to stage: the new plugin in its seat, shipped ones in the others.
struct Sections {
    sensor: String,
    map_and_place: String,
    planner: String,
    avoider: String,
}

fn sections(kind: Kind, name: &str) -> Sections {
    let plugin = |here: Kind, shipped: &str, keys: &str| {
        let (plugin, keys) = if here == kind { (name, keys) } else { (shipped, "") };
        format!("plugin = \"{plugin}\"{keys}")
    };
    let map_and_place = match kind {
        Kind::Slam => format!("[slam]\nplugin = \"{name}\"\nsize_m = 30.0"),
        _ => {
            let map = plugin(Kind::MapBuilder, "static_map", "\nsize_m = 30.0");
            let place = plugin(Kind::Localizer, "odometry", "\nerror_m_per_m = 0.02");
            format!("[map_builder]\n{map}\n\n[localizer]\n{place}")
        }
    };
    Sections {
        sensor: plugin(Kind::Sensor, "lms200", "\nnoise_m = 0.01"),
        map_and_place,
        planner: plugin(Kind::Planner, "dp", "\nclearance_m = 0.35"),
        avoider: plugin(Kind::Avoider, "stop_and_replan", "\nlook_ahead_m = 0.3"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum as _;

    #[test]
    fn no_blank_is_left_open() {
        for kind in Kind::value_variants() {
            for file in filled(*kind, Language::Rust, "my_plugin", "{ path = \"core\" }").unwrap() {
                assert!(!file.text.contains("{{") && !file.text.contains("}}"), "{kind:?} {}", file.path);
                assert!(file.text.ends_with('\n'), "{kind:?} {}", file.path);
            }
        }
    }
}
