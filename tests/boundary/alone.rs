//! Memory is measured for a whole process: a test that looks at it is run once more, in a process without the others.

use std::ffi::OsStr;
use std::process::Command;

/// Runs this test of this program by itself, with an environment variable by which it knows that, and passes if it does.
pub fn passes_alone(test: &str, key: &str, value: impl AsRef<OsStr>) {
    let mut alone = Command::new(std::env::current_exe().unwrap());
    let out = alone.args(["--exact", test, "--nocapture"]).env(key, value).output().unwrap();
    let told = String::from_utf8_lossy(&out.stdout);
    assert!(told.contains("1 passed"), "{told}{}", String::from_utf8_lossy(&out.stderr));
}
