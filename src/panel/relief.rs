use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui;

use super::plugin::section;
use crate::displacement::Stop;
use crate::plugin::displacement::{Displacement, DisplacementStatus};
use crate::text::{bytes, count, percent, short};

type Displaced = (Entity, Option<&'static Name>, &'static DisplacementStatus);

/// Displaced meshes.
#[derive(SystemParam)]
pub(super) struct Relief<'w, 's> {
    displaced: Query<'w, 's, Displaced, With<Displacement>>,
}

impl Relief<'_, '_> {
    pub(super) fn show(&self, ui: &mut egui::Ui) {
        if self.displaced.is_empty() {
            return;
        }
        section(ui, "Displaced meshes", false, |ui| {
            for (entity, name, status) in &self.displaced {
                let name = name.map_or_else(|| entity.to_string(), ToString::to_string);
                ui.label(format!("{name}: {}", told(status)));
            }
        });
    }
}

fn told(status: &DisplacementStatus) -> String {
    let report = match status {
        DisplacementStatus::Idle => return "not looked at yet".into(),
        DisplacementStatus::Loading => return "loading".into(),
        DisplacementStatus::Working { stage, done } => {
            return format!("{stage}, {}", percent(f64::from(*done)));
        }
        DisplacementStatus::Failed(problem) => return problem.to_string(),
        DisplacementStatus::Done(report) => report,
    };
    let mut text = format!(
        "{} triangles, {}",
        count(report.triangles),
        bytes(report.bytes)
    );
    if let Some(error) = report.error {
        text += &format!(", off by {} mm at most", short(1e3 * f64::from(error)));
    }
    text += match report.stop {
        Stop::Reached => "",
        Stop::Triangles => " (no more triangles allowed)",
        Stop::Memory => " (no more memory allowed)",
        Stop::Finest => " (as fine as it gets)",
    };
    text
}
