//! The `fresco` command.

use std::io::{self, IsTerminal};
use std::process::{ExitCode, exit};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use bevy_fresco::cli::{Session, run_in};

fn main() -> ExitCode {
    let session = Session {
        bars: io::stderr().is_terminal(),
        ..Session::default()
    };
    let cancel = Arc::clone(&session.cancel);
    // Without a handler Ctrl-C ends the program as ever; files are whole either way.
    ctrlc::set_handler(move || {
        if cancel.swap(true, Ordering::Relaxed) {
            exit(130);
        }
    })
    .ok();
    // Not locked: the progress bars draw from other threads.
    run_in(
        &session,
        std::env::args_os(),
        &mut io::stdout(),
        &mut io::stderr(),
    )
}
