//! `fresco displace`: glTF meshes in and out of [`displacement`](crate::displacement).
//!
//! ```text
//!   args ─► load meshes, read maps ─► displace each mesh ─► write ─► summary
//! ```

mod args;
mod command;
mod relief;
mod summary;

pub(super) use args::{DisplaceArgs, EXAMPLES};
pub(super) use command::displace_command;
