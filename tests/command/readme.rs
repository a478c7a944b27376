use super::*;

fn readme() -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap()
}

#[test]
fn the_pipeline_of_the_readme_drives_a_robot_to_its_goal() {
    let readme = readme();
    let block = readme.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let worlds = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/worlds");
    let path = file("readme", &block.replace("worlds/", &format!("{}/", worlds.display())));
    let given = give(&["run", &path, "--no-report"]);
    assert_eq!(given.code, 0, "{}", given.stderr);
}

#[test]
fn what_the_readme_says_of_a_mistyped_key_is_what_check_says() {
    let readme = readme();
    let block = readme.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let mistyped = block.replace("plugin = \"dp\" }", "plugin = \"dp\", minimum_clearence_m = 0.2 }");
    assert_ne!(mistyped, block);
    let given = give(&["check", &file("readme_mistyped", &mistyped)]);
    let said = readme.lines().find(|line| line.contains("minimum_clearence_m: unknown")).unwrap();
    let words = said.split_once("planner.").unwrap().1;
    assert!(given.stderr.contains(words), "{words}: {}", given.stderr);
}

#[test]
fn links_and_verbs_of_the_documents_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let help = give(&["--help"]).stdout;
    for name in [
        "README.md",
        "ARCHITECTURE.md",
        "docs/compare.md",
        "docs/plugin-authors.md",
        "docs/long-checks.md",
        "docs/robot.md",
        "docs/base-protocol.md",
        "docs/plugins/README.md",
    ] {
        let text = std::fs::read_to_string(root.join(name)).unwrap();
        let folder = Path::new(name).parent().unwrap();
        for link in text.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            let is_outside = link.starts_with("http");
            assert!(is_outside || root.join(folder).join(link).exists(), "{name}: {link}");
        }
        let verbs = text.split("`rumbo ").skip(1).filter_map(|rest| rest.split([' ', '`']).next());
        for verb in verbs {
            assert!(help.contains(&format!("\n  {verb} ")), "{name}: rumbo {verb}");
        }
    }
}
