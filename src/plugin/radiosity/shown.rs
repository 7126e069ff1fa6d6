//! What meshes carry for a [`FrescoView`] in the place of their light.

use bevy::mesh::PrimitiveTopology;
use bevy::prelude::*;

use super::survey::FoundObject;
use crate::plugin::{ATTRIBUTE_BAKED_LIGHT, FrescoView};
use crate::radiosity::{Bake, ElementLight, ElementTriangle, ObjectLight, VertexSource};

/// What all objects are shown beside.
pub(super) struct Shown {
    view: FrescoView,
    /// The error asked for.
    asked: f32,
    /// Of all vertices: luminance of light, and samples a square metre.
    mean_light: f32,
    mean_samples: f32,
    elements: Option<ElementLight>,
}

/// Below this share of the mean, errors are told beside that.
const DARK: f32 = 0.1;

/// The scales end at so many times their middle.
const ERRORS: f32 = 4.0;
const SAMPLES: f32 = 8.0;

impl Shown {
    pub(super) fn new(
        view: FrescoView,
        bake: &Bake,
        asked: f32,
        elements: Option<ElementLight>,
    ) -> Self {
        let samples = || bake.objects.iter().flat_map(|o| &o.quality);
        let count = samples().count().max(1) as f32;
        Self {
            view,
            asked,
            mean_light: bake.report.mean_light,
            mean_samples: samples().map(|q| q.samples).sum::<f32>() / count,
            elements,
        }
    }

    /// The values at vertices that are shown of an object's light.
    pub(super) fn values(&self, light: &ObjectLight) -> Vec<Vec3> {
        let quality = light.light.iter().zip(&light.quality);
        match self.view {
            FrescoView::Error => quality
                .map(|(&light, quality)| {
                    let light = LinearRgba::from_vec3(light).luminance();
                    let level = light.max(DARK * self.mean_light);
                    let share = quality.error / (level * self.asked).max(f32::MIN_POSITIVE);
                    heat(share.sqrt() / ERRORS.sqrt())
                })
                .collect(),
            FrescoView::Samples => quality
                .map(|(_, quality)| {
                    let times = quality.samples / self.mean_samples.max(f32::MIN_POSITIVE);
                    heat(0.5 + 0.5 * times.max(f32::MIN_POSITIVE).log(SAMPLES))
                })
                .collect(),
            FrescoView::Sources => quality
                .map(|(_, quality)| match quality.source {
                    VertexSource::Sampled => Vec3::splat(0.2),
                    VertexSource::Filled => Vec3::new(0.9, 0.7, 0.05),
                    VertexSource::Buried => Vec3::new(0.9, 0.03, 0.03),
                })
                .collect(),
            _ => light.light.clone(),
        }
    }

    /// The elements of an object, if these are shown, in its own space.
    pub(super) fn elements(&self, object: usize, found: &FoundObject) -> Option<Mesh> {
        let elements = self.elements.as_ref()?;
        let to_local = found.transform.inverse();
        let element = |t: &ElementTriangle| &elements.elements[t.element as usize];
        let all = elements.triangles();
        let first = all.partition_point(|t| (element(t).object.0 as usize) < object);
        let own = (all[first..].iter()).take_while(|t| element(t).object.0 as usize == object);
        let mut mesh = Pieces::default();
        for triangle in own.filter(|triangle| !triangle.back) {
            let tint = if triangle.element % 2 == 0 { 1.0 } else { 0.85 };
            mesh.push(triangle, element(triangle).irradiance * tint, &to_local);
        }
        Some(mesh.build(&found.mesh.asset))
    }
}

#[derive(Default)]
struct Pieces {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    light: Vec<[f32; 3]>,
}

impl Pieces {
    fn push(&mut self, triangle: &ElementTriangle, light: Vec3, to_local: &bevy::math::Affine3A) {
        // Normals go over by the inverse transposed of what positions go over by.
        let normals = to_local.matrix3.inverse().transpose();
        let normal = (normals * triangle.normal).normalize_or_zero();
        for corner in triangle.corners {
            self.positions.push(to_local.transform_point3(corner));
            self.normals.push(normal);
            self.light.push(light.to_array());
        }
    }

    fn build(self, source: &Mesh) -> Mesh {
        Mesh::new(PrimitiveTopology::TriangleList, source.asset_usage)
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, self.positions)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, self.normals)
            .with_inserted_attribute(ATTRIBUTE_BAKED_LIGHT, self.light)
    }
}

/// From blue for 0 by green for ½ to red for 1.
fn heat(share: f32) -> Vec3 {
    let hue = 240.0 * (1.0 - share.clamp(0.0, 1.0));
    Color::hsl(hue, 1.0, 0.5).to_linear().to_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_have_their_middle_where_they_say() {
        let green = heat(0.5);
        assert!(green.y > 0.9 && green.x < 0.01 && green.z < 0.01, "{green}");
        assert!(heat(0.0).z > 0.9 && heat(1.0).x > 0.9 && heat(7.0) == heat(1.0));
    }
}
