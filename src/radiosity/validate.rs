use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::cut::Cuts;
use super::light::{Light, LightKind};
use super::mend::{live_triangles, mend_lights, mend_materials, mend_normals};
use super::occlusion::NO_TRIANGLE;
use super::scene::{Material, Object, Scene, Texture, TextureRef};

/// Why a scene cannot be baked. Each message names the thing and the cure.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// There is no triangle with an area.
    #[error(
        "the scene has no triangles to bake: add a mesh, or check that the file's default scene shows one"
    )]
    Empty,
    /// Nothing emits light, so every vertex would be black.
    #[error(
        "nothing in the scene emits light: add a point, spot or directional light, an emissive \
         material or a sky (`--sky`)"
    )]
    NoLight,
    /// A vertex that a triangle uses is NaN or infinite.
    #[error(
        "object \"{object}\", triangle {triangle}: the position of vertex {vertex} is {position}, which is not finite: repair the mesh in the program that made it"
    )]
    PositionNotFinite {
        /// Name of the object.
        object: String,
        /// Index of the triangle.
        triangle: usize,
        /// Index of the vertex.
        vertex: u32,
        /// What was found.
        position: Vec3,
    },
    /// A triangle refers to a vertex that is not there.
    #[error(
        "object \"{object}\", triangle {triangle}: vertex {vertex} does not exist, there are {vertices}: the index buffer is damaged, export the mesh again"
    )]
    IndexOutOfRange {
        /// Name of the object.
        object: String,
        /// Index of the triangle.
        triangle: usize,
        /// Index of the vertex.
        vertex: u32,
        /// Number of vertices of the object.
        vertices: usize,
    },
    /// A vertex attribute has another length than the positions.
    #[error(
        "object \"{object}\": {attribute} has {found} entries for {vertices} vertices: give one per vertex, or none"
    )]
    AttributeLength {
        /// Name of the object.
        object: String,
        /// Which attribute.
        attribute: String,
        /// Its length.
        found: usize,
        /// Number of vertices of the object.
        vertices: usize,
    },
    /// An object, material or texture reference points nowhere.
    #[error("{user} refers to {target} {index}, which does not exist")]
    MissingReference {
        /// Who refers.
        user: String,
        /// What kind of thing is missing.
        target: &'static str,
        /// Its index.
        index: u32,
    },
    /// A number of a material, light or sky is NaN, infinite or absurdly large.
    #[error("{thing}: {property} is not a number within ±1e15: give it one")]
    NumberOutOfRange {
        /// Which material or light.
        thing: String,
        /// Which of its properties.
        property: &'static str,
    },
    /// The scene's extent does not fit the number range.
    #[error("the scene is {extent:e} m across, outside 1e-9..1e12: scale it")]
    Extent {
        /// Largest extent in metres.
        extent: f64,
    },
}

/// A [`Scene`] that can be baked: indices in range, numbers finite, something to light and
/// something that lights it. Made by [`Scene::validate`] alone.
///
/// Inside, positions are centred and scaled by a power of two to ±`HALF_EXTENT` (twice that in a
/// frame kept from an earlier bake), so that one epsilon fits
/// every scene and scenes far from the origin keep their precision.
#[derive(Clone, Debug, PartialEq)]
pub struct ValidScene {
    pub(crate) objects: Vec<Object>,
    pub(crate) materials: Vec<Material>,
    pub(crate) textures: Arc<Vec<Texture>>,
    pub(crate) lights: Vec<Light>,
    pub(crate) sky: Vec3,
    /// Metres per internal unit, a power of two.
    pub(crate) scale: f32,
    /// World position of the internal origin, in metres.
    pub(crate) center: DVec3,
    /// Triangles that block or receive light: not degenerate, those that block no duplicates.
    pub(crate) triangles: Vec<TriangleKey>,
    pub(crate) notes: Vec<String>,
    /// How objects were cut where others touch them; empty if they were not.
    pub(crate) cuts: Cuts,
}

/// Which triangle of which object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct TriangleKey {
    pub(crate) object: u32,
    pub(crate) triangle: u32,
}

