use bevy::math::Affine2;
use bevy::mesh::UvChannel;
use bevy::prelude::*;

use super::drive::Worker;
use super::reflect::DisplacementSettingsReflect;
use super::status::DisplacementStatus;
use crate::displacement::{DisplacementSettings, Tessellation};
use crate::plugin::bump::HeightImage;

/// Raises the mesh of an entity by a height map: vertices move, so outlines, shadows, bounds, picking and baked
/// light see the relief.
///
/// The mesh needs normals and texture coordinates, and has to stay in the main world. It is raised in its own
/// space, so relief grows with the scale of the entity. Other entities that share the mesh keep it as it is.
///
/// [`DisplacementStatus`] tells what becomes of it. Until the raised mesh is there, and when it cannot be made, the
/// entity shows what it showed before. Removing the component puts the source mesh back.
///
/// ```no_run
/// # use bevy::prelude::*;
/// # use bevy_fresco::plugin::displacement::Displacement;
/// # fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, assets: Res<AssetServer>) {
/// commands.spawn((
///     Mesh3d(meshes.add(Plane3d::new(Vec3::Z, Vec2::splat(1.0)))),
///     Displacement::new(assets.load("bricks.png"), 0.03),
/// ));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
#[require(DisplacementStatus, Worker)]
pub struct Displacement {
    /// The height map; it also says how it goes on beyond its border
    /// ([`HeightImageSettings::wrap`](crate::plugin::bump::HeightImageSettings::wrap)).
    pub map: Handle<HeightImage>,
    /// How far, which way, with how many vertices and at what cost. Metres are units of the mesh.
    #[reflect(remote = DisplacementSettingsReflect)]
    pub settings: DisplacementSettings,
    /// Which texture coordinates the map lies on.
    pub uv_channel: UvChannel,
    /// Applied to texture coordinates before the map is looked up: a scale of 4 puts the map four times along
    /// each side. [`StandardMaterial::uv_transform`] is not followed.
    pub uv_transform: Affine2,
}

impl Default for Displacement {
    /// No map; a scale of 5 cm, by faces that are off by half a millimetre at most.
    fn default() -> Self {
        Self::new(Handle::default(), DisplacementSettings::default().scale)
    }
}

impl Displacement {
    /// Raises by `map`, whose 1 stands out by `scale` metres beyond its 0, with triangles where the relief asks
    /// for them: the mesh is off by a hundredth of the scale at most.
    pub fn new(map: Handle<HeightImage>, scale: f32) -> Self {
        // Of no scale any tolerance will do.
        let tolerance = (0.01 * scale.abs()).max(f32::MIN_POSITIVE);
        Self {
            map,
            settings: DisplacementSettings {
                scale,
                tessellation: Tessellation::Adaptive { tolerance },
                ..DisplacementSettings::default()
            },
            uv_channel: UvChannel::Uv0,
            uv_transform: Affine2::IDENTITY,
        }
    }
}

/// On entities whose mesh is raised by a [`Displacement`].
///
/// To give such an entity another mesh, set `Mesh3d`; to edit it, edit the source. What is written into the raised
/// mesh itself is lost when it is made again.
#[derive(Component, Reflect, Clone, Debug)]
#[reflect(Component, Debug, Clone)]
pub struct DisplacedMesh {
    /// The mesh as it was.
    pub source: Handle<Mesh>,
    /// What was made of it, for this entity alone.
    pub displaced: Handle<Mesh>,
}
