//! Crates outside of the workspace, built for the tests: all share one target folder, so that each dependency is built once.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{LazyLock, Mutex, PoisonError};

/// The folder of the sources.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Where the libraries are, below a folder named after the profile.
pub fn target() -> PathBuf {
    root().join("target/third_party")
}

/// One at a time: several would only wait for each other's locks.
static ALONE: Mutex<()> = Mutex::new(());

/// The library of the crate in this folder, built with this profile.
pub fn library(folder: &Path, name: &str, profile: &str) -> PathBuf {
    built(cargo(), folder, name, profile)
}

/// The cargo that runs these tests.
fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// As [`library`], by this cargo.
pub fn built(mut cargo: Command, folder: &Path, name: &str, profile: &str) -> PathBuf {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    cargo.args(["build", "--locked", "--quiet", "--profile", profile]);
    finish(&mut cargo, folder);
    target().join(profile).join(file_name(name))
}

fn finish(cargo: &mut Command, folder: &Path) {
    let out = cargo.current_dir(folder).env("CARGO_TARGET_DIR", target()).output();
    let out = out.unwrap_or_else(|error| panic!("{cargo:?}: {error}"));
    assert!(out.status.success(), "{cargo:?}\n{}", String::from_utf8_lossy(&out.stderr));
}

fn file_name(library: &str) -> String {
    format!("{}{library}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX)
}

/// The crate with a planner and an avoider from outside.
pub fn third_party() -> &'static Path {
    static FILE: LazyLock<PathBuf> =
        LazyLock::new(|| library(&root().join("examples/third_party_rust"), "third_party_rust", "release"));
    &FILE
}

/// The crate with planners that misbehave.
pub fn fixture() -> &'static Path {
    static FILE: LazyLock<PathBuf> = LazyLock::new(|| {
        if let Some(file) = std::env::var_os(GIVEN_FIXTURE) {
            return file.into();
        }
        let file = scratch("fixture").join(file_name("rust_fixture"));
        std::fs::copy(library(&fixture_folder(), "rust_fixture", "release"), &file).unwrap();
        file
    });
    &FILE
}

/// A test that runs in a process of its own is given that library: building it there would meet [`aborting_fixture`] here, which
/// writes the same file, and whose lock holds for one process.
pub const GIVEN_FIXTURE: &str = "RUMBO_TEST_FIXTURE";

/// The same, whose panics abort: its own crate alone, so that those below it need not be built once more.
pub fn aborting_fixture() -> PathBuf {
    // Whose file this build writes over.
    fixture();
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let mut cargo = cargo();
    cargo.args(["rustc", "--locked", "--quiet", "--release", "--", "-C", "panic=abort"]);
    finish(&mut cargo, &fixture_folder());
    target().join("release").join(file_name("rust_fixture"))
}

/// Its sources.
pub fn fixture_folder() -> PathBuf {
    root().join("tests/boundary/rust_fixture")
}

/// A fresh folder for one test.
pub fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("boundary").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// What the command gave: exit code, standard output, standard error.
pub fn rumbo(args: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rumbo"));
    let out = command.args(args).current_dir(root()).env("NO_COLOR", "1").output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (out.status.code().unwrap_or(-1), text(out.stdout), text(out.stderr))
}
