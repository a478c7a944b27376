//! Libraries that cannot be loaded: each is refused, none ends the program, and every message says what to do.

use crate::compiler::{self, Language};
use rumbo_core::registry::Registry;
use std::path::{Path, PathBuf};

fn record(name: &str, spoiled: &[&str]) -> PathBuf {
    let source = compiler::root().join("tests/boundary/fixtures/record.c");
    let flags: Vec<String> = spoiled.iter().map(|flag| format!("-D{flag}")).collect();
    let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
    compiler::library(&source, Language::C, &flags, name)
}

/// What loading says, with `FILE` for the file.
fn said(path: &Path) -> Result<(), String> {
    let shown = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf()).display().to_string();
    let loaded = rumbo::registry().unwrap().load(path, None);
    loaded.map(drop).map_err(|error| {
        let error = error.to_string();
        error.replace(&path.display().to_string(), "FILE").replace(&shown, "FILE")
    })
}

#[track_caller]
fn refused(path: &Path, expected: &str) {
    let found = said(path).expect_err("it was loaded");
    assert_eq!(found, expected);
}

#[track_caller]
fn record_refused(name: &str, spoiled: &[&str], expected: &str) {
    refused(&record(name, spoiled), &format!("cannot load FILE: {expected}"));
}

#[test]
fn a_record_without_fault_is_loaded() {
    assert_eq!(said(&record("faultless", &[])), Ok(()));
}

#[test]
fn a_record_of_something_else_is_refused() {
    record_refused(
        "magic",
        &["MAGIC=0x1122334455667788"],
        "its entry function returned a record that begins with 0x1122334455667788, expected 0x474c504f424d5552; it is no \
         Rumbo plugin",
    );
}

#[test]
fn a_record_of_another_major_is_refused() {
    record_refused(
        "major",
        &["MAJOR=2", "MINOR=3"],
        "it speaks ABI 2.3, this host speaks ABI 1 (up to 1.1); rebuild the plugin against this version, or take the \
         version of Rumbo that it was built for",
    );
}

#[test]
fn a_library_with_the_symbol_of_another_major_is_refused() {
    record_refused(
        "symbol",
        &["SYMBOL=rumbo_plugin_entry_v2"],
        "has no symbol rumbo_plugin_entry_v1, but those of ABI 2, and this host speaks ABI 1; it is no Rumbo plugin, or \
         for another version",
    );
}

#[test]
fn a_library_without_the_symbol_is_refused() {
    record_refused(
        "no_symbol",
        &["SYMBOL=something_else"],
        "has no symbol rumbo_plugin_entry_v1; it is no Rumbo plugin, or for another version",
    );
}

#[test]
fn a_library_that_refuses_the_host_is_refused() {
    record_refused(
        "null_record",
        &["RESULT=NULL"],
        "its entry function refuses this host (ABI 1.1); it asks for a newer one, or it failed to start",
    );
}

#[test]
fn a_library_that_does_not_catch_is_refused() {
    record_refused(
        "aborts",
        &["FLAGS=0"],
        "it does not catch its panics: it was built with `panic = \"abort\"` (or without RUMBO_CATCHES), so that a fault \
         in it would end the whole program with the robot moving; build it with `panic = \"unwind\"`",
    );
}

#[test]
fn a_record_that_is_too_small_is_refused() {
    record_refused(
        "small_module",
        &["MODULE_SIZE=40"],
        "its record says to have 40 bytes, expected at least 64; it is damaged or built by hand wrongly",
    );
}

#[test]
fn a_wrong_number_of_entries_is_refused() {
    let wrong = |says: &str, has: &str| {
        format!(
            "its record says {says} entries, but its list has {has}; it is damaged or built by hand wrongly"
        )
    };
    record_refused("too_many", &["N_ENTRIES=3"], &wrong("3", "1"));
    record_refused("too_few", &["N_ENTRIES=1", "LIST=&whole.entry, &whole.entry, NULL"], &wrong("1", "more"));
    record_refused("none_of_one", &["N_ENTRIES=0"], &wrong("0", "more"));
    record_refused("huge", &["N_ENTRIES=SIZE_MAX"], &wrong("18446744073709551615", "room for at most 1024"));
    record_refused("no_list", &["ENTRIES=NULL"], &wrong("1", "no place"));
}

