//! Where a new crate gets `rumbo-core` from.

use crate::exit::Failure;
use std::path::{Path, PathBuf};

/// A source of `rumbo-core`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    /// The folder of the crate `rumbo-core`.
    Folder(PathBuf),
    /// A git repository.
    Git(String),
}

impl Source {
    /// The one that was named; else the sources that this program was built from, while they are there; else the
    /// repository of this version.
    pub fn of(named: Option<&str>) -> Result<Source, Failure> {
        let built_from = Path::new(env!("CARGO_MANIFEST_DIR"));
        match named {
            Some(address) if is_address(address) => Ok(Source::Git(address.to_owned())),
            Some(folder) => core_in(Path::new(folder)).map(Source::Folder).ok_or_else(|| {
                Failure::Usage(format!(
                    "--rumbo {folder}: there is no rumbo-core; name the folder of Rumbo's sources or the address of a git \
                     repository"
                ))
            }),
            None => Ok(core_in(built_from)
                .map_or_else(|| Source::Git(env!("CARGO_PKG_REPOSITORY").to_owned()), Source::Folder)),
        }
    }

    /// The right side of `rumbo-core = ` in a manifest.
    pub fn dependency(&self) -> String {
        // TOML and the debug format of text agree on backslashes and quotation marks.
        match self {
            Source::Folder(folder) => format!("{{ path = {:?} }}", folder.display().to_string()),
            Source::Git(address) => {
                format!("{{ git = {address:?}, version = {:?} }}", env!("CARGO_PKG_VERSION"))
            }
        }
    }
}

fn is_address(text: &str) -> bool {
    text.contains("://") || text.starts_with("git@")
}

/// The folder of `rumbo-core` in Rumbo's sources, or this folder itself where it is that crate.
fn core_in(folder: &Path) -> Option<PathBuf> {
    let folder = folder.canonicalize().ok()?;
    let is_core = |folder: &PathBuf| {
        let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).unwrap_or_default();
        manifest.lines().any(|line| line.trim() == "name = \"rumbo-core\"")
    };
    [folder.join("core"), folder].into_iter().find(is_core)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_are_found_where_they_are_and_addresses_are_told_from_folders() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).canonicalize().unwrap();
        let core = Source::Folder(root.join("core"));
        assert_eq!(Source::of(None).unwrap(), core);
        for folder in [root.clone(), root.join("core")] {
            assert_eq!(Source::of(folder.to_str()).unwrap(), core);
        }
        let address = "https://example.org/rumbo.git";
        let dependency = Source::of(Some(address)).unwrap().dependency();
        assert!(
            dependency.starts_with("{ git = \"https://example.org/rumbo.git\", version = \""),
            "{dependency}"
        );
        let error = Source::of(Some("no/such/folder")).unwrap_err().to_string();
        assert!(error.contains("no/such/folder") && error.contains("there is no rumbo-core"), "{error}");
    }
}
