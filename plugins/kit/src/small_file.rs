//! Files that people write by hand: read whole, but never without end.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Nobody writes more than this by hand, bytes.
const MOST_BYTES: u64 = 16 << 20;

/// The text of a file of at most 16 MiB.
///
/// # Errors
/// What the system says; what is no file (a device, a folder); a file that is larger, or is not UTF-8.
pub(crate) fn read_text(path: &Path) -> Result<String> {
    let file = File::open(path)?;
    if !file.metadata()?.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, "this is not a file"));
    }
    let mut text = String::new();
    let n_bytes = file.take(MOST_BYTES + 1).read_to_string(&mut text)?;
    if n_bytes as u64 > MOST_BYTES {
        return Err(Error::new(ErrorKind::InvalidData, "more than 16 MiB, which nobody wrote by hand"));
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_folders_and_huge_files_are_refused() {
        let folder = std::env::temp_dir().join(format!("rumbo-small-file-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("text");
        std::fs::write(&path, "name = 1").unwrap();
        assert_eq!(read_text(&path).unwrap(), "name = 1");
        File::create(&path).unwrap().set_len(MOST_BYTES + 1).unwrap();
        assert!(read_text(&path).unwrap_err().to_string().contains("16 MiB"));
        assert!(read_text(&folder).is_err());
        if Path::new("/dev/zero").exists() {
            assert!(read_text(Path::new("/dev/zero")).unwrap_err().to_string().contains("not a file"));
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
