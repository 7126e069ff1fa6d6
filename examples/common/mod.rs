//! What the examples share: `--screenshot FILE` draws without a window, waits for relief and light and saves a
//! picture. Keys that change relief.
#![allow(dead_code, reason = "no example uses all of it")]

use std::path::PathBuf;

use bevy::app::PluginGroupBuilder;
use bevy::asset::RenderAssetUsages;
use bevy::camera::RenderTarget;
use bevy::image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages};
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy_fresco::plugin::FrescoMaterial;
use bevy_fresco::plugin::bump::{BumpHeight, Parallax};
use bevy_fresco::plugin::displacement::DisplacementStatus;
use bevy_fresco::plugin::radiosity::{RadiosityStatus, StaticLighting};

/// Frames between relief and light being there and the picture: pipelines and shadow maps settle.
const SETTLE: u32 = 30;

/// `DefaultPlugins`, with a window of that title or, for a screenshot, without one.
pub(crate) fn default_plugins(title: &str) -> PluginGroupBuilder {
    let Some(path) = argument("--screenshot").map(PathBuf::from) else {
        let window = Window {
            title: title.into(),
            ..default()
        };
        return DefaultPlugins.set(WindowPlugin {
            primary_window: Some(window),
            ..default()
        });
    };
    without_window().add(TakeScreenshot { path })
}

/// `DefaultPlugins` that draw into nothing, as fast as they can.
pub(crate) fn without_window() -> PluginGroupBuilder {
    DefaultPlugins
        .set(WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..default()
        })
        // Else the first frames are empty, and there may be no others.
        .set(RenderPlugin {
            synchronous_pipeline_compilation: true,
            ..default()
        })
        .disable::<WinitPlugin>()
        .add(bevy::app::ScheduleRunnerPlugin::default())
}

/// What the command line gives after a flag, if that is there.
pub(crate) fn argument(flag: &str) -> Option<String> {
    let mut arguments = std::env::args().skip_while(|argument| argument != flag);
    arguments.next()?;
    let value = arguments.next();
    assert!(value.is_some(), "{flag} needs a value");
    value
}

struct TakeScreenshot {
    path: PathBuf,
}

#[derive(Resource)]
struct Shot {
    path: PathBuf,
    settled: u32,
}

impl Plugin for TakeScreenshot {
    fn build(&self, app: &mut App) {
        app.add_plugins(DrawIntoImage)
            .insert_resource(Shot {
                path: self.path.clone(),
                settled: 0,
            })
            .add_systems(Update, shoot);
    }
}

/// Has cameras draw into an image in the place of the window that is not there.
pub(crate) struct DrawIntoImage;

#[derive(Resource)]
struct Target(Handle<Image>);

impl Plugin for DrawIntoImage {
    fn build(&self, app: &mut App) {
        let mut image = Image::new_target_texture(800, 800, TextureFormat::Rgba8UnormSrgb, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        image.asset_usage = RenderAssetUsages::all();
        let image = app.world_mut().resource_mut::<Assets<Image>>().add(image);
        app.insert_resource(Target(image)).add_systems(Update, aim);
    }
}

/// Turns cameras from the window that is not there to the image.
fn aim(image: Res<Target>, mut cameras: Query<(&mut RenderTarget, &mut Projection)>) {
    for (mut target, mut projection) in &mut cameras {
        if matches!(*target, RenderTarget::Window(_)) {
            *target = RenderTarget::Image(image.0.clone().into());
            // Bevy looks for the new target's size when the projection has changed.
            projection.set_changed();
        }
    }
}

fn shoot(
    mut commands: Commands,
    mut shot: ResMut<Shot>,
    image: Res<Target>,
    status: Option<Res<RadiosityStatus>>,
    baked: Query<(), With<StaticLighting>>,
    displaced: Query<&DisplacementStatus>,
) {
    let is_raised = |d: &DisplacementStatus| !d.is_pending() && *d != DisplacementStatus::Idle;
    let is_lit = baked.is_empty() || status.is_some_and(|status| status.is_up_to_date());
    if !is_lit || !displaced.iter().all(is_raised) {
        shot.settled = 0;
        return;
    }
    shot.settled += 1;
    if shot.settled == SETTLE {
        commands
            .spawn(Screenshot::image(image.0.clone()))
            .observe(save_to_disk(shot.path.clone()))
            .observe(
                |_: On<ScreenshotCaptured>, mut exit: MessageWriter<AppExit>| {
                    exit.write(AppExit::Success);
                },
            );
    }
}

/// A picture that repeats, made of rows of texels.
pub(crate) fn picture(
    [width, height]: [u32; 2],
    texels: impl Iterator<Item = [u8; 4]>,
    format: TextureFormat,
) -> Image {
    let mut image = Image::new(
        Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        texels.flatten().collect(),
        format,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        ..ImageSamplerDescriptor::linear()
    });
    image
}

/// 1 while up is held, −1 while down is.
pub(crate) fn up_or_down(keys: &ButtonInput<KeyCode>) -> f32 {
    let held = |key| f32::from(u8::from(keys.pressed(key)));
    held(KeyCode::ArrowUp) - held(KeyCode::ArrowDown)
}

/// Up and down make the relief of all materials higher and lower: by all of `height` in a second.
pub(crate) fn change_height(
    height: f32,
) -> impl FnMut(Res<ButtonInput<KeyCode>>, Res<Time>, ResMut<Assets<FrescoMaterial>>) {
    move |keys, time, mut materials| {
        let direction = up_or_down(&keys);
        if direction == 0.0 {
            return;
        }
        for (_, material) in materials.iter_mut() {
            if let Some(bump) = &mut material.extension.bump
                && let BumpHeight::Mesh(now) = &mut bump.height
            {
                *now += direction * height * time.delta_secs();
            }
        }
    }
}

/// P shows the relief of all materials from the side, and flat again.
pub(crate) fn toggle_parallax(
    keys: Res<ButtonInput<KeyCode>>,
    mut materials: ResMut<Assets<FrescoMaterial>>,
) {
    if keys.just_pressed(KeyCode::KeyP) {
        for (_, material) in materials.iter_mut() {
            if let Some(bump) = &mut material.extension.bump {
                bump.parallax = match bump.parallax {
                    Some(_) => None,
                    None => Some(Parallax::default()),
                };
            }
        }
    }
}