#[test]
fn entries_that_lack_something_are_refused() {
    let name = "its entry 0 (`spoiled`) ";
    record_refused(
        "no_table",
        &["TABLE=NULL"],
        &format!("{name}has no table of functions: `table` points nowhere"),
    );
    record_refused("no_create", &["CREATE=NULL"], &format!("{name}has no function `create`"));
    record_refused("no_plan", &["PLAN=NULL"], &format!("{name}has no function `plan` in its table"));
    record_refused("no_destroy", &["DESTROY=NULL"], &format!("{name}has no function `destroy` in its table"));
    record_refused(
        "stage",
        &["STAGE=99"],
        &format!("{name}is for a stage with the number 99, which this host does not know"),
    );
}

#[test]
fn bad_texts_are_refused() {
    let bad = "has a bad name, expected 1 to 64 of a-z, 0-9 and _";
    for (idx, name) in ["", "Upper", "with space", "path/../up", "umlaut\u{e4}"].into_iter().enumerate() {
        let flag = format!("NAME=\"{name}\"");
        record_refused(&format!("name_{idx}"), &[&flag], &format!("its entry 0 (`{name}`) {bad}"));
    }
    let long = "a".repeat(65);
    let flag = format!("NAME=\"{long}\"");
    record_refused("name_long", &[&flag], &format!("its entry 0 (`{long}`) {bad}"));
    record_refused("name_bytes", &[r#"NAME="\xff\xfe""#], "its entry 0 has a name that is no UTF-8 text");
    record_refused(
        "name_huge",
        &["NAME_LEN=SIZE_MAX"],
        "its entry 0 has a name of 18446744073709551615 bytes, expected at most 16777216",
    );
    record_refused(
        "summary_bytes",
        &[r#"SUMMARY="\xc3\x28""#],
        "its entry 0 (`spoiled`) has a summary that is no UTF-8 text",
    );
}

#[test]
fn a_schema_or_defaults_that_cannot_be_read_are_refused() {
    record_refused(
        "schema",
        &[r#"SCHEMA="{ not json""#],
        "its entry 0 (`spoiled`) has a schema that is no JSON: key must be a string at line 1 column 3",
    );
    record_refused(
        "schema_array",
        &[r#"SCHEMA="[1, 2]""#],
        "its entry 0 (`spoiled`) has a schema that is no JSON object, expected { \"type\": \"object\", \"properties\": ... }",
    );
    record_refused(
        "defaults",
        &[r#"DEFAULTS="= 3""#],
        "its entry 0 (`spoiled`) has defaults that are no TOML: unquoted keys cannot be empty, expected letters, numbers, `-`, `_`",
    );
}

#[test]
fn files_that_are_no_library_are_refused() {
    let folder = compiler::folder("no_library");
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    refused(
        &write("text.so", b"hello, this is text"),
        "cannot load FILE: is no shared library, it begins with the text \"hello, this is t\"; build the plugin as a \
         shared library (`cdylib` in Rust, `-shared` in C) and name the result",
    );
    refused(
        &write("empty.so", b""),
        "cannot load FILE: is no shared library, it begins with nothing: it is empty; build the plugin as a shared \
         library (`cdylib` in Rust, `-shared` in C) and name the result",
    );
    refused(
        &folder.join("nowhere.so"),
        "cannot load FILE: there is no such file; a plugin is named by the path of its shared library",
    );
    let found = said(&folder).unwrap_err();
    assert!(
        found.starts_with(
            "cannot load FILE: is a folder, expected the shared library itself; it has FILE/empty.so"
        ),
        "{found}"
    );
}

#[cfg(unix)]
#[test]
fn a_link_that_leads_nowhere_is_refused() {
    let link = compiler::folder("dead_link").join("libdead.so");
    std::os::unix::fs::symlink("gone/libdead.so", &link).unwrap();
    refused(
        &link,
        "cannot load FILE: is a link to gone/libdead.so, which does not exist; build the plugin again or mend the link",
    );
}

/// The library of a faultless record with other bytes.
fn changed(name: &str, change: impl FnOnce(&mut Vec<u8>)) -> PathBuf {
    let path = record(name, &[]);
    let mut bytes = std::fs::read(&path).unwrap();
    change(&mut bytes);
    // Another file: the linker's output may be mapped already.
    let other = path.with_file_name(format!("changed_{name}.so"));
    std::fs::write(&other, bytes).unwrap();
    other
}

#[cfg(all(target_os = "linux", target_endian = "little"))]
#[test]
fn a_library_for_another_machine_is_refused() {
    // `e_machine` lies 18 bytes into an ELF file; 21 is 64-bit PowerPC.
    let path = changed("machine", |bytes| bytes[18..20].copy_from_slice(&[21, 0]));
    let found = said(&path).unwrap_err();
    assert!(
        found.starts_with("cannot load FILE: is built for Elf on PowerPc64, this program runs on Elf on "),
        "{found}"
    );
    assert!(found.ends_with("; build the plugin for this target"), "{found}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_library_that_is_cut_off_anywhere_is_refused() {
    let whole = std::fs::read(record("cut", &[])).unwrap();
    let folder = compiler::folder("cut_off");
    // A multiplicative sequence: the same lengths in every run, without a pattern of their own.
    let scattered = (1..=200u64).scan(0x9e37_79b9_7f4a_7c15_u64, |seed, _| {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        Some((*seed >> 33) as usize % whole.len())
    });
    let lengths =
        [1, 4, 15, 16, 63, 64, 65, 120, 4096, whole.len() / 2, whole.len() - 1].into_iter().chain(scattered);
    for length in lengths {
        let path = folder.join(format!("libcut{length}.so"));
        std::fs::write(&path, &whole[..length]).unwrap();
        let found = said(&path).expect_err("a library that is cut off was loaded");
        let is_told = found.contains("is cut off: it has ") || found.contains("is no shared library");
        assert!(is_told, "{length} of {} bytes: {found}", whole.len());
        std::fs::remove_file(path).unwrap();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_library_whose_own_library_is_missing_is_refused() {
    let folder = compiler::folder("stub");
    let source = folder.join("stub.c");
    std::fs::write(
        &source,
        "int stub(void);\n__attribute__((visibility(\"default\"))) int stub(void) { return 7; }\n",
    )
    .unwrap();
    let stub = compiler::library(&source, Language::C, &[], "rumbo_stub");
    let source = compiler::root().join("tests/boundary/fixtures/record.c");
    let search = format!("-L{}", stub.parent().unwrap().display());
    let flags = ["-DDEPENDENCY=stub", &search, "-lrumbo_stub"];
    let path = compiler::library(&source, Language::C, &flags, "needs_stub");
    std::fs::remove_file(stub).unwrap();
    refused(
        &path,
        "cannot load FILE: the system cannot load it: librumbo_stub.so: cannot open shared object file: No such file or \
         directory",
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_library_that_calls_what_nobody_has_is_refused() {
    let path = record("undefined", &["DEPENDENCY=nobody_has_this"]);
    refused(&path, "cannot load FILE: the system cannot load it: FILE: undefined symbol: nobody_has_this");
}

#[test]
fn another_checksum_is_refused_and_the_right_one_is_not() {
    let path = record("checksum", &[]);
    let load = |sum: &str| {
        rumbo::registry().unwrap().load(&path, Some(sum)).map(|library| library.info.sha256.clone())
    };
    let zeros = "0".repeat(64);
    let found = load(&zeros).unwrap_err().to_string();
    assert!(
        found.contains("has the SHA-256 ") && found.contains(&format!(", expected {zeros}; ")),
        "{found}"
    );
    let loaded = rumbo::registry().unwrap().load(&path, None).unwrap().info.sha256.clone();
    assert_eq!(load(&loaded.to_uppercase()).unwrap(), loaded);
    let again = load(&zeros).unwrap_err().to_string();
    assert_eq!(found, again, "also when it is loaded already");
}

#[test]
fn the_same_library_twice_is_once() {
    let path = record("twice", &[]);
    let mut registry = rumbo::registry().unwrap();
    let n_linked = registry.iter().count();
    registry.load(&path, None).unwrap();
    registry.load(&path, None).unwrap();
    assert_eq!(registry.iter().count(), n_linked + 1);
}

#[test]
fn a_name_that_is_taken_is_refused_with_both_files() {
    let (first, second) = (record("first", &[]), record("second", &[]));
    let mut registry = Registry::default();
    registry.load(&first, None).unwrap();
    let found = registry.load(&second, None).unwrap_err().to_string();
    let [first, second] =
        [first, second].map(|path| std::fs::canonicalize(path).unwrap().display().to_string());
    assert_eq!(
        found,
        format!(
            "two planner plugins are called `spoiled`: one in {first}, one in {second}; rename or remove one"
        )
    );
}

#[test]
fn a_name_that_we_have_is_refused() {
    let path = record("ours", &[r#"NAME="a_star""#]);
    let found = said(&path).unwrap_err();
    assert!(
        found.starts_with("two planner plugins are called `a_star`: one in rumbo-planners")
            && found.ends_with("one in FILE; rename or remove one"),
        "{found}"
    );
}
