//! One Bevy app without a window, on a thread of its own, that takes pictures for all tests.
//!
//! A renderer takes seconds to start without a GPU, hence one for all. The app cannot leave its
//! thread, hence tests send what they want done to it.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, OnceLock};
use std::thread;

use bevy::asset::RenderAssetUsages;
use bevy::camera::{ClearColorConfig, Exposure, Hdr, RenderTarget};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::log::tracing::{self, Level, Subscriber, field};
use bevy::log::tracing_subscriber::{Layer, layer};
use bevy::log::{BoxedLayer, LogPlugin};
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{PipelineCache, TextureFormat, TextureUsages};
use bevy::render::{RenderPlugin, view::Msaa};
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy_fresco::plugin::{
    DisplacementPlugin, FrescoMaterial, FrescoMaterialPlugin, FrescoView, RadiosityPlugin,
    ShownInstead,
};

use crate::bumps::PrepassNormals;
use crate::picture::Picture;

/// Pixels on a side of pictures, if nothing else is said.
pub(crate) const SIZE: u32 = 64;

/// What pixels are multiplied by: a camera's default exposure.
pub(crate) fn exposure() -> f32 {
    Exposure::default().exposure()
}

static ERRORS: Mutex<Vec<String>> = Mutex::new(Vec::new());
static WARNINGS: Mutex<Vec<String>> = Mutex::new(Vec::new());

type Job = Box<dyn FnOnce(&mut Stage) + Send>;

/// Does `work` on the stage and gives back what it gives, or panics as it does.
pub(crate) fn on_stage<R: Send + 'static>(
    work: impl FnOnce(&mut Stage) -> R + Send + 'static,
) -> R {
    static STAGE: OnceLock<Mutex<Sender<Job>>> = OnceLock::new();
    let jobs = STAGE.get_or_init(|| {
        let (sender, receiver) = channel::<Job>();
        thread::spawn(move || {
            let mut stage = Stage::new();
            for job in receiver {
                job(&mut stage);
            }
        });
        Mutex::new(sender)
    });
    let (sender, receiver) = channel::<Result<R, Box<dyn Any + Send>>>();
    let job: Job = Box::new(move |stage| {
        let done = catch_unwind(AssertUnwindSafe(|| work(stage)));
        stage.show_view(FrescoView::Shaded);
        stage.clear();
        stage.size = SIZE;
        stage.expected_errors = &[];
        stage.shown = ShownInstead::Nothing;
        let _ = sender.send(done);
    });
    jobs.lock().unwrap().send(job).unwrap();
    match receiver.recv().expect("the stage could not be set up") {
        Ok(result) => result,
        Err(panic) => resume_unwind(panic),
    }
}

/// The app and the last picture it took.
pub(crate) struct Stage {
    app: App,
    /// Pixels on a side of the next pictures.
    pub(crate) size: u32,
    /// Errors that are logged with one of these in them are meant to be.
    pub(crate) expected_errors: &'static [&'static str],
    /// What materials of the next pictures show in the place of their look.
    shown: ShownInstead,
}

#[derive(Resource, Default)]
struct Frames(Vec<Vec<u8>>);

impl Stage {
    fn new() -> Self {
        let mut app = App::new();
        app.add_plugins((
            DefaultPlugins
                .set(WindowPlugin {
                    primary_window: None,
                    exit_condition: ExitCondition::DontExit,
                    ..default()
                })
                .set(RenderPlugin {
                    synchronous_pipeline_compilation: true,
                    ..default()
                })
                .set(LogPlugin {
                    level: Level::WARN,
                    custom_layer: |_| Some(Box::new(KeepErrors) as BoxedLayer),
                    ..default()
                })
                .disable::<WinitPlugin>()
                .disable::<PipelinedRenderingPlugin>(),
            FrescoMaterialPlugin,
            DisplacementPlugin,
            RadiosityPlugin::default(),
            MaterialPlugin::<PrepassNormals>::default(),
        ))
        .init_resource::<Frames>()
        .add_observer(|frame: On<ReadbackComplete>, mut frames: ResMut<Frames>| {
            frames.0.push(frame.data.clone());
        });
        app.finish();
        app.cleanup();
        // Puts the shaders into their place.
        app.update();
        Self {
            app,
            size: SIZE,
            expected_errors: &[],
            shown: ShownInstead::Nothing,
        }
    }

    /// Whether our shaders show normals, and the roughness as alpha, in the place of light.
    pub(crate) fn show_normals(&mut self, show: bool) {
        self.shown = match show {
            true => ShownInstead::RawNormals,
            false => ShownInstead::Nothing,
        };
    }

    /// Has surfaces show something else than their look.
    pub(crate) fn show_view(&mut self, view: FrescoView) {
        self.app
            .world_mut()
            .resource_mut::<FrescoView>()
            .set_if_neq(view);
    }

    /// Has our shaders show what parallax shifts texture coordinates by, the depth of what is seen, and as alpha how
    /// many texels were read to find it.
    pub(crate) fn show_parallax(&mut self) {
        self.shown = ShownInstead::RawParallax;
    }

