//! Light as vertex colours, which any viewer shows.

use glam::Vec3;

use super::{glb::Glb, instances::Target, materials::UnlitMaterials};
use crate::gltf::{
    GltfError,
    accessor_json::{AccessorData, ElementKind},
};

/// Turns light into vertex colours on unlit materials.
pub(super) struct Painter {
    exposure: f64,
    materials: UnlitMaterials,
    painted: usize,
    clamped: usize,
}

impl Painter {
    /// For primitives that all have meshes of their own already.
    pub(super) fn new(glb: &Glb, targets: &[Target], exposure: f32) -> Result<Self, GltfError> {
        if !(exposure > 0.0 && exposure.is_finite()) {
            return Err(glb.refuse(format!("the exposure must be above 0, not {exposure}")));
        }
        Ok(Self {
            exposure: exposure.into(),
            materials: UnlitMaterials::new(glb, targets),
            painted: 0,
            clamped: 0,
        })
    }

    /// The new vertex colours of a primitive, whose material becomes unlit.
    ///
    /// `None` if it was unlit before: such surfaces look the same in any light.
    pub(super) fn paint(
        &mut self,
        glb: &mut Glb,
        target: Target,
        old: Option<&AccessorData>,
        light: &[Vec3],
    ) -> Option<AccessorData> {
        let folded = self.materials.assign(glb, target)?;
        let emission = folded.map_or([0.0; 3], |folded| folded.emission);
        let base = folded.map_or([1.0; 3], |folded| folded.base);
        let old = old.filter(|old| old.kind.width() >= 3);
        let alpha = old.filter(|old| old.kind == ElementKind::VEC4);
        let kind = alpha.map_or(ElementKind::VEC3, |old| old.kind);
        let mut values = Vec::with_capacity(light.len() * kind.width());
        for (vertex, light) in light.iter().enumerate() {
            let color = |channel| old.map_or(1.0, |old| old.element(vertex)[channel]);
            let exact = [0, 1, 2].map(|channel| {
                let reflected = base[channel] * color(channel) * f64::from(light[channel]);
                self.exposure * (emission[channel] + reflected)
            });
            self.painted += 1;
            self.clamped += usize::from(exact.iter().any(|&value| value > 1.0));
            values.extend(exact.map(|value| number(value).clamp(0.0, 1.0)));
            values.extend(alpha.map(|old| number(old.element(vertex)[3]).clamp(0.0, 1.0)));
        }
        Some(AccessorData { kind, values })
    }

    /// Says how much was too bright.
    pub(super) fn finish(self, glb: &mut Glb) {
        if self.clamped > 0 {
            glb.notes.push(format!(
                "{} of {} vertices are brighter than white and were cut off: lower the exposure, \
                 now {}",
                self.clamped, self.painted, self.exposure
            ));
        }
    }
}

/// Vertex colours of the file may be anything, the new ones must be numbers.
fn number(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value }
}
