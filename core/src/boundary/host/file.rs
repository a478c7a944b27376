//! Is this file a shared library for this machine, whole, and with the entry symbol? Asked before the system loads it,
//! since loading runs its constructors, and says little when it fails.

use super::super::abi::{RUMBO_ABI_MAJOR, RUMBO_ENTRY};
use object::{Architecture, BinaryFormat, Object as _, ObjectSegment as _, ObjectSymbol as _};
use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// What is wrong with the file of a library.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// Nothing there.
    #[error("there is no such file; a plugin is named by the path of its shared library{hint}")]
    Missing {
        /// A file that may be meant.
        hint: String,
    },
    /// A link that leads nowhere.
    #[error("is a link to {target}, which does not exist; build the plugin again or mend the link")]
    DeadLink {
        /// Where it leads.
        target: String,
    },
    /// A folder.
    #[error("is a folder, expected the shared library itself{hint}")]
    Folder {
        /// Libraries in it.
        hint: String,
    },
    /// It cannot be read.
    #[error("cannot be read: {0}")]
    Read(String),
    /// Another checksum than the pipeline says.
    #[error(
        "has the SHA-256 {found}, expected {expected}; it is not the file that was meant: if it is, write the new sum"
    )]
    Checksum {
        /// That of the file.
        found: String,
        /// That of the pipeline.
        expected: String,
    },
    /// No library at all.
    #[error(
        "is no shared library, it begins with {found}; build the plugin as a shared library (`cdylib` in Rust, `-shared` \
         in C) and name the result"
    )]
    NotALibrary {
        /// How it begins.
        found: String,
    },
    /// A library for another machine.
    #[error("is built for {found}, this program runs on {expected}; build the plugin for this target")]
    Target {
        /// Target of the file.
        found: String,
        /// Target of this program.
        expected: String,
    },
    /// The end is missing.
    #[error("is cut off: it has {found} bytes, and its headers speak of {expected}; copy or build it again")]
    Truncated {
        /// Bytes of the file.
        found: u64,
        /// Bytes by its headers.
        expected: u64,
    },
    /// A library, but no plugin, or one of another major.
    #[error("has no symbol {expected}{found}; it is no Rumbo plugin, or for another version")]
    Symbol {
        /// The symbol of this host.
        expected: String,
        /// What it has instead.
        found: String,
    },
}

/// A file that may be loaded.
pub(super) struct Checked {
    /// The file, with links followed.
    pub path: PathBuf,
    /// SHA-256 in hexadecimal.
    pub sha256: String,
}

/// Looks at the file, and at nothing that it says about itself but where its parts are.
pub(super) fn check(path: &Path, sha256: Option<&str>) -> Result<Checked, FileError> {
    let real = resolve(path)?;
    let bytes = fs::read(&real).map_err(|e| FileError::Read(e.to_string()))?;
    let found = hex(&Sha256::digest(&bytes));
    if let Some(expected) = sha256
        && !expected.eq_ignore_ascii_case(&found)
    {
        return Err(FileError::Checksum { found, expected: expected.to_owned() });
    }
    whole(&bytes)?;
    let file = object::File::parse(bytes.as_slice()).map_err(|_| not_a_library(&bytes))?;
    target(&file)?;
    inside(&file, bytes.len() as u64)?;
    symbol(&file)?;
    Ok(Checked { path: real, sha256: found })
}

fn resolve(path: &Path) -> Result<PathBuf, FileError> {
    let Ok(found) = fs::symlink_metadata(path) else {
        return Err(FileError::Missing { hint: near(path) });
    };
    let real = fs::canonicalize(path).map_err(|_| match (found.is_symlink(), fs::read_link(path)) {
        (true, Ok(target)) => FileError::DeadLink { target: target.display().to_string() },
        _ => FileError::Missing { hint: String::new() },
    })?;
    if real.is_dir() {
        return Err(FileError::Folder { hint: libraries_of(&real) });
    }
    Ok(real)
}

/// The file that may be meant: cargo puts `lib` in front and the system's ending behind.
fn near(path: &Path) -> String {
    let Some(stem) = path.file_stem().and_then(|s| s.to_str()) else { return String::new() };
    let name = libloading::library_filename(stem.strip_prefix("lib").unwrap_or(stem));
    let other = path.with_file_name(name);
    if other.exists() { format!("; did you mean {}?", other.display()) } else { String::new() }
}

