use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

use super::scene::{AlphaMode, Material, TextureRef};
use super::texture::{Encoding, Pyramid};
use super::validate::ValidScene;

/// Diffuse properties of a point or patch of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Diffuse {
    /// Share of the light reflected, linear RGB.
    pub(crate) reflectance: Vec3,
    /// Radiance emitted, cd/m².
    pub(crate) emission: Vec3,
    /// Share of the area that stops light.
    pub(crate) coverage: f32,
}

/// Pyramids by texture, as colours and as plain numbers; made only where a material asks.
pub(crate) struct Pyramids {
    color: Vec<Option<Arc<Pyramid>>>,
    data: Vec<Option<Arc<Pyramid>>>,
}

impl Pyramids {
    /// Makes what a scene needs, or takes it over from `before`, those of another scene.
    pub(crate) fn new(scene: &ValidScene, before: Option<(&ValidScene, &Self)>) -> Self {
        let mut pyramids = Self {
            color: vec![None; scene.textures.len()],
            data: vec![None; scene.textures.len()],
        };
        for material in &scene.materials {
            for slot in [&material.base_color_texture, &material.emissive_texture]
                .into_iter()
                .flatten()
            {
                pyramids.make(scene, before, slot.texture.0 as usize, Encoding::Srgb);
            }
            if let Some(slot) = &material.metallic_texture {
                pyramids.make(scene, before, slot.texture.0 as usize, Encoding::Linear);
            }
        }
        pyramids
    }

    fn make(
        &mut self,
        scene: &ValidScene,
        before: Option<(&ValidScene, &Self)>,
        i: usize,
        encoding: Encoding,
    ) {
        fn list(of: &Pyramids, encoding: Encoding) -> &[Option<Arc<Pyramid>>] {
            match encoding {
                Encoding::Srgb => &of.color,
                Encoding::Linear => &of.data,
            }
        }
        let known = before.and_then(|(old, pyramids)| {
            let same = old.textures.get(i) == Some(&scene.textures[i]);
            list(pyramids, encoding).get(i).filter(|_| same)?.clone()
        });
        let made = match encoding {
            Encoding::Srgb => &mut self.color[i],
            Encoding::Linear => &mut self.data[i],
        };
        made.get_or_insert_with(|| {
            known.unwrap_or_else(|| Arc::new(Pyramid::new(&scene.textures[i], encoding)))
        });
    }

    pub(crate) fn bytes(&self) -> u64 {
        let all = self.color.iter().chain(&self.data).flatten();
        all.map(|p| p.bytes()).sum()
    }
}

/// What surfaces look like at any point: materials, textures and vertex colours put together.
#[derive(Clone, Copy)]
pub(crate) struct Surfaces<'a> {
    scene: &'a ValidScene,
    pyramids: &'a Pyramids,
}

impl<'a> Surfaces<'a> {
    pub(crate) fn new(scene: &'a ValidScene, pyramids: &'a Pyramids) -> Self {
        Self { scene, pyramids }
    }

    /// Whether light can pass a live triangle.
    pub(crate) fn transmits(&self, triangle: u32) -> bool {
        let key = self.scene.triangles[triangle as usize];
        let material = self.scene.material(key);
        let object = &self.scene.objects[key.object as usize];
        material.alpha != AlphaMode::Opaque
            && (material.base_color.w < 1.0
                || material.base_color_texture.is_some()
                || !object.colors.is_empty())
    }

    /// The share of light that a point of a live triangle stops.
    pub(crate) fn alpha(&self, triangle: u32, uv: [f32; 2]) -> f32 {
        let material = self.scene.material(self.scene.triangles[triangle as usize]);
        let barycentrics = Vec3::new(1.0 - uv[0] - uv[1], uv[0], uv[1]);
        stopped(
            material,
            self.base_color(triangle, material, barycentrics, 0.0).w,
        )
    }

    /// Base colour and emitted radiance of a point of a live triangle, read over `area` (a share of
    /// the triangle's).
    pub(crate) fn look(&self, triangle: u32, uv: [f32; 2], area: f32) -> (Vec3, Vec3) {
        let material = self.scene.material(self.scene.triangles[triangle as usize]);
        let barycentrics = Vec3::new(1.0 - uv[0] - uv[1], uv[0], uv[1]);
        let base = self.base_color(triangle, material, barycentrics, area);
        let glow = self.at(triangle, material, barycentrics, area).emission;
        (base.xyz(), glow)
    }

