use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, EguiPlugin, EguiPrimaryContextPass, egui};

use super::notes::Notes;
use super::relief::Relief;
use super::results;
use super::scene::{Lights, Materials};
use super::settings;
use super::status;
use super::view::View;
use crate::plugin::radiosity::{RadiositySettings, RadiosityStatus};

/// Shows a [`FrescoPanel`] in a window of its own, over the camera that `bevy_egui` draws on. Adds its
/// `EguiPlugin` where it is missing.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrescoPanelPlugin;

/// Whether the window is open. F1 turns it over.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Resource, Debug, Clone, PartialEq)]
pub struct PanelOpen(pub bool);

impl Default for PanelOpen {
    fn default() -> Self {
        Self(true)
    }
}

impl Plugin for FrescoPanelPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<EguiPlugin>() {
            app.add_plugins(EguiPlugin::default());
        }
        app.register_type::<PanelOpen>()
            .init_resource::<PanelOpen>()
            .add_systems(EguiPrimaryContextPass, window);
    }
}

/// Of the window at first, in points.
const SIZE: [f32; 2] = [300.0, 560.0];

fn window(
    mut contexts: EguiContexts,
    mut panel: FrescoPanel,
    mut open: ResMut<PanelOpen>,
) -> Result {
    let context = contexts.ctx_mut()?;
    if context.input(|input| input.key_pressed(egui::Key::F1)) {
        open.0 = !open.0;
    }
    // Kept open by a copy: a change that is none would be one to whoever watches it.
    let mut still = open.0;
    egui::Window::new("Fresco")
        .open(&mut still)
        .default_size(SIZE)
        .default_pos([8.0, 8.0])
        .vscroll(true)
        .show(context, |ui| panel.show(ui));
    if still != open.0 {
        open.0 = still;
    }
    Ok(())
}

/// What the window shows, for windows of an application's own:
///
/// ```no_run
/// # use bevy::prelude::*;
/// # use bevy_egui::{EguiContexts, egui};
/// # use bevy_fresco::panel::FrescoPanel;
/// // In the schedule `EguiPrimaryContextPass`.
/// fn my_window(mut contexts: EguiContexts, mut panel: FrescoPanel) -> Result {
///     egui::Window::new("Mine").show(contexts.ctx_mut()?, |ui| panel.show(ui));
///     Ok(())
/// }
/// ```
#[derive(SystemParam)]
pub struct FrescoPanel<'w, 's> {
    commands: Commands<'w, 's>,
    status: Option<Res<'w, RadiosityStatus>>,
    settings: Option<ResMut<'w, RadiositySettings>>,
    lights: Lights<'w, 's>,
    materials: Materials<'w, 's>,
    relief: Relief<'w, 's>,
    notes: Notes<'w, 's>,
    view: View<'w>,
}

impl std::fmt::Debug for FrescoPanel<'_, '_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FrescoPanel").finish_non_exhaustive()
    }
}

impl FrescoPanel<'_, '_> {
    /// Draws it.
    pub fn show(&mut self, ui: &mut egui::Ui) {
        let Some(status) = self.status.as_deref() else {
            ui.label("No light is baked: add RadiosityPlugin.");
            self.relief.show(ui);
            return;
        };
        status::show(ui, status, &mut self.commands);
        self.view.show(ui);
        ui.separator();
        if let Some(settings) = &mut self.settings {
            section(ui, "Settings", false, |ui| settings::show(ui, settings));
        }
        section(ui, "Lights", false, |ui| self.lights.show(ui));
        section(ui, "Materials", false, |ui| self.materials.show(ui));
        if let Some(report) = &status.report {
            section(ui, "Result", true, |ui| {
                results::show(ui, report, status.bytes);
            });
        }
        self.relief.show(ui);
        self.notes.show(ui, status.report.as_deref());
    }
}

/// A part with a heading that folds it.
pub(super) fn section(
    ui: &mut egui::Ui,
    title: &str,
    open: bool,
    content: impl FnOnce(&mut egui::Ui),
) {
    egui::CollapsingHeader::new(title)
        .default_open(open)
        .show(ui, content);
}
