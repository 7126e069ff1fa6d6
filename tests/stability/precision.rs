//! Sizes, distances and gaps at the limits of `f32`.

use bevy_fresco::radiosity::{BakeSettings, ElementLight, Object, Scene};
use glam::Vec3;

use crate::common::{grey, inward_sphere, quad, room, scene, values};
use crate::solved::{apart, baked, differences, of_object, solved};

/// A room with a lamp below its ceiling and a sheet across it.
fn furnished() -> Scene {
    let mut objects = room(Vec3::new(1.0, 0.7, 1.3), 3, [0; 6]);
    objects.push(quad("lamp", Vec3::new(0.3, 0.6, 0.4), Vec3::X * 0.3, Vec3::Z * 0.2, 1, 1));
    objects.push(quad("table", Vec3::new(0.2, 0.3, 0.3), Vec3::Z * 0.5, Vec3::X * 0.4, 2, 0));
    scene(objects, vec![grey(0.6, 0.0), grey(0.0, 10.0)])
}

fn moved(mut s: Scene, to: impl Fn(Vec3) -> Vec3) -> Scene {
    for p in s.objects.iter_mut().flat_map(|o| &mut o.positions) {
        *p = to(*p);
    }
    s
}

fn irradiance(light: &ElementLight) -> Vec<f32> {
    light.elements.iter().map(|e| e.irradiance.x).collect()
}

#[test]
fn unit_of_length() {
    let settings = BakeSettings::DRAFT;
    let elements = irradiance(&solved(furnished(), &settings));
    let vertices = values(&baked(furnished(), &settings));
    for factor in [1e-4, 1e-2, 1.7, 1e3, 1e6] {
        let scaled = moved(furnished(), |p| p * factor);
        eprintln!("{factor}: {:?} {:?}", differences(&irradiance(&solved(scaled.clone(), &settings)), &elements),
            differences(&values(&baked(scaled, &settings)), &vertices));
    }
}

#[test]
fn rounded_by_distance() {
    let settings = BakeSettings::BALANCED;
    let elements = irradiance(&solved(furnished(), &settings));
    let vertices = values(&baked(furnished(), &settings));
    for distance in [1e2_f32, 1e3, 1e4, 1e5] {
        let far = moved(furnished(), |p| p + Vec3::splat(distance));
        let ulp = distance.next_up() - distance;
        let e = irradiance(&solved(far.clone(), &settings));
        eprintln!("{distance} ulp {ulp}: {:?} {:?}", if e.len() == elements.len() { differences(&e, &elements) } else { (e.len() as f64, elements.len() as f64)},
            differences(&values(&baked(far, &settings)), &vertices));
    }
}

/// How many rays got out of a scene whose surfaces should all be alike, and how many found their own object.
fn astray(light: &ElementLight, convex: &[u32]) -> (f64, f64) {
    let n = light.elements.len();
    let mut lost = 0.0;
    let mut own = 0.0;
    for i in 0..n {
        lost += 1.0 - light.row_sum(i);
        let o = light.elements[i].object.0;
        if convex.contains(&o) {
            let row = light.row(i);
            own += (0..n).filter(|&j| light.elements[j].object.0 == o).map(|j| row[j]).sum::<f64>();
        }
    }
    (lost, own)
}

fn scaled(mut object: Object, factor: f32, flip: bool) -> Object {
    object.positions.iter_mut().for_each(|p| *p *= factor);
    if flip {
        object.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        object.normals.iter_mut().for_each(|n| *n = -*n);
    }
    object
}

#[test]
fn spheres_a_hair_apart() {
    for gap in [4e-3_f32, 4e-4, 4e-5, 1e-5, 4e-6, 2e-6] {
        let objects = vec![
            scaled(inward_sphere(8, 0), 1.0, true),
            scaled(inward_sphere(8, 0), 1.0 + gap, false),
        ];
        let s = scene(objects, vec![grey(0.5, 0.5)]);
        let settings = BakeSettings { element_rays: 512, elements: 2000, ..BakeSettings::BALANCED };
        let light = solved(s, &settings);
        let worst = light.elements.iter().map(|e| apart(e.radiosity.x.into(), 1.0)).fold(0.0, f64::max);
        eprintln!("gap {gap}: {} elements {:?} worst {worst}", light.elements.len(), astray(&light, &[0]));
    }
}

#[test]
fn planes_a_hair_apart() {
    for gap in [1e-3_f32, 1e-4, 1e-5, 4e-6] {
        let s = scene(room(Vec3::new(1.0, gap, 1.0), 4, [0; 6]), vec![grey(0.5, 0.5)]);
        let settings = BakeSettings { element_rays: 512, elements: 2000, ..BakeSettings::BALANCED };
        let light = solved(s, &settings);
        let worst = light.elements.iter().map(|e| apart(e.radiosity.x.into(), 1.0)).fold(0.0, f64::max);
        eprintln!("gap {gap}: {} elements {:?} worst {worst}", light.elements.len(), astray(&light, &[0, 1, 2, 3, 4, 5]));
    }
}

#[test]
fn small_box_on_a_large_floor() {
    for size in [0.1, 0.05, 0.02, 0.01] {
        let mut objects = vec![quad("ground", Vec3::new(-5e3, 0.0, -5e3), Vec3::Z * 1e4, Vec3::X * 1e4, 1, 0)];
        objects.extend(room(Vec3::splat(size), 4, [0; 6]).into_iter().skip(1).map(|mut o| { o.positions.iter_mut().for_each(|p| *p += Vec3::new(4e3, 0.0, 3e3)); o }));
        let mut s = scene(objects, vec![grey(0.5, 0.0)]);
        s.sky = Vec3::ONE;
        let settings = BakeSettings { element_rays: 4096, ..BakeSettings::BALANCED };
        let light = solved(s, &settings);
        let inside: Vec<f32> = (1..6).flat_map(|o| of_object(&light, o)).map(|e| e.direct.x).collect();
        eprintln!("{size}: inside {} brightest {}", inside.len(), inside.iter().fold(0.0_f32, |a, b| a.max(*b)));
    }
}

#[test]
fn rays_of_a_convex_room() {
    let s = scene(room(Vec3::new(3.0, 1.1, 2.3), 7, [0; 6]), vec![grey(0.5, 0.5)]);
    let settings = BakeSettings { element_rays: 1024, elements: 10_000, ..BakeSettings::BALANCED };
    let light = solved(s, &settings);
    eprintln!("convex {} rays {:?}", light.elements.len() * 1024, astray(&light, &[0, 1, 2, 3, 4, 5]));
}
