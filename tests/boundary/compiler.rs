//! C and C++ for the tests: what they compile goes below `target`.

use std::path::{Path, PathBuf};
use std::process::Command;

/// What to compile as; with the flags that our own C code must stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    C,
    Cpp,
}

const STRICT: [&str; 4] = ["-Wall", "-Wextra", "-Wpedantic", "-Werror"];

impl Language {
    fn command(self) -> Command {
        let (compiler, variable, standard) = match self {
            Language::C => ("cc", "CC", "-std=c11"),
            Language::Cpp => ("c++", "CXX", "-std=c++17"),
        };
        let mut command = Command::new(std::env::var(variable).unwrap_or_else(|_| compiler.to_owned()));
        command.arg(standard).args(STRICT).arg("-I").arg(root().join("include"));
        command
    }

    fn ending(self) -> &'static str {
        match self {
            Language::C => "c",
            Language::Cpp => "cpp",
        }
    }
}

/// The folder of the sources.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A fresh folder for one test.
pub fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("boundary").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn run(mut command: Command) {
    let out = command
        .output()
        .unwrap_or_else(|error| panic!("{command:?}: {error}; install a C and a C++ compiler"));
    assert!(out.status.success(), "{command:?}\n{}", String::from_utf8_lossy(&out.stderr));
}

/// Fails where the text does not compile.
pub fn checked(text: &str, language: Language, name: &str) {
    let file = folder(&format!("{name}-{}", language.ending())).join(name).with_extension(language.ending());
    std::fs::write(&file, text).unwrap();
    let mut command = language.command();
    command.arg("-fsyntax-only").arg(&file);
    run(command);
}

/// A shared library of one source file, in a folder of its own.
pub fn library(source: &Path, language: Language, flags: &[&str], name: &str) -> PathBuf {
    let out = folder(name).join(libloading_name(name));
    let mut command = language.command();
    command.args(["-O1", "-shared", "-fPIC", "-fvisibility=hidden"]).arg(source);
    command.arg("-o").arg(&out).args(flags).arg("-lm");
    run(command);
    out
}

fn libloading_name(name: &str) -> String {
    format!("{}{name}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX)
}

/// A shared library of a text.
pub fn library_of_text(text: &str, language: Language, name: &str) -> PathBuf {
    let file = folder(&format!("{name}-source")).join(name).with_extension(language.ending());
    std::fs::write(&file, text).unwrap();
    library(&file, language, &[], name)
}
