use glam::Vec3;

use super::Gather;
use crate::radiosity::gathered::{Bundle, NOT_CAST, Shining, TriangleSamples};
use crate::radiosity::gradient::gradient_about_z;
use crate::radiosity::receiver_mesh::ReceiverMesh;
use crate::radiosity::sampling::frame;

impl Gather<'_> {
    /// The gradient of the luminance that rays from a triangle gathered, in the place of the light.
    ///
    /// Directions are not kept: they follow from the seed, and a rebake asks for them again. Of light that
    /// is the same from everywhere, `L`, the gradient is `L/2 n`, so that rays need only tell how theirs
    /// differs from the mean `L` of the triangle,
    ///
    /// ```text
    ///   ┌────────────────────────────────────────┐
    ///   │  G = L/2 n + 1/S Σ_i (L_i − L) g(ω_i)    │
    ///   └────────────────────────────────────────┘
    /// ```
    ///
    /// and the large `g` of rays that graze the surface count only where there is something to see.
    pub(crate) fn gathered_gradient(
        &self,
        bundle: &Bundle,
        mesh: &ReceiverMesh,
        object: usize,
        triangle: usize,
        shining: &Shining,
    ) -> TriangleSamples {
        let taken = bundle.samples.len() as u32;
        let mut samples = TriangleSamples::new(mesh, triangle, taken);
        let Some(patch) = self.patch(mesh, object, triangle) else {
            return samples;
        };
        let patch = patch.with(taken);
        let weight = samples.area / taken.max(1) as f32;
        let rays = self.settings.gather_rays;
        let levels = shining.levels(bundle);
        let cast: u32 = bundle.samples.iter().map(|sample| sample.cast).sum();
        let valid = |&(i, _): &(usize, &f32)| bundle.samples[i / rays as usize].cast > 0;
        let all: f32 = (levels.iter().enumerate().filter(valid))
            .map(|(_, level)| level)
            .sum();
        let mean = all / cast.max(1) as f32;
        for (i, sample) in bundle.samples.iter().enumerate() {
            if sample.cast == 0 {
                samples.invalid += 1;
                continue;
            }
            let first = i as u32 * rays;
            let mut sum = Vec3::Z * (0.5 * mean * rays as f32);
            for ray in first..first + rays {
                // Those not cast see the mean.
                if bundle.ids[ray as usize] != NOT_CAST {
                    let apart = levels[ray as usize] - mean;
                    sum += gradient_about_z(patch.direction(ray)) * apart;
                }
            }
            let around = frame(patch.place(i as u32).1.shading);
            let gradient = around * sum / rays as f32;
            samples.halves[i % 2].add(weight, sample.b, gradient);
        }
        samples
    }
}
