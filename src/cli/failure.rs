use std::fmt::Display;
use std::io::{self, Write};
use std::process::ExitCode;

use crate::gltf::GltfError;
use crate::radiosity::{BakeError, SceneError};

/// Why a run ended early.
#[derive(Debug)]
pub(super) enum Failure {
    /// The arguments make no sense, or ask for help.
    Usage(clap::Error),
    /// Somebody stopped it.
    Cancelled,
    /// One line that names the thing and the cure.
    Error(String),
    /// Nobody reads the output any more.
    Closed,
}

/// As shells have it for a program ended by Ctrl-C.
const CANCELLED: u8 = 130;

impl Failure {
    pub(super) fn error(message: impl Display) -> Self {
        Self::Error(message.to_string())
    }

    /// Says what is wrong and gives the exit code.
    pub(super) fn tell(&self, out: &mut dyn Write, err: &mut dyn Write) -> ExitCode {
        // An error that cannot be shown has no better place to go.
        match self {
            Self::Usage(usage) => {
                let text = usage.render();
                if usage.use_stderr() {
                    write!(err, "{text}").ok();
                } else {
                    write!(out, "{text}").ok();
                }
                ExitCode::from(usage.exit_code() as u8)
            }
            Self::Cancelled => {
                writeln!(err, "stopped: nothing was written").ok();
                ExitCode::from(CANCELLED)
            }
            Self::Error(message) => {
                writeln!(err, "error: {}", message.replace('\n', " ")).ok();
                ExitCode::FAILURE
            }
            Self::Closed => ExitCode::FAILURE,
        }
    }
}

impl From<GltfError> for Failure {
    fn from(error: GltfError) -> Self {
        Self::error(error)
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::error(error)
    }
}

impl From<BakeError> for Failure {
    fn from(error: BakeError) -> Self {
        match error {
            BakeError::Cancelled => Self::Cancelled,
            other => Self::error(other),
        }
    }
}

impl From<io::Error> for Failure {
    /// Only the terminal is written to without a path to name.
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe {
            Self::Closed
        } else {
            Self::Error(format!("cannot write to the terminal: {error}"))
        }
    }
}
