use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui;

use super::plugin::section;
use crate::plugin::radiosity::NotBaked;
use crate::radiosity::Report;

/// What was left out, and why.
#[derive(SystemParam)]
pub(super) struct Notes<'w, 's> {
    not_baked: Query<'w, 's, (Entity, Option<&'static Name>, &'static NotBaked)>,
}

impl Notes<'_, '_> {
    pub(super) fn show(&self, ui: &mut egui::Ui, report: Option<&Report>) {
        let notes = report.map_or(&[][..], |report| &report.notes);
        let number = self.not_baked.iter().len() + notes.len();
        if number == 0 {
            return;
        }
        section(ui, &format!("Notes ({number})"), true, |ui| {
            for (entity, name, problem) in &self.not_baked {
                let name = name.map_or_else(|| entity.to_string(), ToString::to_string);
                ui.label(format!("{name} is not lit: {}", problem.reason));
            }
            for note in notes {
                ui.label(note);
            }
        });
    }
}
