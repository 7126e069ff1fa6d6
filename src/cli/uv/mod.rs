//! `fresco uv`: texture coordinates for meshes that have none.
//!
//! ```text
//!   args ─► load meshes ─► project ─► write ─► summary
//! ```

mod args;
mod command;

pub(super) use args::{EXAMPLES, UvArgs};
pub(super) use command::uv_command;