    /// Whether a live triangle looks the same everywhere.
    pub(crate) fn uniform(&self, triangle: u32) -> bool {
        let key = self.scene.triangles[triangle as usize];
        let m = self.scene.material(key);
        self.scene.objects[key.object as usize].colors.is_empty()
            && m.base_color_texture.is_none()
            && m.metallic_texture.is_none()
            && m.emissive_texture.is_none()
    }

    /// Mean over part of a live triangle, given points spread evenly over that part.
    ///
    /// Textures are read at the level where the points' footprints cover the part. `share` is the
    /// part's share of the triangle's area.
    pub(crate) fn average(&self, triangle: u32, points: &[Vec3], share: f32) -> Diffuse {
        let points = if self.uniform(triangle) {
            &points[..1]
        } else {
            points
        };
        let key = self.scene.triangles[triangle as usize];
        let material = self.scene.material(key);
        let area_per_point = share / points.len() as f32;
        let mut sum = Diffuse::default();
        for &p in points {
            let at = self.at(triangle, material, p, area_per_point);
            sum.reflectance += at.reflectance * at.coverage;
            sum.emission += at.emission * at.coverage;
            sum.coverage += at.coverage;
        }
        // Light that meets the surface meets its opaque part: the mean over that part.
        let inverse = if sum.coverage > 0.0 {
            1.0 / sum.coverage
        } else {
            0.0
        };
        Diffuse {
            reflectance: sum.reflectance * inverse,
            emission: sum.emission * inverse,
            coverage: sum.coverage / points.len() as f32,
        }
    }

    fn at(&self, triangle: u32, material: &Material, barycentrics: Vec3, area: f32) -> Diffuse {
        let base = self.base_color(triangle, material, barycentrics, area);
        let coverage = stopped(material, base.w);
        if material.unlit {
            return Diffuse {
                coverage,
                ..Diffuse::default()
            };
        }
        let read = |slot: &Option<TextureRef>, pyramids: &[Option<Arc<Pyramid>>]| {
            slot.as_ref().map_or(Vec4::ONE, |s| {
                self.read(triangle, s, pyramids, barycentrics, area)
            })
        };
        let metallic = material.metallic * read(&material.metallic_texture, &self.pyramids.data).z;
        Diffuse {
            reflectance: base.xyz() * (1.0 - metallic),
            emission: material.emissive
                * read(&material.emissive_texture, &self.pyramids.color).xyz(),
            coverage,
        }
    }

    fn base_color(
        &self,
        triangle: u32,
        material: &Material,
        barycentrics: Vec3,
        area: f32,
    ) -> Vec4 {
        let key = self.scene.triangles[triangle as usize];
        let object = &self.scene.objects[key.object as usize];
        let mut color = material.base_color;
        if !object.colors.is_empty() {
            let [a, b, c] =
                object.triangles[key.triangle as usize].map(|v| object.colors[v as usize]);
            color *= a * barycentrics.x + b * barycentrics.y + c * barycentrics.z;
        }
        if let Some(slot) = &material.base_color_texture {
            color *= self.read(triangle, slot, &self.pyramids.color, barycentrics, area);
        }
        color.clamp(Vec4::ZERO, Vec4::ONE)
    }

    /// A texture at a point of a triangle, averaged over `area` (a share of the triangle's).
    fn read(
        &self,
        triangle: u32,
        slot: &TextureRef,
        pyramids: &[Option<Arc<Pyramid>>],
        barycentrics: Vec3,
        area: f32,
    ) -> Vec4 {
        let key = self.scene.triangles[triangle as usize];
        let object = &self.scene.objects[key.object as usize];
        let Some(pyramid) = &pyramids[slot.texture.0 as usize] else {
            return Vec4::ONE;
        };
        let Some(uvs) = object
            .uvs
            .get(slot.uv_set as usize)
            .filter(|u| !u.is_empty())
        else {
            return Vec4::ONE;
        };
        let [a, b, c] = object.triangles[key.triangle as usize]
            .map(|v| slot.transform.transform_point2(uvs[v as usize]));
        let at = a * barycentrics.x + b * barycentrics.y + c * barycentrics.z;
        if !at.is_finite() {
            return Vec4::ONE;
        }
        let uv_area = 0.5 * Vec2::perp_dot(b - a, c - a).abs() * area;
        pyramid.sample(at, uv_area)
    }
}

/// How much of the light alpha stops.
fn stopped(material: &Material, alpha: f32) -> f32 {
    match material.alpha {
        AlphaMode::Opaque => 1.0,
        AlphaMode::Mask(cutoff) => f32::from(alpha >= cutoff),
        AlphaMode::Blend => alpha,
    }
}