/// Ending of shared libraries here.
fn is_library(path: &Path) -> bool {
    path.extension().and_then(|e| e.to_str()) == Some(std::env::consts::DLL_EXTENSION)
}

fn libraries_of(folder: &Path) -> String {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut names: Vec<String> = entries.filter(|p| is_library(p)).map(|p| p.display().to_string()).collect();
    names.sort();
    match names.is_empty() {
        true => String::new(),
        false => format!("; it has {}", names.join(", ")),
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn not_a_library(bytes: &[u8]) -> FileError {
    let start = bytes.get(..16).unwrap_or(bytes);
    let found = match std::str::from_utf8(start) {
        _ if bytes.is_empty() => "nothing: it is empty".to_owned(),
        Ok(text) if text.chars().all(|c| !c.is_control() || c.is_whitespace()) => {
            format!("the text {text:?}")
        }
        _ => format!("the bytes {}", hex(start)),
    };
    FileError::NotALibrary { found }
}

/// The section headers of an ELF file, which lie at its end: a parser takes a file without them for one that has none.
fn whole(bytes: &[u8]) -> Result<(), FileError> {
    let is_elf64 = bytes.starts_with(b"\x7fELF\x02\x01");
    let number = |at: usize, len: usize| {
        let digits = bytes.get(at..at + len)?;
        Some(digits.iter().rev().fold(0u64, |n, digit| n << 8 | u64::from(*digit)))
    };
    if !is_elf64 {
        return Ok(());
    }
    let found = bytes.len() as u64;
    let (Some(start), Some(size), Some(count)) = (number(40, 8), number(58, 2), number(60, 2)) else {
        return Err(FileError::Truncated { found, expected: 64 });
    };
    let expected = start.saturating_add(size * count);
    if expected > found { Err(FileError::Truncated { found, expected }) } else { Ok(()) }
}

fn target(file: &object::File<'_>) -> Result<(), FileError> {
    let format = match std::env::consts::OS {
        "macos" | "ios" => BinaryFormat::MachO,
        "windows" => BinaryFormat::Pe,
        _ => BinaryFormat::Elf,
    };
    let machine = match std::env::consts::ARCH {
        "x86_64" => Architecture::X86_64,
        "aarch64" => Architecture::Aarch64,
        "x86" => Architecture::I386,
        "arm" => Architecture::Arm,
        "riscv64" => Architecture::Riscv64,
        _ => file.architecture(),
    };
    if (file.format(), file.architecture()) == (format, machine) {
        return Ok(());
    }
    let found = format!("{:?} on {:?}", file.format(), file.architecture());
    Err(FileError::Target { found, expected: format!("{format:?} on {machine:?}") })
}

/// Everything that will be mapped is in the file: reading a page behind its end would kill the program.
fn inside(file: &object::File<'_>, found: u64) -> Result<(), FileError> {
    let ends = file.segments().map(|segment| {
        let (start, size) = segment.file_range();
        start.saturating_add(size)
    });
    let expected = ends.max().unwrap_or(0);
    if expected > found { Err(FileError::Truncated { found, expected }) } else { Ok(()) }
}

fn symbol(file: &object::File<'_>) -> Result<(), FileError> {
    let expected = String::from_utf8_lossy(&RUMBO_ENTRY[..RUMBO_ENTRY.len() - 1]).into_owned();
    let stem = expected.trim_end_matches(|c: char| c.is_ascii_digit());
    let mut others = Vec::new();
    let exports = file.dynamic_symbols().filter(|symbol| symbol.is_definition());
    for name in exports.filter_map(|symbol| symbol.name().map(str::to_owned).ok()) {
        // Mach-O puts an underscore in front of C names.
        let name = name.strip_prefix('_').filter(|_| file.format() == BinaryFormat::MachO).unwrap_or(&name);
        if name == expected {
            return Ok(());
        }
        if let Some(major) = name.strip_prefix(stem) {
            others.push(major.to_owned());
        }
    }
    let found = match others.is_empty() {
        true => String::new(),
        false => {
            format!(", but those of ABI {}, and this host speaks ABI {RUMBO_ABI_MAJOR}", others.join(", "))
        }
    };
    Err(FileError::Symbol { expected, found })
}
