//! Surfaces at one place.

use bevy_fresco::radiosity::{BakeSettings, Scene};
use glam::Vec3;

use crate::common::{grey, mean_over, quad, room, scene};
use crate::solved::{apart, baked, mean, of_object, range, solved};

/// A unit room of `n²` cells a wall with a luminous ceiling, and its walls again in `again²` cells.
fn walls_twice(n: u32, again: Option<u32>) -> Scene {
    let mut objects = room(Vec3::ONE, n, [0, 1, 0, 0, 0, 0]);
    if let Some(m) = again {
        objects.extend(room(Vec3::ONE, m, [0, 1, 0, 0, 0, 0]));
    }
    scene(objects, vec![grey(0.7, 0.0), grey(0.7, 1.0)])
}

/// Every wall modelled twice with other triangles, so that none is a duplicate to be left out, and
/// rays meet now one and now the other by a rounding. Both carry the light of one within 1 %, no
/// element is darker or brighter than any was before, and a second run is the same to the bit.
/// (Walls of the same triangles, and flipped ones: `walls_modelled_twice` in `light`.)
#[test]
fn coincident_walls() {
    let settings = BakeSettings {
        refine: false,
        adapt: false,
        ..BakeSettings::BALANCED
    };
    let once = solved(walls_twice(4, None), &settings);
    let twice = solved(walls_twice(4, Some(3)), &settings);
    for wall in 0..6 {
        let truth = mean(of_object(&once, wall), |e| e.irradiance.x);
        let (low, high) = range(of_object(&once, wall));
        for object in [wall, wall + 6] {
            let found = mean(of_object(&twice, object), |e| e.irradiance.x);
            assert!(apart(found, truth) < 0.01, "{object}: {found}, {truth}");
            let (dark, light) = range(of_object(&twice, object));
            // Half as many elements a wall: a margin for the noise of 48 rays.
            assert!(
                dark > 0.9 * low && light < 1.1 * high,
                "{object}: {dark}..{light}"
            );
        }
    }
    let again = solved(walls_twice(4, Some(3)), &settings);
    assert_eq!(again.elements, twice.elements);
}

const CORNELL: Vec3 = Vec3::new(5.56, 5.488, 5.592);

/// The Cornell box without its blocks, with a lamp so far below the ceiling.
fn cornell(lamp: [f32; 4], below: f32, reflectance: f32) -> Scene {
    let mut objects = room(CORNELL, 8, [0; 6]);
    let [x0, x1, z0, z1] = lamp;
    let corner = Vec3::new(x0, CORNELL.y - below, z0);
    let (x, z) = (Vec3::X * (x1 - x0), Vec3::Z * (z1 - z0));
    objects.push(quad("lamp", corner, x, z, 1, 1));
    scene(objects, vec![grey(reflectance, 0.0), grey(0.0, 1.0)])
}

/// A lamp in the very plane of the ceiling, and by a hair below it: what shines is met. The floor
/// gets the light that the form factor between parallel rectangles says (Howell's catalogue, C-13),
/// 0.01067 of a lamp of the Cornell box's size, which is sampled, and 0.16401 of one that fills
/// most of the ceiling, which rays find. With light that bounces the same comes out for all offsets.
#[test]
fn coplanar_lamp() {
    let settings = BakeSettings {
        elements: 4_000,
        refine: false,
        adapt: false,
        ..BakeSettings::FINAL
    };
    for (lamp, factor, centre) in [
        ([2.13, 3.43, 2.27, 3.32], 0.010_674_1, 0.014_207_0),
        ([0.3, 5.2, 0.3, 5.2], 0.164_005_2, 0.200_885_9),
    ] {
        let floor = |below, reflectance| {
            let light = solved(cornell(lamp, below, reflectance), &settings);
            mean(of_object(&light, 0), |e| e.irradiance.x)
        };
        let bounced = floor(1e-3, 0.7);
        for below in [0.0, 1e-6] {
            let direct = floor(below, 0.0);
            assert!(apart(direct, factor) < 0.003, "{below}: {direct}, {factor}");
            let found = floor(below, 0.7);
            // Elements of the ceiling that the lamp covers in part see its black back.
            assert!(apart(found, bounced) < 0.01, "{below}: {found}, {bounced}");
        }
        // Of 81 vertices over 5.5 m, fitted: the peak of the small lamp comes out 1 % high.
        let s = cornell(lamp, 0.0, 0.0);
        let shape = s.objects[0].clone();
        let light = baked(s, &settings).objects.swap_remove(0).light;
        let middle = f64::from(light[4 * 9 + 4].x);
        assert!(apart(middle, centre) < 0.02, "{middle}, {centre}");
        assert!(apart(mean_over(&shape, &light), factor) < 0.005);
    }
}
