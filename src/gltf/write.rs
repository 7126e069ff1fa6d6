use std::path::Path;

use super::GltfError;
use crate::file;

/// Writes a file as a whole or not at all.
///
/// The bytes go to a temporary file in the same folder first, which takes the name of `path` once
/// all of them are on the disk. Whatever goes wrong before that, a file that was there stays as it
/// was. An existing file keeps its permissions; a link stays a link, and the file it leads to is
/// replaced.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), GltfError> {
    file::write(path, bytes).map_err(|source| GltfError::Write {
        path: path.to_owned(),
        source,
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn gltf_write_replaces_a_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        write_atomically(&path, b"old").unwrap();
        write_atomically(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.glb"]);
    }

    #[test]
    fn gltf_write_fails_without_a_trace() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing").join("a.glb");
        let error = write_atomically(&missing, b"x").unwrap_err();
        assert!(error.to_string().contains("missing"), "{error}");
        let directory = folder.path().join("b.glb");
        fs::create_dir(&directory).unwrap();
        assert!(write_atomically(&directory, b"x").is_err());
        assert_eq!(names(folder.path()), ["b.glb"]);
    }

    #[cfg(unix)]
    #[test]
    fn gltf_write_gives_normal_permissions_and_keeps_existing_ones() {
        use std::os::unix::fs::PermissionsExt;

        let folder = tempfile::tempdir().unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        let path = folder.path().join("a.glb");
        let plain = folder.path().join("plain");
        fs::write(&plain, b"").unwrap();
        write_atomically(&path, b"x").unwrap();
        assert_eq!(mode(&path), mode(&plain));
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        write_atomically(&path, b"y").unwrap();
        assert_eq!(mode(&path), 0o640);
    }

    #[cfg(unix)]
    #[test]
    fn gltf_write_leaves_the_old_file_when_the_folder_is_read_only() {
        use std::os::unix::fs::PermissionsExt;

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        write_atomically(&path, b"old").unwrap();
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).unwrap();
        let written = write_atomically(&path, b"new");
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
        // The superuser may write anywhere; then the new file is whole.
        let expected: &[u8] = if written.is_err() { b"old" } else { b"new" };
        assert_eq!(fs::read(&path).unwrap(), expected);
        assert_eq!(names(folder.path()), ["a.glb"]);
    }

    #[cfg(unix)]
    #[test]
    fn gltf_write_follows_links_and_spares_devices() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        let link = folder.path().join("link.glb");
        fs::write(&path, b"old").unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        write_atomically(&link, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        write_atomically(Path::new("/dev/null"), b"x").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