/// Internal positions lie in −`HALF_EXTENT`..`HALF_EXTENT`: far enough above the box epsilon of the
/// ray-tracing hierarchy (10⁻⁴) that surfaces may stand 10⁻⁶ of the scene apart.
pub(crate) const HALF_EXTENT: f32 = 1024.0;

impl ValidScene {
    /// What was mended, one sentence each.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Centre and largest extent of the scene in metres.
    pub fn bounds(&self) -> (DVec3, f64) {
        (self.center, 2.0 * f64::from(HALF_EXTENT * self.scale))
    }

    /// Number of triangles that block light.
    pub fn triangle_count(&self) -> usize {
        self.triangles.iter().filter(|&&t| self.casts(t)).count()
    }

    /// Whether objects, materials and textures are those of another scene.
    pub(crate) fn same_surfaces(&self, other: &Self) -> bool {
        self.triangles == other.triangles
            && self.objects == other.objects
            && self.materials == other.materials
            && self.textures == other.textures
    }

    pub(crate) fn frame(&self) -> Frame {
        Frame {
            center: self.center,
            scale: self.scale,
        }
    }

    /// Corners of a live triangle in internal units.
    pub(crate) fn corners(&self, key: TriangleKey) -> [Vec3; 3] {
        let object = &self.objects[key.object as usize];
        object.triangles[key.triangle as usize].map(|v| object.positions[v as usize])
    }

    /// Which side of a line of contact the corners of a live triangle are on.
    pub(crate) fn sides(&self, key: TriangleKey) -> [u32; 3] {
        let object = key.object as usize;
        let cut = self.cuts.get(object).and_then(Option::as_ref);
        cut.map_or([0; 3], |cut| {
            let corners = self.objects[object].triangles[key.triangle as usize];
            corners.map(|v| cut.mesh.sides[v as usize])
        })
    }

    /// For each triangle of each object its live index, or [`NO_TRIANGLE`].
    pub(crate) fn live_indices(&self) -> Vec<Vec<u32>> {
        let none = |o: &Object| vec![NO_TRIANGLE; o.triangles.len()];
        let mut live: Vec<Vec<u32>> = self.objects.iter().map(none).collect();
        for (i, key) in self.triangles.iter().enumerate() {
            live[key.object as usize][key.triangle as usize] = i as u32;
        }
        live
    }

    /// Whether a live triangle stops light.
    pub(crate) fn casts(&self, key: TriangleKey) -> bool {
        self.objects[key.object as usize].casts
    }

    pub(crate) fn material(&self, key: TriangleKey) -> &Material {
        let object = &self.objects[key.object as usize];
        &self.materials[object.material.0 as usize]
    }
}

impl Scene {
    /// Checks everything a bake relies on, and mends what can be mended.
    ///
    /// Mended and counted in [`ValidScene::notes`]: triangles without area, triangles that occur
    /// twice, unusable normals, base colours outside 0..1, negative light.
    ///
    /// # Errors
    ///
    /// [`SceneError`] names the object, the triangle and the cause.
    pub fn validate(self) -> Result<ValidScene, SceneError> {
        let scene = self.validate_in(None)?;
        if !shines(&scene) {
            return Err(SceneError::NoLight);
        }
        Ok(scene)
    }

    /// The same for a scene in which nothing need shine, and in a frame that is kept as long as the
    /// scene fits.
    pub(crate) fn validate_in(self, kept: Option<Frame>) -> Result<ValidScene, SceneError> {
        check_references(&self)?;
        check_numbers(&self)?;
        let mut notes = Vec::new();
        let Frame { center, scale } = frame(&self, kept)?;
        let mut scene = ValidScene {
            center,
            scale,
            objects: self.objects,
            materials: self.materials,
            textures: self.textures.into(),
            lights: self.lights,
            sky: self.sky,
            triangles: Vec::new(),
            notes: Vec::new(),
            cuts: Cuts::new(),
        };
        normalise_frame(&mut scene, center - self.origin);
        mend_materials(&mut scene, &mut notes);
        mend_lights(&mut scene, &mut notes);
        mend_normals(&mut scene, &mut notes);
        scene.triangles = live_triangles(&scene, &mut notes);
        if scene.triangles.is_empty() {
            return Err(SceneError::Empty);
        }
        scene.notes = notes;
        Ok(scene)
    }
}

