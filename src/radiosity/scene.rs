use glam::{Affine2, DVec3, Vec2, Vec3, Vec4};

use super::light::Light;

/// Everything a bake looks at: triangles, materials, lights and sky, with no handles and no files.
///
/// Lengths are in metres, light in Bevy's photometric units (see [`Light`] and [`Material`]),
/// colours linear RGB. Call [`Scene::validate`] to get what [`bake`](super::bake) takes.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The meshes, each with one material, in world space.
    pub objects: Vec<Object>,
    /// Materials that objects refer to.
    pub materials: Vec<Material>,
    /// Images that materials refer to.
    pub textures: Vec<Texture>,
    /// Point, spot, rectangular and directional lights. Emissive materials light the scene by themselves.
    pub lights: Vec<Light>,
    /// Radiance of the sky in cd/m², the same in every direction that no triangle blocks.
    pub sky: Vec3,
    /// What to add to every position of this scene to get world coordinates, in metres.
    ///
    /// Zero for most scenes. Far from the world's origin `f32` coordinates are coarse (6 cm at
    /// 10⁶ m), so a loader that has finer ones passes them relative to this point.
    pub origin: DVec3,
}

/// Index of an [`Object`] in [`Scene::objects`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObjectId(pub u32);

/// Index of a [`Material`] in [`Scene::materials`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MaterialId(pub u32);

/// Index of a [`Texture`] in [`Scene::textures`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TextureId(pub u32);

/// A triangle mesh in world space with one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Used in errors and reports.
    pub name: String,
    /// Vertex positions in metres, relative to [`Scene::origin`].
    pub positions: Vec<Vec3>,
    /// Vertex normals, one a vertex, any length; or empty for a flat-shaded mesh.
    pub normals: Vec<Vec3>,
    /// Texture coordinates by set, `uvs[set][vertex]`, with (0, 0) the image's upper left corner.
    pub uvs: Vec<Vec<Vec2>>,
    /// Vertex colours, linear RGB and alpha, that multiply the base colour; or empty for white.
    pub colors: Vec<Vec4>,
    /// Vertex indices; counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// The material of all triangles.
    pub material: MaterialId,
    /// Tells the object from others from one bake to the next (see [`Baker`](super::Baker)).
    /// Objects with one key are told apart by their order.
    pub key: u64,
    /// Stops light. Without it rays pass, so the object reflects and emits nothing either, but may
    /// receive.
    pub casts: bool,
    /// Gets vertex light. Without it the object's [`ObjectLight`](super::ObjectLight) is empty and
    /// no rays are spent on it.
    pub receives: bool,
    /// May get more vertices where its light needs them (see
    /// [`BakeSettings::refine`](super::BakeSettings::refine)). Without it the mesh stays as it is.
    pub refine: bool,
    /// Reflects light. Without it the object is black to radiosity, but still emits.
    pub reflects: bool,
}

impl Default for Object {
    /// Nothing, which casts, receives and reflects.
    fn default() -> Self {
        Self {
            name: String::new(),
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            colors: Vec::new(),
            triangles: Vec::new(),
            material: MaterialId::default(),
            key: 0,
            casts: true,
            receives: true,
            refine: true,
            reflects: true,
        }
    }
}

/// How a surface reflects, emits and lets light through.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Used in errors and reports.
    pub name: String,
    /// Linear RGB and alpha, each 0..1, multiplied by vertex colour and texture.
    pub base_color: Vec4,
    /// Image that multiplies the base colour (sRGB colours, linear alpha).
    pub base_color_texture: Option<TextureRef>,
    /// 0 for dielectrics, 1 for metals, which have no diffuse reflection.
    pub metallic: f32,
    /// Image whose blue channel multiplies `metallic`.
    pub metallic_texture: Option<TextureRef>,
    /// Radiance emitted by the front side (both sides if `double_sided`), in cd/m².
    pub emissive: Vec3,
    /// Image that multiplies `emissive`.
    pub emissive_texture: Option<TextureRef>,
    /// Reflects and emits on both sides. One-sided surfaces block light from behind and are black
    /// there.
    pub double_sided: bool,
    /// What alpha means for light that meets the surface.
    pub alpha: AlphaMode,
    /// Shown as its base colour whatever the light: reflects nothing, emits nothing, blocks light.
    pub unlit: bool,
}

impl Default for Material {
    /// White, diffuse, one-sided, opaque.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 0.0,
            metallic_texture: None,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            double_sided: false,
            alpha: AlphaMode::Opaque,
            unlit: false,
        }
    }
}

/// What the alpha of the base colour means for light that meets the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored: all light is stopped.
    #[default]
    Opaque,
    /// Light passes where alpha is below the cutoff.
    Mask(f32),
    /// The share `1 - alpha` of the light passes, uncoloured and straight on.
    Blend,
}

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Which image.
    pub texture: TextureId,
    /// Which set of [`Object::uvs`].
    pub uv_set: u32,
    /// Applied to the texture coordinates first (`KHR_texture_transform`).
    pub transform: Affine2,
}

/// How texture coordinates outside 0..1 are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image repeats.
    #[default]
    Repeat,
    /// The image repeats, every second time mirrored.
    Mirror,
    /// The border texel goes on.
    Clamp,
}

/// An 8-bit RGBA image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Texture {
    /// Used in errors and reports.
    pub name: String,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Rows from the top, `width × height` texels. How colours are encoded (sRGB or linear) is
    /// decided by the material slot that reads them; alpha is always linear.
    pub texels: Vec<[u8; 4]>,
    /// Wrapping of u and v.
    pub wrap: [Wrap; 2],
}
