//! Hemicubes against exact form factors and against rays.

mod accuracy;
mod rooms;

use glam::Vec3;

use super::*;
use crate::radiosity::bvh::BvhQuality;
use crate::radiosity::element::Elements;
use crate::radiosity::emitter::Emitters;
use crate::radiosity::emitter_tree::EmitterTree;
use crate::radiosity::layout::Layout;
use crate::radiosity::occlusion::{Hierarchy, Holds, Occluders};
use crate::radiosity::scene::{Material, Object, Scene};
use crate::radiosity::settings::BakeSettings;
use crate::radiosity::surface::{Pyramids, Surfaces};

/// Looks at a scene under a white sky.
fn look<T>(scene: &Scene, settings: &BakeSettings, at: impl FnOnce(View) -> T) -> T {
    let mut scene = scene.clone();
    scene.sky = Vec3::ONE;
    let scene = scene.validate().expect("the scene is sound");
    let pyramids = Pyramids::new(&scene, None);
    let surfaces = Surfaces::new(&scene, &pyramids);
    let layout = Layout::even(&scene, settings);
    let elements = Elements::new(&scene, &surfaces, &layout, settings.max_reflectance);
    let hierarchy = Hierarchy::new(&scene, &surfaces, Holds::Casting, BvhQuality::Best);
    let occluders = Occluders::new(&hierarchy, &surfaces);
    let tree =
        EmitterTree::new(&scene, &elements, &occluders, settings, &()).expect("nobody cancels");
    at(View {
        scene: &scene,
        occluders,
        elements: &elements,
        emitters: Emitters::at_elements(&tree, settings),
        marks: &vec![false; elements.len()],
        settings,
        remember: false,
    })
}

fn settings(elements: u32, seed: u32) -> BakeSettings {
    BakeSettings {
        elements,
        seed,
        refine: false,
        adapt: false,
        ..BakeSettings::BALANCED
    }
}

/// The quad `a`, `a + u`, `a + u + v`, `a + v`, facing `u × v`.
fn quad(a: Vec3, u: Vec3, v: Vec3) -> Object {
    Object {
        positions: vec![a, a + u, a + u + v, a + v],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Object::default()
    }
}

fn scene(objects: Vec<Object>) -> Scene {
    Scene {
        objects,
        materials: vec![Material::default()],
        ..Scene::default()
    }
}