fn check_references(scene: &Scene) -> Result<(), SceneError> {
    for object in &scene.objects {
        check_attributes(object)?;
        if object.material.0 as usize >= scene.materials.len() {
            return Err(SceneError::MissingReference {
                user: format!("object \"{}\"", object.name),
                target: "material",
                index: object.material.0,
            });
        }
        for (triangle, corners) in object.triangles.iter().enumerate() {
            for &vertex in corners {
                let Some(&position) = object.positions.get(vertex as usize) else {
                    return Err(SceneError::IndexOutOfRange {
                        object: object.name.clone(),
                        triangle,
                        vertex,
                        vertices: object.positions.len(),
                    });
                };
                if !position.is_finite() {
                    return Err(SceneError::PositionNotFinite {
                        object: object.name.clone(),
                        triangle,
                        vertex,
                        position,
                    });
                }
            }
        }
    }
    for material in &scene.materials {
        for texture in texture_refs(material) {
            let known = scene.textures.get(texture.texture.0 as usize);
            if known.is_none_or(|t| {
                t.texels.len() != t.width as usize * t.height as usize || t.texels.is_empty()
            }) {
                return Err(SceneError::MissingReference {
                    user: format!("material \"{}\"", material.name),
                    target: "texture",
                    index: texture.texture.0,
                });
            }
        }
    }
    Ok(())
}

fn check_attributes(object: &Object) -> Result<(), SceneError> {
    let vertices = object.positions.len();
    let length = |attribute: String, found: usize| {
        if found == 0 || found == vertices {
            return Ok(());
        }
        Err(SceneError::AttributeLength {
            object: object.name.clone(),
            attribute,
            found,
            vertices,
        })
    };
    length("normals".into(), object.normals.len())?;
    length("colors".into(), object.colors.len())?;
    for (set, uvs) in object.uvs.iter().enumerate() {
        length(format!("uvs[{set}]"), uvs.len())?;
    }
    Ok(())
}

fn texture_refs(material: &Material) -> impl Iterator<Item = &TextureRef> {
    [
        &material.base_color_texture,
        &material.metallic_texture,
        &material.emissive_texture,
    ]
    .into_iter()
    .flatten()
}

fn check_numbers(scene: &Scene) -> Result<(), SceneError> {
    let finite = |ok: bool, thing: &dyn Fn() -> String, property| {
        if ok {
            return Ok(());
        }
        Err(SceneError::NumberOutOfRange {
            thing: thing(),
            property,
        })
    };
    finite(bounded(scene.sky), &|| "the sky".into(), "its radiance")?;
    finite(
        scene.origin.is_finite(),
        &|| "the scene".into(),
        "its origin",
    )?;
    for m in &scene.materials {
        let thing = || format!("material \"{}\"", m.name);
        finite(m.base_color.is_finite(), &thing, "the base colour")?;
        finite(m.metallic.is_finite(), &thing, "metallic")?;
        finite(bounded(m.emissive), &thing, "the emissive colour")?;
    }
    for light in &scene.lights {
        let thing = || format!("light \"{}\"", light.name);
        finite(bounded(light.power), &thing, "the power")?;
        match light.kind {
            LightKind::Point { position, range } => {
                finite(position.is_finite(), &thing, "the position")?;
                finite(!range.is_nan(), &thing, "the range")?;
            }
            LightKind::Spot {
                position,
                direction,
                inner_angle,
                outer_angle,
                range,
            } => {
                finite(position.is_finite(), &thing, "the position")?;
                finite(usable(direction), &thing, "the direction")?;
                finite(
                    (inner_angle + outer_angle).is_finite(),
                    &thing,
                    "the cone angle",
                )?;
                finite(!range.is_nan(), &thing, "the range")?;
            }
            LightKind::Rect {
                position,
                direction,
                right,
                width,
                height,
                range,
            } => {
                finite(position.is_finite(), &thing, "the position")?;
                finite(usable(direction), &thing, "the direction")?;
                finite(usable(right), &thing, "the direction of its width")?;
                finite((width + height).is_finite(), &thing, "the size")?;
                finite(!range.is_nan(), &thing, "the range")?;
            }
            LightKind::Directional { direction } => {
                finite(usable(direction), &thing, "the direction")?;
            }
        }
    }
    Ok(())
}

