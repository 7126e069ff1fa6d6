//! Parts of the light against the whole of it, and how sure vertices say they are against how far off they are.

use glam::Vec3;

use super::baker::Baker;
use super::baker_test::{quad, room};
use super::{
    Bake, BakeSettings, Contribution, DirectLight, Light, LightKind, Material, MaterialId, Scene,
    VertexSource, bake,
};

const SETTINGS: BakeSettings = BakeSettings {
    elements: 1500,
    refine: false,
    directional: true,
    ..BakeSettings::DRAFT
};

fn baked(scene: &Scene, settings: BakeSettings) -> Bake {
    bake(&scene.clone().validate().unwrap(), &settings, &()).unwrap()
}

fn part(scene: &Scene, contribution: Contribution) -> Bake {
    let settings = BakeSettings {
        contribution,
        ..SETTINGS
    };
    baked(scene, settings)
}

fn light(bake: &Bake) -> impl Iterator<Item = Vec3> {
    bake.objects.iter().flat_map(|o| o.light.iter().copied())
}

fn gradient(bake: &Bake) -> impl Iterator<Item = Vec3> {
    (bake.objects.iter()).flat_map(|o| o.gradient.iter().copied())
}

fn rms(values: impl Iterator<Item = Vec3>) -> f32 {
    let (sum, count) = values.fold((0.0, 0), |(s, n), v| (s + v.length_squared(), n + 1));
    (sum / count as f32).sqrt()
}

#[test]
fn direct_and_indirect_light_add_up() {
    let scene = room();
    let all = part(&scene, Contribution::All);
    let direct = part(&scene, Contribution::Direct);
    let indirect = part(&scene, Contribution::Indirect);
    // Rays are the same, and fits are linear but for how each smooths and how far it may overshoot.
    let rest = (light(&all).zip(light(&direct)).zip(light(&indirect))).map(|((a, d), i)| a - d - i);
    let apart = rms(rest) / rms(light(&all));
    assert!(apart < 0.03, "light: {apart}");
    let rest = gradient(&all)
        .zip(gradient(&direct))
        .zip(gradient(&indirect));
    let apart = rms(rest.map(|((a, d), i)| a - d - i)) / rms(gradient(&all));
    assert!(apart < 0.05, "gradients: {apart}");
    for (name, part) in [("direct", &direct), ("indirect", &indirect)] {
        let share = rms(light(part)) / rms(light(&all));
        assert!(share > 0.1 && share < 0.99, "{name}: {share}");
    }
}

#[test]
fn direct_light_knows_no_walls() {
    // A floor beside a white wall, under a sun along the wall.
    let [x, y, z] = Vec3::AXES;
    let white = Material {
        base_color: Vec3::splat(0.9).extend(1.0),
        ..Material::default()
    };
    let sun = Light {
        power: Vec3::splat(3.0),
        kind: LightKind::Directional { direction: -y },
        ..Light::default()
    };
    let mut scene = Scene {
        objects: vec![
            quad(1, [Vec3::ZERO, z, x], 8, 0),
            quad(2, [Vec3::ZERO, y, z], 8, 0),
        ],
        materials: vec![white],
        lights: vec![sun],
        ..Scene::default()
    };
    let direct = part(&scene, Contribution::Direct);
    for value in &direct.objects[0].light {
        let truth = 3.0 / std::f32::consts::PI;
        assert!((value.x / truth - 1.0).abs() < 1e-4, "{value} for {truth}");
    }
    assert!(direct.objects[1].light.iter().all(|l| *l == Vec3::ZERO));
    let indirect = part(&scene, Contribution::Indirect);
    assert!(indirect.objects[1].light.iter().all(|l| l.x > 0.0));
    // What is left to the engine stays out of the direct part.
    scene.lights[0].direct = DirectLight::Realtime;
    let direct = part(&scene, Contribution::Direct);
    assert!(light(&direct).all(|l| l == Vec3::ZERO));
}

