//! Few emitters, against form factors in closed form of what a point sees of them.

use glam::{Affine2, DVec3, Vec2, Vec3, Vec4};

use super::{Emitters, Group, Receiver};
use crate::radiosity::bvh::BvhQuality;
use crate::radiosity::element::{ElementId, Elements};
use crate::radiosity::emitter_tree::EmitterTree;
use crate::radiosity::form_factor::{clip, point_to_polygon};
use crate::radiosity::gradient::Arrived;
use crate::radiosity::layout::Layout;
use crate::radiosity::occlusion::{Hierarchy, Holds, NO_TRIANGLE, OFFSET, Occluders};
use crate::radiosity::scene::{
    AlphaMode, Material, MaterialId, Object, Scene, Texture, TextureId, TextureRef, Wrap,
};
use crate::radiosity::settings::BakeSettings;
use crate::radiosity::surface::{Pyramids, Surfaces};
use crate::radiosity::validate::ValidScene;

/// A scene ready to be asked for the light of its emitters.
struct Stage<'s> {
    scene: &'s ValidScene,
    elements: &'s Elements,
    occluders: Occluders<'s>,
    tree: &'s EmitterTree,
}

/// Sets a scene up, cut into about so many elements.
fn on_stage(scene: Scene, elements: u32, ask: impl Fn(&Stage)) {
    let scene = scene.validate().expect("a scene to bake");
    let pyramids = Pyramids::new(&scene, None);
    let surfaces = Surfaces::new(&scene, &pyramids);
    let settings = BakeSettings {
        elements,
        ..BakeSettings::BALANCED
    };
    let layout = Layout::even(&scene, &settings);
    let elements = Elements::new(&scene, &surfaces, &layout, 0.9);
    let hierarchy = Hierarchy::new(&scene, &surfaces, Holds::Casting, BvhQuality::Quick);
    let occluders = Occluders::new(&hierarchy, &surfaces);
    let settings = BakeSettings {
        refine: false,
        ..BakeSettings::BALANCED
    };
    let tree = EmitterTree::new(&scene, &elements, &occluders, &settings, &());
    let tree = tree.expect("nobody cancels");
    assert!(tree.few() && tree.len() > 0);
    ask(&Stage {
        scene: &scene,
        elements: &elements,
        occluders,
        tree: &tree,
    });
}

impl Stage<'_> {
    /// A receiver at a point of the scene as it was given.
    fn receiver(&self, point: Vec3, normal: Vec3) -> Receiver {
        let inside = (point.as_dvec3() - self.scene.center) / f64::from(self.scene.scale);
        Receiver {
            position: inside.as_vec3() + normal * OFFSET,
            normal,
            triangle: NO_TRIANGLE,
        }
    }

    /// Light (irradiance / π) at each receiver of a group, and how many rays that took.
    fn light(&self, receivers: &[Receiver], rays: u32, seed: u32) -> (Vec<f64>, u64) {
        let settings = BakeSettings {
            refine: false,
            ..BakeSettings::BALANCED
        };
        let emitters = Emitters::at_samples(self.tree, &settings);
        let receivers: Vec<_> = (0..).zip(receivers.iter().copied()).collect();
        let group = Group {
            receivers: &receivers,
            blocks: receivers.len() as u32,
            rays,
            seed,
            gradients: false,
        };
        let mut light = vec![0.0; receivers.len()];
        let found = |k: usize, e: u32, share: Arrived| {
            light[k] += f64::from(share.light * self.elements.emission[e as usize].x);
        };
        let traced = emitters
            .light(self.elements, &self.occluders, &group, found)
            .rays;
        (light, traced)
    }

    /// The light that the elements of an object bring if nothing is between.
    fn unshadowed(&self, receiver: &Receiver, object: usize) -> f64 {
        let (here, up) = (receiver.position.as_dvec3(), receiver.normal.as_dvec3());
        let of = |e: usize| {
            let pieces = self.elements.shape(self.scene, ElementId(e as u32));
            let factor = |(_, [a, b, c], normal): (u32, [Vec3; 3], Vec3)| {
                let front = (b - a).cross(c - a).dot(normal) > 0.0;
                let corners = if front { [a, b, c] } else { [a, c, b] };
                point_to_polygon(here, up, &corners.map(|p| p.as_dvec3()))
            };
            f64::from(self.elements.emission[e].x) * pieces.map(factor).sum::<f64>()
        };
        self.elements.of_object(object).map(of).sum()
    }
}

