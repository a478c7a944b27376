use super::*;
use std::os::unix::fs::symlink;

#[path = "../boundary/nested.rs"]
#[allow(dead_code)]
mod nested;

const KINDS: [&str; 6] = ["sensor", "map_builder", "localizer", "slam", "planner", "avoider"];

/// Lets a crate share the target folder and the locked versions of the other crates outside of the workspace, so that
/// nothing is downloaded and built twice.
fn settle(folder: &Path) {
    std::fs::create_dir_all(nested::target()).unwrap();
    symlink(nested::target(), folder.join("target")).unwrap();
    std::fs::copy(nested::root().join("Cargo.lock"), folder.join("Cargo.lock")).unwrap();
}

/// Runs a line as somebody in this folder would, with the built command in front of all others.
fn typed(line: &str, folder: &Path) -> Given {
    let command = Path::new(env!("CARGO_BIN_EXE_rumbo")).parent().unwrap();
    let mut path = vec![command.to_path_buf()];
    path.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
    let mut shell = Command::new("sh");
    shell.args(["-c", line]).current_dir(folder).env("PATH", std::env::join_paths(path).unwrap());
    shell.env("NO_COLOR", "1").env("CARGO_NET_OFFLINE", "true").env_remove("CARGO_TARGET_DIR");
    given(&mut shell)
}

fn succeeds(line: &str, folder: &Path) -> String {
    let given = typed(line, folder);
    assert_eq!(given.code, 0, "{line}\n{}{}", given.stdout, given.stderr);
    given.stdout + &given.stderr
}

#[test]
fn every_kind_builds_keeps_its_laws_and_drives_the_robot_to_its_goal() {
    let folder = scratch("new_rust");
    for kind in KINDS {
        let told = succeeds(&format!("rumbo new {kind} my_{kind}"), &folder);
        assert!(told.contains("cargo build --release") && told.contains("rumbo run pipeline.toml"), "{told}");
        let folder = folder.join(format!("my_{kind}"));
        settle(&folder);
        succeeds("cargo test --release --quiet", &folder);
        succeeds("cargo build --release", &folder);
        succeeds("rumbo check pipeline.toml", &folder);
        succeeds("rumbo test pipeline.toml", &folder);
        let told = succeeds("rumbo run pipeline.toml --no-report", &folder);
        assert!(told.contains("arrived"), "{kind}: {told}");
        succeeds(&format!("rumbo plugins verify --broken target/release/libmy_{kind}.so"), &folder);
    }
}

#[test]
fn every_kind_in_c_builds_keeps_its_laws_and_drives_the_robot_to_its_goal() {
    let folder = scratch("new_c");
    for kind in KINDS.into_iter().filter(|kind| *kind != "slam") {
        let told = succeeds(&format!("rumbo new {kind} my_{kind} --lang c"), &folder);
        assert!(told.contains("sh build.sh"), "{told}");
        let folder = folder.join(format!("my_{kind}"));
        succeeds("sh build.sh -Wpedantic -Werror", &folder);
        succeeds("rumbo check pipeline.toml", &folder);
        succeeds("rumbo test pipeline.toml", &folder);
        succeeds(&format!("rumbo plugins verify --broken ./libmy_{kind}.so"), &folder);
    }
    let given = typed("rumbo new slam my_slam --lang c", &folder);
    assert!(given.code == 2 && given.stderr.contains("rumbo_slam_table"), "{}", given.stderr);
    assert!(!folder.join("my_slam").exists());
}

#[test]
fn every_command_of_the_authors_guide_works() {
    let guide = std::fs::read_to_string(nested::root().join("docs/plugin-authors.md")).unwrap();
    let mut folder = scratch("new_guide");
    let mut n_typed = 0;
    for block in guide.split("```console\n").skip(1) {
        for line in block.split("```").next().unwrap().lines().filter_map(|line| line.strip_prefix("$ ")) {
            if let Some(name) = line.strip_prefix("cd ") {
                folder = folder.join(name);
                settle(&folder);
                continue;
            }
            succeeds(line, &folder);
            n_typed += 1;
        }
    }
    assert!(n_typed >= 8, "{n_typed}");
}

#[test]
fn what_is_written_says_where_rumbo_core_comes_from() {
    let folder = scratch("new_source");
    let manifest = |name: &str| std::fs::read_to_string(folder.join(name).join("Cargo.toml")).unwrap();
    succeeds("rumbo new planner here", &folder);
    assert!(manifest("here").contains("rumbo-core = { path = "), "{}", manifest("here"));
    succeeds("rumbo new planner there --rumbo https://example.org/rumbo --output elsewhere", &folder);
    assert!(manifest("elsewhere").contains("git = \"https://example.org/rumbo\""));
    assert!(manifest("elsewhere").contains("name = \"there\""));
    let given = typed("rumbo new planner nowhere --rumbo no/such/folder", &folder);
    assert!(given.code == 2 && given.stderr.contains("there is no rumbo-core"), "{}", given.stderr);
    assert!(!folder.join("nowhere").exists());
}

#[test]
fn what_is_there_is_kept_and_bad_names_are_refused() {
    let folder = scratch("new_refused");
    for (line, words) in [
        ("rumbo new planner dp", "the planner plugin that is shipped has this name"),
        ("rumbo new avoider dp", "the planner plugin that is shipped has this name"),
        ("rumbo new planner My-Planner", "1 to 64 of the characters a-z, 0-9 and _"),
        ("rumbo new planner ../outside", "1 to 64 of the characters"),
        ("rumbo new planner 2d", "begins with a letter"),
        ("rumbo new planner match", "my_match"),
        ("rumbo new world my_world", "possible values"),
    ] {
        let given = typed(line, &folder);
        assert!(given.code == 2 && given.stderr.contains(words), "{line}: {}", given.stderr);
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0);
    succeeds("rumbo new planner mine", &folder);
    std::fs::write(folder.join("mine/src/lib.rs"), "precious").unwrap();
    let given = typed("rumbo new planner mine", &folder);
    assert!(given.code == 2 && given.stderr.contains("is there already"), "{}", given.stderr);
    assert_eq!(std::fs::read_to_string(folder.join("mine/src/lib.rs")).unwrap(), "precious");
}