#[test]
fn another_part_takes_no_ray() {
    let mut baker = Baker::new(SETTINGS);
    baker.bake(room(), &()).unwrap();
    for contribution in [
        Contribution::Direct,
        Contribution::Indirect,
        Contribution::All,
    ] {
        baker.set_settings(BakeSettings {
            contribution,
            vertex_quality: true,
            ..SETTINGS
        });
        let resumed = baker.bake(room(), &()).unwrap();
        assert_eq!(resumed.report.work.rays(), 0, "{contribution:?}");
        assert_eq!(resumed.report.work.sweeps, 0, "{contribution:?}");
        let (scratch, _) = baker.scratch().unwrap();
        for (a, b) in resumed.objects.iter().zip(&scratch.objects) {
            assert_eq!(a.light, b.light, "{contribution:?}");
            assert_eq!(a.quality, b.quality, "{contribution:?}");
        }
    }
}

#[test]
fn vertices_know_how_sure_they_are() {
    let scene = room();
    let settings = BakeSettings {
        vertex_quality: true,
        ..SETTINGS
    };
    let other = BakeSettings {
        seed: 77,
        ..settings.clone()
    };
    let (a, b) = (baked(&scene, settings), baked(&scene, other));
    let told: Vec<Vec3> = (a.objects.iter().flat_map(|o| &o.quality))
        .map(|q| Vec3::splat(q.error))
        .collect();
    assert_eq!(told.len(), light(&a).count());
    // Two bakes differ by √2 times what chance leaves in one; both hold what elements leave as well.
    let luminance = Vec3::new(0.2126, 0.7152, 0.0722);
    let apart = (light(&a).zip(light(&b))).map(|(a, b)| Vec3::splat((a - b).dot(luminance)));
    let (told, found) = (rms(told.into_iter()), rms(apart) / std::f32::consts::SQRT_2);
    assert!(
        told > 0.5 * found && told < 2.0 * found,
        "{told} for {found}"
    );
}

#[test]
fn vertices_inside_geometry_are_told_of() {
    // A floor of one metre, half of it under a closed block, and another wholly inside the block.
    let [x, y, z] = Vec3::AXES;
    let inside = [Vec3::new(0.6, 0.1, 0.1), z * 0.2, x * 0.2];
    let mut scene = Scene {
        objects: vec![quad(1, [Vec3::ZERO, z, x], 8, 0), quad(2, inside, 2, 0)],
        materials: vec![Material::default()],
        lights: vec![Light {
            power: Vec3::ONE,
            kind: LightKind::Directional { direction: -y },
            ..Light::default()
        }],
        ..Scene::default()
    };
    let low = Vec3::new(0.5, -0.5, -0.5);
    let (x, y, z) = (x, y, z * 2.0);
    for (key, face) in (3..).zip([
        [low, x, z],
        [low + y, z, x],
        [low, z, y],
        [low + x, y, z],
        [low, y, x],
        [low + z, x, y],
    ]) {
        let mut face = quad(key, face, 1, 0);
        face.material = MaterialId(0);
        scene.objects.push(face);
    }
    let settings = BakeSettings {
        vertex_quality: true,
        ..SETTINGS
    };
    let bake = baked(&scene, settings);
    let sources = |o: usize| bake.objects[o].quality.iter().map(|q| q.source);
    let count = |o, what| sources(o).filter(|s| *s == what).count();
    assert!(count(0, VertexSource::Sampled) >= 36);
    assert!(count(0, VertexSource::Filled) >= 27);
    assert!(sources(1).all(|s| s == VertexSource::Buried));
    assert_eq!(count(0, VertexSource::Buried), 0);
    let counts = bake.report.counts;
    let all = |what| (0..8).map(|o| count(o, what) as u64).sum::<u64>();
    assert_eq!(all(VertexSource::Filled), counts.filled_vertices);
    assert_eq!(all(VertexSource::Buried), counts.dark_vertices);
    for quality in bake.objects[0].quality.iter() {
        let is_sampled = quality.source == VertexSource::Sampled;
        assert_eq!(quality.samples > 0.0, is_sampled, "{quality:?}");
    }
}
