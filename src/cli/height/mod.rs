//! `fresco height`: image files in and out of [`height_map`](crate::height_map).
//!
//! ```text
//!   args ─► read ─► prepare ─► encode maps, draw preview ─► write all ─► summary
//! ```

mod args;
mod command;
mod exr_file;
mod preview;
mod read;
mod summary;
mod write;

pub(super) use args::{EXAMPLES, HeightArgs, KernelArg};
pub(super) use command::height_command;
pub(super) use read::{ImageFile, decode, read};
