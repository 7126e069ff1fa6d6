use std::collections::BTreeMap;

use bevy::ecs::system::SystemParam;
use bevy::light::RectLight;
use bevy::prelude::*;
use bevy_egui::egui;

use crate::plugin::FrescoMaterial;
use crate::plugin::radiosity::{LightBaking, OriginalMaterial, StaticLighting};

type Own = (Entity, Option<&'static Name>, Option<&'static LightBaking>);

/// Lights of the scene, of which colour and strength can be changed and whether they are baked.
#[derive(SystemParam)]
pub(super) struct Lights<'w, 's> {
    commands: Commands<'w, 's>,
    points: Query<'w, 's, (Own, &'static mut PointLight)>,
    spots: Query<'w, 's, (Own, &'static mut SpotLight)>,
    suns: Query<'w, 's, (Own, &'static mut DirectionalLight)>,
    rects: Query<'w, 's, (Own, &'static mut RectLight)>,
}

/// A light as it is edited.
#[derive(Clone, Copy, PartialEq)]
struct Edited {
    color: Color,
    strength: f32,
}

impl Lights<'_, '_> {
    pub(super) fn show(&mut self, ui: &mut egui::Ui) {
        let commands = &mut self.commands;
        let mut any = false;
        macro_rules! each {
            ($query:expr, $kind:literal, $strength:ident, $unit:literal) => {
                for (own, mut light) in &mut $query {
                    any = true;
                    let before = Edited {
                        color: light.color,
                        strength: light.$strength,
                    };
                    let after = edit(ui, commands, own, $kind, before, $unit);
                    if after != before {
                        light.color = after.color;
                        light.$strength = after.strength;
                    }
                }
            };
        }
        each!(self.points, "point light", intensity, " lm");
        each!(self.spots, "spot light", intensity, " lm");
        each!(self.suns, "directional light", illuminance, " lx");
        each!(self.rects, "rectangular light", intensity, " lm");
        if !any {
            ui.label("There are none: surfaces may still emit, and the sky shine.");
        }
    }
}

fn edit(
    ui: &mut egui::Ui,
    commands: &mut Commands,
    (entity, name, baking): (Entity, Option<&Name>, Option<&LightBaking>),
    kind: &str,
    light: Edited,
    unit: &str,
) -> Edited {
    let name = name.map_or_else(|| format!("{kind} {entity}"), ToString::to_string);
    let mut edited = light;
    ui.horizontal(|ui| {
        edited.color = color_of(ui, light.color);
        let speed = 0.01 * light.strength.max(1.0);
        let drag = egui::DragValue::new(&mut edited.strength).range(0.0..=f32::MAX);
        ui.add(drag.speed(speed).suffix(unit));
        let baking = baking.copied().unwrap_or_default();
        egui::ComboBox::from_id_salt(entity)
            .selected_text(told(baking))
            .show_ui(ui, |ui| {
                for other in [
                    LightBaking::Indirect,
                    LightBaking::Full,
                    LightBaking::Excluded,
                ] {
                    let is_it = other == baking;
                    if ui.selectable_label(is_it, told(other)).clicked() && !is_it {
                        commands.entity(entity).insert(other);
                    }
                }
            });
        ui.label(name);
    });
    edited
}

fn told(baking: LightBaking) -> &'static str {
    match baking {
        LightBaking::Indirect => "bounces baked",
        LightBaking::Full => "all baked",
        LightBaking::Excluded => "not baked",
    }
}

/// A button with a colour to choose. What is not touched stays to the bit.
fn color_of(ui: &mut egui::Ui, color: Color) -> Color {
    let linear = color.to_linear();
    // Hues are chosen in 0 to 1; brighter ones keep their strength.
    let strength = linear.red.max(linear.green).max(linear.blue).max(1.0);
    let mut rgb = [linear.red, linear.green, linear.blue].map(|channel| channel / strength);
    if ui.color_edit_button_rgb(&mut rgb).changed() {
        let [red, green, blue] = rgb.map(|channel| channel * strength);
        return LinearRgba::new(red, green, blue, linear.alpha).into();
    }
    color
}

type HasMaterial = (
    Option<&'static Name>,
    Option<&'static OriginalMaterial>,
    Option<&'static MeshMaterial3d<FrescoMaterial>>,
    Option<&'static MeshMaterial3d<StandardMaterial>>,
);

/// Materials of static entities, of which colour and emission can be changed.
#[derive(SystemParam)]
pub(super) struct Materials<'w, 's> {
    entities: Query<'w, 's, HasMaterial, With<StaticLighting>>,
    standard: Option<ResMut<'w, Assets<StandardMaterial>>>,
    extended: Option<ResMut<'w, Assets<FrescoMaterial>>>,
}

/// One of either kind.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Id {
    Standard(AssetId<StandardMaterial>),
    Extended(AssetId<FrescoMaterial>),
}

impl Materials<'_, '_> {
    pub(super) fn show(&mut self, ui: &mut egui::Ui) {
        // By the first entity that has it: materials have no names.
        let mut materials: BTreeMap<Id, Option<&Name>> = BTreeMap::new();
        for (name, original, extended, standard) in &self.entities {
            let id = match (original, extended, standard) {
                (Some(original), ..) => Id::Standard(original.handle.id()),
                (None, Some(extended), _) => Id::Extended(extended.id()),
                (None, None, Some(standard)) => Id::Standard(standard.id()),
                (None, None, None) => continue,
            };
            materials.entry(id).or_insert(name);
        }
        if materials.is_empty() {
            ui.label("No entity is static.");
        }
        for (number, (id, name)) in (1..).zip(materials) {
            let label =
                name.map_or_else(|| format!("material {number}"), |name| format!("of {name}"));
            match id {
                Id::Standard(id) => {
                    let Some(materials) = &mut self.standard else {
                        continue;
                    };
                    let Some(before) = materials.get(id) else {
                        continue;
                    };
                    if let Some(after) = edit_material(ui, &label, before)
                        && let Some(mut material) = materials.get_mut(id)
                    {
                        (material.base_color, material.emissive) = after;
                    }
                }
                Id::Extended(id) => {
                    let Some(materials) = &mut self.extended else {
                        continue;
                    };
                    let Some(before) = materials.get(id) else {
                        continue;
                    };
                    if let Some(after) = edit_material(ui, &label, &before.base)
                        && let Some(mut material) = materials.get_mut(id)
                    {
                        (material.base.base_color, material.base.emissive) = after;
                    }
                }
            }
        }
    }
}

/// The colour and the emission if they were changed.
fn edit_material(
    ui: &mut egui::Ui,
    label: &str,
    material: &StandardMaterial,
) -> Option<(Color, LinearRgba)> {
    let before = (material.base_color, material.emissive);
    let (mut color, mut emissive) = before;
    ui.horizontal(|ui| {
        color = color_of(ui, color);
        let strength = emissive.red.max(emissive.green).max(emissive.blue);
        let mut edited = strength;
        let drag = egui::DragValue::new(&mut edited)
            .range(0.0..=f32::MAX)
            .prefix("emits ");
        if ui.add(drag.speed(0.01 * strength.max(1.0))).changed() {
            let alpha = emissive.alpha;
            emissive = match strength > 0.0 {
                true => emissive * (edited / strength),
                false => LinearRgba::rgb(edited, edited, edited),
            };
            emissive.alpha = alpha;
        }
        ui.label(label);
    });
    ((color, emissive) != before).then_some((color, emissive))
}
