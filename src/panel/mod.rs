//! A window of [`egui`](bevy_egui::egui): how the bake gets on and how good it is, and the settings, lights and
//! materials that it goes by, to be changed while it runs.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_fresco::panel::FrescoPanelPlugin;
//! use bevy_fresco::plugin::FrescoPlugins;
//!
//! App::new()
//!     .add_plugins((DefaultPlugins, FrescoPlugins, FrescoPanelPlugin))
//!     .run();
//! ```
//!
//! F1 opens and closes it. An application with windows of its own leaves the plugin out and puts a [`FrescoPanel`]
//! where it likes.
//!
//! Everything is edited in a copy that is written back when it differs: a panel that is open and left alone
//! changes nothing, and so starts no bake.
//!
//! | file | section |
//! |---|---|
//! | `status` | what is being done, how far, and the buttons |
//! | `view` | what surfaces show |
//! | `settings` | how the bake is done |
//! | `scene` | lights and materials |
//! | `results` | times, errors, the solver's residuals, memory |
//! | `relief` | displaced meshes |
//! | `notes` | what was left out and why |

mod notes;
mod plugin;
mod relief;
mod results;
mod scene;
mod settings;
mod status;
mod view;

pub use plugin::{FrescoPanel, FrescoPanelPlugin, PanelOpen};

#[cfg(test)]
mod panel_test;
