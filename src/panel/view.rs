use bevy::ecs::system::SystemParam;
use bevy::pbr::wireframe::WireframeConfig;
use bevy::prelude::*;
use bevy_egui::egui;

use crate::plugin::FrescoView;
use crate::plugin::radiosity::RadiosityGizmos;

/// What surfaces show, and whether the edges of their triangles are drawn, where the application has the plugin for it.
#[derive(SystemParam)]
pub(super) struct View<'w> {
    view: Option<ResMut<'w, FrescoView>>,
    wireframe: Option<ResMut<'w, WireframeConfig>>,
    gizmos: Option<ResMut<'w, RadiosityGizmos>>,
}

impl View<'_> {
    pub(super) fn show(&mut self, ui: &mut egui::Ui) {
        if let Some(view) = &mut self.view {
            choose(ui, view);
        }
        if let Some(config) = &mut self.wireframe {
            let mut global = config.global;
            ui.checkbox(&mut global, "Edges of triangles");
            if global != config.global {
                config.global = global;
            }
        }
        if let Some(gizmos) = &mut self.gizmos {
            lines(ui, gizmos);
        }
    }
}

fn lines(ui: &mut egui::Ui, gizmos: &mut ResMut<RadiosityGizmos>) {
    let mut edited = **gizmos;
    ui.horizontal(|ui| {
        ui.checkbox(&mut edited.elements, "Elements");
        ui.checkbox(&mut edited.contacts, "Contacts");
    });
    let has_factors = edited.form_factors.is_some();
    let mut shows_factors = has_factors;
    ui.horizontal(|ui| {
        let asked = "Of one element: the application says which, by RadiosityGizmos";
        let factors = egui::Checkbox::new(&mut shows_factors, "Form factors");
        ui.add_enabled(has_factors, factors)
            .on_disabled_hover_text(asked);
        let hemicube = egui::Checkbox::new(&mut edited.hemicube, "Hemicube");
        ui.add_enabled(has_factors, hemicube);
    });
    if !shows_factors {
        edited.form_factors = None;
    }
    gizmos.set_if_neq(edited);
}

fn choose(ui: &mut egui::Ui, view: &mut ResMut<FrescoView>) {
    let mut chosen = **view;
    let name = FrescoView::ALL.iter().find(|(view, _)| *view == chosen);
    egui::ComboBox::from_label("View")
        .selected_text(name.map_or("", |(_, name)| name))
        .show_ui(ui, |ui| {
            for (view, name) in FrescoView::ALL {
                ui.selectable_value(&mut chosen, view, name);
            }
        });
    if let Some(legend) = legend(chosen) {
        ui.weak(legend);
    }
    view.set_if_neq(chosen);
}

fn legend(view: FrescoView) -> Option<&'static str> {
    match view {
        FrescoView::Error => Some("blue: none, green: as asked, red: four times as much"),
        FrescoView::Samples => Some("green: the mean, blue: an eighth, red: eight times as many"),
        FrescoView::Sources => {
            Some("grey: sampled, yellow: filled from neighbours, red: inside geometry, black")
        }
        FrescoView::Elements => Some("light that arrives at each, every other one darker"),
        _ => None,
    }
}
