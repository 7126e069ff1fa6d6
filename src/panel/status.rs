use bevy::prelude::*;
use bevy_egui::egui;

use crate::plugin::radiosity::{BakeState, CancelBake, RadiosityStatus, Rebake};
use crate::radiosity::Stage;

/// What is being done, how far, and the buttons.
pub(super) fn show(ui: &mut egui::Ui, status: &RadiosityStatus, commands: &mut Commands) {
    let (text, done) = told(status.state);
    match done {
        Some(done) => {
            ui.add(egui::ProgressBar::new(done).text(text));
            // Others drawn only on input would show it late.
            ui.ctx().request_repaint();
        }
        None => {
            ui.label(text);
        }
    }
    if let Some(error) = &status.error {
        ui.colored_label(ui.visuals().error_fg_color, error);
    }
    ui.horizontal(|ui| {
        let is_baking = matches!(status.state, BakeState::Baking { .. });
        if ui
            .add_enabled(is_baking, egui::Button::new("Cancel"))
            .clicked()
        {
            commands.trigger(CancelBake);
        }
        let rebake = ui.button("Rebake");
        if rebake.on_hover_text("Does again what changed").clicked() {
            commands.trigger(Rebake::default());
        }
        let anew = ui.button("From scratch");
        let told = "Forgets what earlier bakes found, the meshes they chose included";
        if anew.on_hover_text(told).clicked() {
            commands.trigger(Rebake { from_scratch: true });
        }
    });
}

/// In words, and the share that is done.
fn told(state: BakeState) -> (String, Option<f32>) {
    match state {
        BakeState::Idle => ("Nothing to bake: no entity has StaticLighting".into(), None),
        BakeState::Changed => ("Something changed".into(), None),
        BakeState::Loading => ("Loading".into(), None),
        BakeState::Baking { stage, done } => {
            let stage = stage.map_or("starting", Stage::name);
            (stage.into(), Some(done))
        }
        BakeState::Applying => ("Putting light into meshes".into(), None),
        BakeState::UpToDate => ("Up to date".into(), None),
        BakeState::Stopped => ("Stopped: the light is that of the bake before".into(), None),
    }
}