/// The quad `a`, `a + u`, `a + u + v`, `a + v`, facing `u × v`.
fn quad(a: Vec3, u: Vec3, v: Vec3, material: u32) -> Object {
    Object {
        positions: vec![a, a + u, a + u + v, a + v],
        uvs: vec![vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: MaterialId(material),
        ..Object::default()
    }
}

fn shining(radiance: f32) -> Material {
    Material {
        emissive: Vec3::splat(radiance),
        ..Material::default()
    }
}

/// The scene's only texture.
fn image() -> TextureRef {
    TextureRef {
        texture: TextureId(0),
        uv_set: 0,
        transform: Affine2::IDENTITY,
    }
}

/// A black floor of 4 × 4 m and a square lamp that faces it from 1 m above, its middle at the
/// origin; then what else there is.
fn under_lamp(lamp: Material, others: Vec<(Object, Material)>) -> Scene {
    let floor = quad(Vec3::new(-2.0, 0.0, -2.0), 4.0 * Vec3::Z, 4.0 * Vec3::X, 0);
    let square = quad(Vec3::new(-0.2, 1.0, -0.2), 0.4 * Vec3::X, 0.4 * Vec3::Z, 1);
    let mut scene = Scene {
        objects: vec![floor, square],
        materials: vec![Material::default(), lamp],
        ..Scene::default()
    };
    for (mut object, material) in others {
        object.material = MaterialId(scene.materials.len() as u32);
        scene.objects.push(object);
        scene.materials.push(material);
    }
    scene
}

/// Points spread over a rectangle of the floor.
fn spread(stage: &Stage, low: Vec3, size: f32, side: u32) -> Vec<Receiver> {
    let at = |i: u32| (i as f32 + 0.5) / side as f32 * size;
    (0..side * side)
        .map(|i| low + Vec3::new(at(i % side), 0.0, at(i / side)))
        .map(|p| stage.receiver(p, Vec3::Y))
        .collect()
}

/// Each to `tolerance` of itself.
fn assert_unshadowed(stage: &Stage, receivers: &[Receiver], rays: u32, tolerance: f64) {
    let (light, traced) = stage.light(receivers, rays, 7);
    assert!(traced > 0);
    for (found, receiver) in light.into_iter().zip(receivers) {
        let truth = stage.unshadowed(receiver, 1);
        let error = (found - truth).abs();
        assert!(error <= tolerance * truth, "{receiver:?}: {found}, {truth}");
    }
}

#[test]
fn light_without_shadow_is_exact() {
    on_stage(under_lamp(shining(5.0), vec![]), 100, |stage| {
        let floor = spread(stage, Vec3::new(-2.0, 0.0, -2.0), 4.0, 8);
        assert_unshadowed(stage, &floor, 1, 1e-5);
        // Closer to the lamp than it is wide, down to where it is touched.
        for distance in [0.1, 1e-2, 1e-3, 1e-5] {
            let near = |x| stage.receiver(Vec3::new(x, 1.0 - distance, 0.05), Vec3::Y);
            assert_unshadowed(stage, &[-0.1, 0.1, 0.19].map(near), 1, 1e-5);
        }
    });
}

#[test]
fn a_wall_that_the_lamp_touches() {
    let wall = quad(Vec3::new(0.2, 0.0, -2.0), 4.0 * Vec3::Z, Vec3::Y, 0);
    let scene = under_lamp(shining(5.0), vec![(wall, Material::default())]);
    on_stage(scene, 100, |stage| {
        let down = [0.5, 0.1, 1e-2, 1e-3, 1e-4];
        let wall = down.map(|y| stage.receiver(Vec3::new(0.2, 1.0 - y, 0.03), Vec3::NEG_X));
        assert_unshadowed(stage, &wall, 1, 1e-5);
        let level = stage.unshadowed(&wall[4], 1);
        assert!((level / 2.5 - 1.0).abs() < 0.01, "{level}");
    });
}

#[test]
fn behind_a_lamp_and_in_its_plane() {
    for double_sided in [false, true] {
        let lamp = Material {
            double_sided,
            ..shining(5.0)
        };
        on_stage(under_lamp(lamp, vec![]), 100, |stage| {
            let receiver = |p: Vec3, n: Vec3| stage.receiver(p, n);
            let above = Vec3::new(0.3, 1.5, 0.1);
            assert_eq!(stage.light(&[receiver(above, Vec3::Y)], 4, 1).0, [0.0]);
            let back = [receiver(above, Vec3::NEG_Y)];
            let (light, _) = stage.light(&back, 4, 1);
            let truth = stage.unshadowed(&back[0], 1);
            assert_eq!(truth > 0.0, double_sided);
            assert!(
                (light[0] - truth).abs() <= 1e-5 * truth,
                "{light:?} {truth}"
            );
            // In the plane of the lamp: beside it, facing it; beside it and on it, facing along.
            let beside = Vec3::new(0.5, 1.0, 0.1);
            for (point, normal) in [
                (beside, Vec3::NEG_X),
                (beside, Vec3::NEG_Y),
                (Vec3::new(0.1, 1.0, 0.1), Vec3::NEG_Y),
            ] {
                let (light, _) = stage.light(&[receiver(point, normal)], 4, 1);
                assert!(light[0] < 1e-3, "{point} {normal}: {light:?}");
            }
        });
    }
}

/// A lamp that is bright on one side and dark on the other, on many elements.
#[test]
fn textured_lamps_shine_by_element() {
    let texels = [255, 90, 20, 0];
    let texture = Texture {
        name: "stripes".into(),
        width: 4,
        height: 1,
        texels: texels.map(|t| [t, t, t, 255]).to_vec(),
        wrap: [Wrap::Repeat; 2],
    };
    let lamp = Material {
        emissive_texture: Some(image()),
        ..shining(5.0)
    };
    let mut scene = under_lamp(lamp, vec![]);
    scene.textures.push(texture);
    on_stage(scene, 10_000, |stage| {
        assert!(stage.elements.of_object(1).len() > 50);
        let floor = spread(stage, Vec3::new(-0.4, 0.0, -0.4), 0.8, 2);
        let count = 200;
        let mut sums = vec![(0.0, 0.0); floor.len()];
        for seed in 0..count {
            let (light, traced) = stage.light(&floor, 32, seed);
            // Shadow is asked for in the first round alone, by 40 rays to either triangle.
            assert!(traced <= 2 * 40, "{traced}");
            for (sum, found) in sums.iter_mut().zip(light) {
                *sum = (sum.0 + found, sum.1 + found * found);
            }
        }
        for (receiver, (sum, squares)) in floor.iter().zip(sums) {
            let truth = stage.unshadowed(receiver, 1);
            let mean = sum / f64::from(count);
            let spread = (squares / f64::from(count) - mean * mean).max(0.0).sqrt();
            // The truth takes elements that two stripes share for even.
            assert!((mean / truth - 1.0).abs() < 0.006, "{mean}, {truth}");
            assert!(spread < 0.06 * truth, "{spread} of {truth}");
        }
    });
}

/// All of a veil lets half of the light pass; a grating all of the light at half the points.
#[test]
fn veils_and_gratings() {
    let above = || quad(Vec3::new(-2.0, 0.5, -2.0), 4.0 * Vec3::Z, 4.0 * Vec3::X, 0);
    let veil = Material {
        base_color: Vec4::new(0.0, 0.0, 0.0, 0.5),
        alpha: AlphaMode::Blend,
        ..Material::default()
    };
    on_stage(
        under_lamp(shining(5.0), vec![(above(), veil)]),
        100,
        |stage| {
            let floor = spread(stage, Vec3::new(-1.0, 0.0, -1.0), 2.0, 4);
            let (light, traced) = stage.light(&floor, 64, 3);
            for (found, receiver) in light.into_iter().zip(&floor) {
                let truth = 0.5 * stage.unshadowed(receiver, 1);
                assert!((found / truth - 1.0).abs() < 1e-5, "{found}, {truth}");
            }
            // One round was enough.
            assert!(traced <= 16 * 32, "{traced}");
        },
    );
    let grating = Material {
        base_color_texture: Some(image()),
        alpha: AlphaMode::Mask(0.5),
        ..Material::default()
    };
    // Through three of its bars a receiver sees the lamp.
    let mut fine = above();
    fine.uvs[0].iter_mut().for_each(|uv| *uv *= 60.0);
    let mut scene = under_lamp(shining(5.0), vec![(fine, grating)]);
    scene.textures.push(Texture {
        name: "bars".into(),
        width: 2,
        height: 1,
        texels: vec![[255; 4], [255, 255, 255, 0]],
        wrap: [Wrap::Repeat; 2],
    });
    on_stage(scene, 100, |stage| {
        let floor = spread(stage, Vec3::new(-0.5, 0.0, -0.5), 1.0, 8);
        let truth: f64 = floor.iter().map(|r| 0.5 * stage.unshadowed(r, 1)).sum();
        let mut sum = 0.0;
        for seed in 0..16 {
            let (light, traced) = stage.light(&floor, 64, seed);
            assert_eq!(traced, 64 * 64);
            let found: f64 = light.iter().sum();
            // By chance one of 4,096 rays is off by half, all of them by a 128th.
            assert!((found / truth - 1.0).abs() < 0.04, "{found}, {truth}");
            sum += found / 16.0;
        }
        assert!((sum / truth - 1.0).abs() < 0.01, "{sum}, {truth}");
    });
}

/// A wide sheet half way up hides the lamp beyond its edge, the line x = 0.
fn half_hidden() -> Scene {
    let sheet = quad(Vec3::new(0.0, 0.5, -2.0), 4.0 * Vec3::Z, 2.0 * Vec3::X, 0);
    under_lamp(shining(5.0), vec![(sheet, Material::default())])
}

/// The light of what a receiver below that sheet sees of the lamp.
fn beside_sheet(stage: &Stage, receiver: &Receiver) -> f64 {
    let here = receiver.position.as_dvec3();
    let edge = stage
        .receiver(Vec3::new(0.0, 0.5, 0.0), Vec3::ZERO)
        .position;
    let out = DVec3::Z.cross(edge.as_dvec3() - here);
    let lamp = [(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)]
        .map(|(x, z)| stage.receiver(Vec3::new(x, 1.0, z), Vec3::ZERO).position);
    let mut seen = Vec::new();
    clip(
        &lamp.map(|p| p.as_dvec3()),
        |p| out.dot(p - here),
        |p| seen.push(p),
    );
    5.0 * point_to_polygon(here, receiver.normal.as_dvec3(), &seen)
}

/// Groups of receivers all over a penumbra and beside it, as narrow as a point or wide, and as
/// triangles and elements of a bake have them: of none is the light, mean over many seeds, off by
/// half a percent of what it is without shadow.
#[test]
fn penumbrae_are_not_hardened_by_rounds() {
    on_stage(half_hidden(), 100, |stage| {
        for (side, rays) in [(2, 24), (3, 24), (2, 64), (4, 64)] {
            let (mut worst, mut traced, mut all) = (0.0_f64, 0, 0);
            for (size, step) in [1e-3, 0.05, 0.2]
                .into_iter()
                .flat_map(|size| (-15..15).map(move |step| (size, step)))
            {
                let low = Vec3::new(0.02 * step as f32, 0.0, 0.1);
                let group = spread(stage, low, size, side);
                let seeds = 300;
                let mut found = 0.0;
                for seed in 0..seeds {
                    let (light, cost) = stage.light(&group, rays, seed);
                    found += light.iter().sum::<f64>() / f64::from(seeds);
                    traced += cost;
                    all += u64::from(rays * side * side);
                }
                let truth: f64 = group.iter().map(|r| beside_sheet(stage, r)).sum();
                let whole: f64 = group.iter().map(|r| stage.unshadowed(r, 1)).sum();
                worst = worst.max(((found - truth) / whole).abs());
            }
            assert!(worst < 0.005, "{side}² × {rays} rays: {worst}");
            assert!(traced < all);
        }
    });
}
