//! The panel in a context of egui without a window: what it shows is read from the text it draws, and clicks go
//! to where that stands.

use bevy::ecs::system::SystemState;
use bevy::prelude::*;
use bevy_egui::egui;

use super::FrescoPanel;
use crate::plugin::FrescoView;
use crate::plugin::radiosity::{
    BakeState, CancelBake, NotBaked, RadiositySettings, RadiosityStatus, Rebake, StaticLighting,
};
use crate::radiosity::{BakeSettings, Report, Stage};

#[derive(Resource, Default)]
struct Asked {
    rebakes: Vec<bool>,
    cancels: u32,
}

/// A world with a panel, and the context that it is drawn in.
struct Desk {
    world: World,
    context: egui::Context,
    /// Text that was drawn, and where.
    texts: Vec<(String, egui::Rect)>,
}

impl Desk {
    fn new() -> Self {
        let mut world = World::new();
        world.init_resource::<RadiosityStatus>();
        world.init_resource::<RadiositySettings>();
        world.init_resource::<Asked>();
        world.init_resource::<FrescoView>();
        world.init_resource::<Assets<StandardMaterial>>();
        world.add_observer(|rebake: On<Rebake>, mut asked: ResMut<Asked>| {
            asked.rebakes.push(rebake.from_scratch);
        });
        world.add_observer(|_: On<CancelBake>, mut asked: ResMut<Asked>| asked.cancels += 1);
        let mut desk = Self {
            world,
            context: egui::Context::default(),
            texts: Vec::new(),
        };
        // The first frames find out how large things are.
        for _ in 0..3 {
            desk.draw(Vec::new());
        }
        desk
    }

    fn draw(&mut self, events: Vec<egui::Event>) {
        self.world.clear_trackers();
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(
                egui::Pos2::ZERO,
                egui::vec2(600.0, 2000.0),
            )),
            events,
            ..default()
        };
        let mut state = SystemState::<FrescoPanel>::new(&mut self.world);
        let mut output = {
            let mut panel = state
                .get_mut(&mut self.world)
                .expect("its parameters are there");
            self.context.run_ui(input, |ui| panel.show(ui))
        };
        state.apply(&mut self.world);
        // Nobody draws them.
        output.textures_delta.clear();
        self.texts.clear();
        for shape in output.shapes {
            collect(&shape.shape, &mut self.texts);
        }
    }

    fn shows(&self, text: &str) -> bool {
        self.texts.iter().any(|(drawn, _)| drawn.contains(text))
    }

    /// Clicks on the text that is just this.
    fn click(&mut self, text: &str) {
        let found = self.texts.iter().find(|(drawn, _)| drawn == text);
        let at = found.unwrap_or_else(|| panic!("no {text}")).1.center();
        let button = |pressed| egui::Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        };
        self.draw(vec![egui::Event::PointerMoved(at)]);
        self.draw(vec![button(true)]);
        self.draw(vec![button(false)]);
        self.draw(vec![egui::Event::PointerGone]);
        // What unfolds takes its time.
        for _ in 0..30 {
            self.draw(Vec::new());
        }
    }

    fn settings(&self) -> &RadiositySettings {
        self.world.resource()
    }
}

fn collect(shape: &egui::Shape, texts: &mut Vec<(String, egui::Rect)>) {
    match shape {
        egui::Shape::Text(text) => {
            texts.push((text.galley.text().to_owned(), text.visual_bounding_rect()));
        }
        egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect(shape, texts)),
        _ => {}
    }
}

/// With everything unfolded and left alone, no setting, light or material counts as changed.
#[test]
fn an_open_panel_changes_nothing() {
    let mut desk = Desk::new();
    let material = StandardMaterial {
        base_color: Color::hsl(200.0, 0.3, 0.4),
        emissive: LinearRgba::rgb(3.0, 2.0, 0.1),
        ..default()
    };
    let material = desk
        .world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(material);
    desk.world
        .spawn((StaticLighting::default(), MeshMaterial3d(material)));
    let light = PointLight {
        color: Color::srgb(0.91, 0.4, 0.3),
        ..default()
    };
    let light = desk.world.spawn(light).id();
    for heading in ["Settings", "Lights", "Materials"] {
        desk.click(heading);
    }
    assert!(desk.shows("bounces baked") && desk.shows("emits") && desk.shows("Seed"));
    let settings = desk.settings().clone();
    let before = desk.world.read_change_tick();
    desk.world.increment_change_tick();
    for _ in 0..10 {
        desk.draw(Vec::new());
    }
    let now = desk.world.read_change_tick();
    let changed = desk
        .world
        .resource_ref::<RadiositySettings>()
        .last_changed();
    assert!(!changed.is_newer_than(before, now));
    let light = desk
        .world
        .entity(light)
        .get_ref::<PointLight>()
        .expect("it is there");
    assert!(!light.last_changed().is_newer_than(before, now));
    let materials = desk
        .world
        .resource_ref::<Assets<StandardMaterial>>()
        .last_changed();
    assert!(!materials.is_newer_than(before, now));
    assert_eq!(*desk.settings(), settings);
}

#[test]
fn a_click_on_a_preset_takes_it() {
    let mut desk = Desk::new();
    desk.click("Settings");
    desk.click("Final");
    assert_eq!(desk.settings().bake, BakeSettings::FINAL);
    desk.click("Bake when something changes");
    assert!(!desk.settings().automatic);
}

#[test]
fn another_view_is_chosen_from_a_list() {
    let mut desk = Desk::new();
    desk.click("Shaded");
    desk.click("Sampling error");
    let view = *desk.world.resource::<FrescoView>();
    assert_eq!(view, FrescoView::Error);
    assert!(desk.shows("green: as asked"));
}

#[test]
fn buttons_rebake_and_cancel() {
    let mut desk = Desk::new();
    desk.click("Rebake");
    desk.click("From scratch");
    desk.click("Cancel");
    let asked = desk.world.resource::<Asked>();
    // There is nothing to cancel.
    assert_eq!(
        (asked.rebakes.as_slice(), asked.cancels),
        (&[false, true][..], 0)
    );
    desk.world.resource_mut::<RadiosityStatus>().state = BakeState::Baking {
        stage: Some(Stage::Gather),
        done: 0.5,
    };
    desk.draw(Vec::new());
    assert!(desk.shows(Stage::Gather.name()));
    desk.click("Cancel");
    assert_eq!(desk.world.resource::<Asked>().cancels, 1);
}

#[test]
fn what_went_wrong_is_told() {
    let mut desk = Desk::new();
    assert!(desk.shows("no entity has StaticLighting"));
    let report = Report {
        notes: vec!["The lamp faces the wall.".into()],
        ..default()
    };
    let mut status = desk.world.resource_mut::<RadiosityStatus>();
    status.state = BakeState::Stopped;
    status.error = Some("it needs more memory".into());
    status.report = Some(std::sync::Arc::new(report));
    let problem = NotBaked {
        reason: "it has no normals".into(),
    };
    desk.world.spawn((Name::new("Vase"), problem));
    for _ in 0..30 {
        desk.draw(Vec::new());
    }
    for text in [
        "it needs more memory",
        "The lamp faces the wall.",
        "Vase is not lit: it has no normals",
        "Notes (2)",
    ] {
        assert!(desk.shows(text), "{text}: {:?}", desk.texts);
    }
}
