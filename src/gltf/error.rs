use std::path::PathBuf;

/// Why a glTF file could not be read or written. Each message names the thing and the cure.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GltfError {
    /// A file could not be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file could not be written; what was there before is untouched.
    #[error("cannot write {path}: {source}")]
    Write {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not glTF, is cut short, or contradicts itself.
    #[error("{path} is not valid glTF: {reason}")]
    Invalid {
        /// Which file.
        path: PathBuf,
        /// Where in the file and what is wrong.
        reason: String,
    },
    /// The file says it cannot be understood without an extension that is not supported.
    #[error(
        "{path} requires the extension {extension}, which is not supported: export it without \
         (compressed meshes: export uncompressed)"
    )]
    UnsupportedExtension {
        /// Which file.
        path: PathBuf,
        /// The extension's name.
        extension: String,
    },
    /// The baked light cannot be written into the file.
    #[error("cannot export {path} with its light: {reason}")]
    Export {
        /// Which file the scene came from.
        path: PathBuf,
        /// What does not fit.
        reason: String,
    },
}
