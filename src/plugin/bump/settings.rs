use bevy::math::Affine2;
use bevy::mesh::UvChannel;
use bevy::prelude::*;
use bevy::render::render_resource::ShaderType;

use super::{GpuHeightImage, HeightImage, Parallax};
use crate::height_map::Wrap;

/// Relief that a height map gives to a surface: its normals are those of the raised surface, its shape stays
/// (J. F. Blinn, "Simulation of wrinkled surfaces", SIGGRAPH 1978).
///
/// Needs normals and texture coordinates, no tangents. Where the map is finer than pixels, slopes that
/// average away make the surface rougher instead, so that highlights look the same from afar.
///
/// While the map is not loaded, or what it needs is missing, the surface is smooth; the latter is told as a
/// warning.
#[derive(Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct Bump {
    /// The height map. Heights have any range; [`height`](Self::height) gives them meaning.
    pub map: Handle<HeightImage>,
    /// How far 1 of the map stands out beyond 0. Negative: the map is of depths.
    pub height: BumpHeight,
    /// Which texture coordinates the map lies on.
    pub uv_channel: UvChannel,
    /// Applied to texture coordinates after [`StandardMaterial::uv_transform`], which is followed. A scale of
    /// 4 shows the map four times along each side, with the same height.
    pub uv_transform: Affine2,
    /// How slopes are found between texels, where the map is magnified.
    pub filter: BumpFilter,
    /// Keep the term that Blinn leaves out, as is right where relief is high beside the radius of curvature:
    /// normals are then those of the displaced surface. Costs a further texture read. Not for a detail
    /// bump.
    pub curvature: bool,
    /// Show the surface where relief would be seen, not only lit as relief: textures move with the view, and what
    /// stands out hides what lies behind it. Not for a detail bump, which moves along with the main one.
    pub parallax: Option<Parallax>,
}

/// How slopes are found between the texels of a map that is magnified. Detail bumps are always
/// [`Linear`](Self::Linear).
#[derive(Reflect, Debug, Default, Clone, Copy, PartialEq, Eq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub enum BumpFilter {
    /// Slopes of texels, with straight lines between: one texture read. Light on it has creases along texels,
    /// which show under strong magnification.
    Linear,
    /// The slope of a cubic through the texels, 16 reads where a texel is larger than a pixel. Graphics cards
    /// leave them out elsewhere, software renderers do not.
    #[default]
    CatmullRom,
    /// The slope of a cubic that passes by the texels: as many reads. Rounds the steps of 8-bit maps off, and
    /// makes fine relief lower.
    BSpline,
}

/// How far 1 of a height map stands out beyond 0.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
pub enum BumpHeight {
    /// In units of the mesh: relief grows with the object, as that of a displaced mesh does. Joints of
    /// skinned meshes do not count as scale.
    Mesh(f32),
    /// In metres, however the object is scaled.
    World(f32),
    /// In widths of the map as it lies on the surface: slopes are those of the map, however often it is
    /// repeated and however large the surface. Where it is stretched, by the mean of both directions.
    Uv(f32),
}

impl Default for BumpHeight {
    fn default() -> Self {
        Self::Mesh(0.01)
    }
}

impl BumpHeight {
    /// The number, and which of the three it is for the shader.
    fn parts(self) -> [f32; 2] {
        match self {
            Self::Mesh(height) => [height, 0.0],
            Self::World(height) => [height, 1.0],
            Self::Uv(height) => [height, 2.0],
        }
    }
}

impl Default for Bump {
    fn default() -> Self {
        Self {
            map: Handle::default(),
            height: BumpHeight::default(),
            uv_channel: UvChannel::Uv0,
            uv_transform: Affine2::IDENTITY,
            filter: BumpFilter::default(),
            curvature: false,
            parallax: None,
        }
    }
}

impl Bump {
    /// A bump by `map`, whose 1 stands out so far beyond its 0.
    pub fn new(map: Handle<HeightImage>, height: BumpHeight) -> Self {
        Self {
            map,
            height,
            ..default()
        }
    }
}

/// What of the bumps of a material needs a shader of its own: the material's key.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct BumpKey(u16);

impl BumpKey {
    const MAIN: u16 = 1;
    const MAIN_UV_B: u16 = 2;
    const DETAIL: u16 = 4;
    const DETAIL_UV_B: u16 = 8;
    const CURVATURE: u16 = 16;
    const CUBIC: u16 = 32;
    const PARALLAX: u16 = 64;
    /// Textures of the standard material may lie on these texture coordinates and have to follow parallax.
    const FOLLOWS_A: u16 = 128;
    const FOLLOWS_B: u16 = 256;