/// Brighter than any light, and far enough from the end of `f32` for sums and products.
const BRIGHTEST_LIGHT: f32 = 1e15;

fn bounded(color: Vec3) -> bool {
    color.is_finite() && color.abs().max_element() <= BRIGHTEST_LIGHT
}

/// Whether a vector has a direction.
pub(super) fn usable(v: Vec3) -> bool {
    v.is_finite() && v.as_dvec3().length() > 1e-30
}

/// Where internal coordinates lie in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    /// World position of the internal origin, in metres.
    pub(crate) center: DVec3,
    /// Metres per internal unit, a power of two.
    pub(crate) scale: f32,
}

impl Frame {
    /// Whether a scene of these bounds neither leaves twice the room there is nor is lost in it.
    fn fits(&self, low: DVec3, high: DVec3) -> bool {
        let unit = f64::from(self.scale * HALF_EXTENT);
        let reach = (low - self.center).abs().max((high - self.center).abs());
        reach.max_element() <= 2.0 * unit && (high - low).max_element() >= 0.25 * unit
    }
}

/// A frame around the used vertices; the one that is kept, if they fit.
fn frame(scene: &Scene, kept: Option<Frame>) -> Result<Frame, SceneError> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for object in &scene.objects {
        for &v in object.triangles.iter().flatten() {
            let p = object.positions[v as usize].as_dvec3();
            low = low.min(p);
            high = high.max(p);
        }
    }
    if low.x > high.x {
        return Err(SceneError::Empty);
    }
    let extent = (high - low).max_element();
    if extent == 0.0 {
        return Err(SceneError::Empty);
    }
    if !(1e-9..=1e12).contains(&extent) {
        return Err(SceneError::Extent { extent });
    }
    if let Some(kept) = kept.filter(|k| k.fits(scene.origin + low, scene.origin + high)) {
        return Ok(kept);
    }
    // A power of two: scaling by it loses no bits.
    let scale = (0.5 * extent).log2().ceil().exp2() / f64::from(HALF_EXTENT);
    Ok(Frame {
        center: scene.origin + (low + high) * 0.5,
        scale: scale as f32,
    })
}

fn normalise_frame(scene: &mut ValidScene, center: DVec3) {
    let inverse = 1.0 / f64::from(scene.scale);
    let to_internal = |p: Vec3| ((p.as_dvec3() - center) * inverse).as_vec3();
    for object in &mut scene.objects {
        for p in &mut object.positions {
            *p = to_internal(*p);
        }
    }
    // Intensities fall with the square of a distance that is now counted in other units.
    let inverse_square = (inverse * inverse) as f32;
    for light in &mut scene.lights {
        match &mut light.kind {
            LightKind::Point { position, range }
            | LightKind::Spot {
                position, range, ..
            } => {
                *position = to_internal(*position);
                *range *= inverse as f32;
                light.power *= inverse_square;
            }
            LightKind::Rect {
                position,
                width,
                height,
                range,
                ..
            } => {
                *position = to_internal(*position);
                *width *= inverse as f32;
                *height *= inverse as f32;
                *range *= inverse as f32;
                light.power *= inverse_square;
            }
            LightKind::Directional { .. } => {}
        }
    }
}

/// Whether there is any light at all.
pub(super) fn shines(scene: &ValidScene) -> bool {
    scene.sky.max_element() > 0.0
        || scene.lights.iter().any(|l| l.power.max_element() > 0.0)
        || scene.triangles.iter().any(|&t| {
            let m = scene.material(t);
            scene.casts(t) && m.emissive.max_element() > 0.0 && !m.unlit
        })
}
