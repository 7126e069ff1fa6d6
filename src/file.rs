use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Writes a file as a whole or not at all: see `gltf::write_atomically`, whose tests are this one's.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let (target, existing) = match fs::canonicalize(path) {
        Ok(target) => {
            let metadata = fs::metadata(&target)?;
            (target, Some(metadata))
        }
        Err(_) => (path.to_owned(), None),
    };
    if let Some(metadata) = &existing {
        if metadata.is_dir() {
            return Err(io::Error::from(io::ErrorKind::IsADirectory));
        }
        if !metadata.is_file() {
            // A device or pipe must not be replaced by a file.
            return fs::write(&target, bytes);
        }
    }
    let folder = match target.parent() {
        Some(folder) if folder != Path::new("") => folder.to_owned(),
        _ => PathBuf::from("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".fresco-").suffix(".tmp");
    // Temporary files are private by default; this one becomes a normal file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(&folder)?;
    file.write_all(bytes)?;
    if let Some(metadata) = existing {
        file.as_file().set_permissions(metadata.permissions())?;
    }
    file.as_file().sync_all()?;
    file.persist(&target).map_err(|error| error.error)?;
    // The new name survives a power cut once the folder is on the disk too. Not all systems can do
    // that, and the file is whole either way.
    if let Ok(folder) = fs::File::open(&folder) {
        folder.sync_all().ok();
    }
    Ok(())
}