    /// The key of a material with these bumps.
    pub(in crate::plugin) fn new(main: Option<&Bump>, detail: Option<&Bump>) -> Self {
        let of = |bump: Option<&Bump>, present, uv_b| match bump {
            None => 0,
            Some(bump) if bump.uv_channel == UvChannel::Uv1 => present | uv_b,
            Some(_) => present,
        };
        let curvature = main.is_some_and(|bump| bump.curvature);
        let cubic = main.is_some_and(|bump| bump.filter != BumpFilter::Linear);
        let parallax = main.is_some_and(|bump| bump.parallax.is_some());
        Self(
            of(main, Self::MAIN, Self::MAIN_UV_B)
                | of(detail, Self::DETAIL, Self::DETAIL_UV_B)
                | if curvature { Self::CURVATURE } else { 0 }
                | if cubic { Self::CUBIC } else { 0 }
                | if parallax { Self::PARALLAX } else { 0 },
        )
    }

    fn has(self, bit: u16) -> bool {
        self.0 & bit != 0
    }

    /// What is left on a mesh with these of both texture coordinates.
    pub(in crate::plugin) fn on_mesh(self, has_uv: [bool; 2]) -> Self {
        let mut left = self.0;
        if !has_uv[usize::from(self.has(Self::MAIN_UV_B))] {
            left &=
                !(Self::MAIN | Self::MAIN_UV_B | Self::CURVATURE | Self::CUBIC | Self::PARALLAX);
        }
        if !has_uv[usize::from(self.has(Self::DETAIL_UV_B))] {
            left &= !(Self::DETAIL | Self::DETAIL_UV_B);
        }
        if left & Self::PARALLAX != 0 {
            let follows = [Self::FOLLOWS_A, Self::FOLLOWS_B].into_iter().zip(has_uv);
            left |= follows
                .map(|(bit, has)| if has { bit } else { 0 })
                .sum::<u16>();
        }
        Self(left)
    }

    /// Whether there is any bump.
    pub(in crate::plugin) fn is_any(self) -> bool {
        self.has(Self::MAIN | Self::DETAIL)
    }

    /// Whether the main bump is shown by parallax.
    pub(in crate::plugin) fn has_parallax(self) -> bool {
        self.has(Self::PARALLAX)
    }

    /// Whether anything lies on the first texture coordinates, those that meshes may bring gradients of.
    pub(in crate::plugin) fn uses_uv_a(self) -> bool {
        self.has(Self::FOLLOWS_A)
            || (self.has(Self::MAIN) && !self.has(Self::MAIN_UV_B))
            || (self.has(Self::DETAIL) && !self.has(Self::DETAIL_UV_B))
    }

    fn uses_uv_b(self) -> bool {
        self.has(Self::MAIN_UV_B | Self::DETAIL_UV_B | Self::FOLLOWS_B)
    }

    /// Shader definitions of it.
    pub(in crate::plugin) fn shader_defs(self) -> impl Iterator<Item = &'static str> {
        [
            (self.is_any(), "FRESCO_BUMP"),
            (self.uses_uv_a(), "FRESCO_UV_A"),
            (self.uses_uv_b(), "FRESCO_UV_B"),
            (self.has(Self::MAIN), "FRESCO_MAIN_BUMP"),
            (self.has(Self::MAIN_UV_B), "FRESCO_MAIN_UV_B"),
            (self.has(Self::DETAIL), "FRESCO_DETAIL_BUMP"),
            (self.has(Self::DETAIL_UV_B), "FRESCO_DETAIL_UV_B"),
            (self.has(Self::CURVATURE), "FRESCO_CURVATURE"),
            (self.has(Self::CUBIC), "FRESCO_CUBIC"),
            (self.has(Self::PARALLAX), "FRESCO_PARALLAX"),
        ]
        .into_iter()
        .filter_map(|(is_set, name)| is_set.then_some(name))
    }
}

/// `Bump` in `surface.wgsl`.
#[derive(ShaderType, Clone, Copy, Debug, Default)]
pub(in crate::plugin) struct BumpUniform {
    row_u: Vec4,
    row_v: Vec4,
    size: Vec4,
    range: Vec4,
    sight: Vec4,
}

impl BumpUniform {
    /// A bump with its map; nothing where there is none, or it is not loaded.
    pub(in crate::plugin) fn new(bump: Option<&Bump>, map: &GpuHeightImage) -> Self {
        let Some(bump) = bump else {
            return Self::default();
        };
        let Affine2 {
            matrix2: m,
            translation: t,
        } = bump.uv_transform;
        let [height, unit] = bump.height.parts();
        let passes_by = bump.filter == BumpFilter::BSpline;
        let repeats = |axis: usize| map.wrap[axis] == Wrap::Repeat;
        let bits = u8::from(repeats(0)) | u8::from(repeats(1)) << 1 | u8::from(passes_by) << 2;
        Self {
            row_u: Vec4::new(m.x_axis.x, m.y_axis.x, t.x, height),
            row_v: Vec4::new(m.x_axis.y, m.y_axis.y, t.y, unit),
            size: map.size.as_vec2().extend(map.steepest).extend(bits.into()),
            range: map.range.extend(0.0).extend(0.0),
            sight: (bump.parallax.as_ref()).map_or(Vec4::ZERO, |parallax| {
                parallax.uniform(map.range, height < 0.0)
            }),
        }
    }
}