    /// Has materials show what the picture is of. Of a view the plugin takes care.
    fn set_materials(&mut self) {
        let world = self.app.world_mut();
        if *world.resource::<FrescoView>() != FrescoView::Shaded {
            return;
        }
        let mut materials = world.resource_mut::<Assets<FrescoMaterial>>();
        for (_, material) in materials.iter_mut() {
            material.extension.instead = self.shown;
        }
    }

    /// What was warned of since the last picture was begun.
    pub(crate) fn warnings(&self) -> Vec<String> {
        WARNINGS.lock().unwrap().clone()
    }

    /// The app, as the last picture left it.
    pub(crate) fn app(&self) -> &App {
        &self.app
    }

    /// Its world.
    pub(crate) fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// What the camera sees, from 3 m in front of the origin, of what `scene` puts there: black
    /// where there is nothing, and alpha 0.
    pub(crate) fn shoot(
        &mut self,
        camera: impl FnOnce(&mut EntityWorldMut),
        scene: impl FnOnce(&mut World),
    ) -> Picture {
        self.clear();
        ERRORS.lock().unwrap().clear();
        WARNINGS.lock().unwrap().clear();
        let size = self.size;
        let world = self.app.world_mut();
        world.insert_resource(GlobalAmbientLight::NONE);
        let target = {
            let mut image = Image::new_target_texture(size, size, TextureFormat::Rgba32Float, None);
            image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
            image.asset_usage = RenderAssetUsages::all();
            world.resource_mut::<Assets<Image>>().add(image)
        };
        let mut eye = world.spawn((
            Camera3d::default(),
            Camera {
                clear_color: ClearColorConfig::Custom(Color::NONE),
                ..default()
            },
            Projection::from(PerspectiveProjection {
                fov: 2.0 * (1.0_f32 / 3.0).atan(),
                ..default()
            }),
            RenderTarget::from(target.clone()),
            Transform::from_xyz(0.0, 0.0, 3.0),
            Tonemapping::None,
            Msaa::Off,
            Hdr,
        ));
        camera(&mut eye);
        scene(world);
        self.set_materials();
        let world = self.app.world_mut();
        world.spawn((Readback::texture(target), Transform::default()));
        self.wait_for_a_still_frame()
    }

    /// What the camera sees after a change of what is there.
    pub(crate) fn change(&mut self, change: impl FnOnce(&mut World)) -> Picture {
        change(self.app.world_mut());
        self.set_materials();
        // Frames come back some updates after they were drawn.
        for _ in 0..4 {
            self.app.update();
        }
        self.app.world_mut().resource_mut::<Frames>().0.clear();
        self.wait_for_a_still_frame()
    }

    /// A frame is right when nothing waits for a shader, something is seen, and it stays so.
    fn wait_for_a_still_frame(&mut self) -> Picture {
        const STILL: usize = 4;
        for _ in 0..200 {
            self.app.update();
            let mut errors = std::mem::take(&mut *ERRORS.lock().unwrap());
            errors.retain(|error| !self.expected_errors.iter().any(|text| error.contains(text)));
            assert!(errors.is_empty(), "Bevy logged errors: {errors:#?}");
            let waiting = self
                .app
                .sub_app(RenderApp)
                .world()
                .resource::<PipelineCache>()
                .waiting_pipelines()
                .count();
            let mut frames = self.app.world_mut().resource_mut::<Frames>();
            if waiting > 0 {
                frames.0.clear();
            }
            let count = frames.0.len();
            if count <= STILL + 2 {
                continue;
            }
            let last = &frames.0[count - STILL..];
            if last.iter().all(|frame| *frame == last[0]) {
                let picture = Picture::from_bytes(self.size as usize, &last[0]);
                if picture.pixels.iter().flatten().any(|v| *v != 0.0) {
                    return picture;
                }
            }
        }
        panic!("no frame stood still in 200");
    }

    /// Takes away what the last picture showed.
    fn clear(&mut self) {
        let world = self.app.world_mut();
        let staged: Vec<Entity> = world
            .query_filtered::<Entity, With<Transform>>()
            .iter(world)
            .collect();
        for entity in staged {
            world.despawn(entity);
        }
        self.app.update();
        self.app.update();
        self.app.world_mut().resource_mut::<Frames>().0.clear();
    }
}

/// Keeps what is logged as an error, as rendering goes on after one, and warnings.
struct KeepErrors;

impl<S: Subscriber> Layer<S> for KeepErrors {
    fn on_event(&self, event: &tracing::Event<'_>, _: layer::Context<'_, S>) {
        let kept = match *event.metadata().level() {
            Level::ERROR => &ERRORS,
            Level::WARN => &WARNINGS,
            _ => return,
        };
        let mut text = Text(String::new());
        event.record(&mut text);
        kept.lock().unwrap().push(text.0);
    }
}

struct Text(String);

impl field::Visit for Text {
    fn record_debug(&mut self, field: &field::Field, value: &dyn std::fmt::Debug) {
        self.0 += &format!("{field}: {value:?} ");
    }
}
