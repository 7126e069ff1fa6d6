//! The command line: `fresco bake`, `fresco info`, `fresco height`, `fresco displace` and `fresco uv`.
//!
//! ```text
//!   args ─► load ─► validate ─► memory ─► bake ─► export, picture, report ─► write all ─► summary
//! ```
//!
//! Nothing is written before everything is done: a bake that fails or is stopped leaves what was
//! there. Results go to standard output, progress and errors to standard error.

mod args;
mod bake;
mod displace;
mod failure;
mod height;
mod info;
mod memory;
mod meshes;
mod method;
mod outputs;
mod picture;
mod progress;
mod report;
mod scene;
mod summary;
mod uv;

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Parser;

use self::args::{Cli, Command};
use self::failure::Failure;

/// What surrounds a run.
#[derive(Clone, Debug, Default)]
pub struct Session {
    /// Set it to stop the run soon; it then leaves no file.
    pub cancel: Arc<AtomicBool>,
    /// Whether to draw progress bars on the terminal.
    pub bars: bool,
}

/// Runs the command line with nothing around it: no progress bars, no way to stop.
///
/// The first of `args` is the program's name.
///
/// ```
/// use bevy_fresco::cli::run;
///
/// let (mut out, mut err) = (Vec::new(), Vec::new());
/// run(["fresco".into(), "--version".into()], &mut out, &mut err);
/// assert!(out.starts_with(b"fresco "));
/// ```
pub fn run(
    args: impl IntoIterator<Item = OsString>,
    out: &mut dyn Write,
    err: &mut dyn Write,
) -> ExitCode {
    run_in(&Session::default(), args, out, err)
}

/// Runs the command line.
///
/// The exit code is 0 if all went well, 1 for an error, 2 for wrong usage and 130 if it was
/// stopped. Errors are one line on `err` that names the thing and the cure.
pub fn run_in(
    session: &Session,
    args: impl IntoIterator<Item = OsString>,
    out: &mut dyn Write,
    err: &mut dyn Write,
) -> ExitCode {
    let result = Cli::try_parse_from(args)
        .map_err(Failure::Usage)
        .and_then(|cli| match cli.command {
            Command::Bake(args) => bake::bake_command(session, &args, out),
            Command::Info(args) => info::info_command(session, &args, out),
            Command::Height(args) => height::height_command(session, &args, out),
            Command::Displace(args) => displace::displace_command(session, &args, out),
            Command::Uv(args) => uv::uv_command(session, &args, out),
        });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.tell(out, err),
    }
}
