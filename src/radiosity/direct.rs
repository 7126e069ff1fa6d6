use glam::Vec3;

use super::element::{ElementId, Elements, element_seed};
use super::emitter::{Emitters, Receiver};
use super::illumination::illumination;
use super::observer::{Observer, Stage};
use super::occlusion::{OFFSET, Occluders};
use super::parallel::{Cancelled, map_ranges};
use super::sampling::{hash, sobol};
use super::validate::ValidScene;

/// Elements a thread takes at a time.
const CHUNK: usize = 64;

/// Points on an element at which lights without a surface are tested.
const POINTS: u32 = 4;

/// Direct light (irradiance / π) at each element: lights, sampled emitters, and what the
/// form-factor rays `found` of sky and emitters.
pub(crate) fn direct(
    scene: &ValidScene,
    occluders: &Occluders,
    elements: &Elements,
    emitters: &Emitters,
    found: &[Vec3],
    seed: u32,
    observer: &dyn Observer,
) -> Result<Vec<Vec3>, Cancelled> {
    let chunks = map_ranges(elements.len(), CHUNK, Stage::Direct, observer, |range| {
        range
            .map(|e| {
                found[e]
                    + at_element(
                        scene,
                        occluders,
                        elements,
                        emitters,
                        ElementId(e as u32),
                        seed,
                    )
            })
            .collect::<Vec<_>>()
    })?;
    Ok(chunks.concat())
}

/// Mean over points spread over the element; the light samples are shared out among them.
fn at_element(
    scene: &ValidScene,
    occluders: &Occluders,
    elements: &Elements,
    emitters: &Emitters,
    element: ElementId,
    seed: u32,
) -> Vec3 {
    let seed = element_seed(element, hash(seed, 1));
    let share = emitters.samples.div_ceil(POINTS);
    let mut sum = Vec3::ZERO;
    for i in 0..POINTS {
        let [u, v, ..] = sobol(i, 0, seed);
        let point = elements.point(scene, element, u, v);
        let receiver = Receiver {
            position: point.position + point.normal * OFFSET,
            normal: point.normal,
            triangle: point.triangle,
        };
        for (l, light) in scene.lights.iter().enumerate() {
            let at = (hash(seed, l as u32), i);
            sum += light.power * illumination(light, occluders, &receiver, at, &mut 0);
        }
        sum += emitters.sample(
            elements,
            occluders,
            &receiver,
            seed,
            i * share..(i + 1) * share,
        );
    }
    sum / POINTS as f32
}
