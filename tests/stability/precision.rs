//! Sizes, distances and gaps at the limits of `f32`.

use bevy_fresco::radiosity::{BakeSettings, ElementLight, Scene};
use glam::Vec3;

use crate::common::{grey, inward_sphere, quad, room, scene, values};
use crate::solved::{
    astray, baked, differences, furthest_from_one, mean, of_object, solved, tight,
};

/// A room with a lamp below its ceiling and a sheet across it.
fn furnished() -> Scene {
    let mut objects = room(Vec3::new(1.0, 0.7, 1.3), 3, [0; 6]);
    objects.push(quad(
        "lamp",
        Vec3::new(0.3, 0.6, 0.4),
        Vec3::X * 0.3,
        Vec3::Z * 0.2,
        1,
        1,
    ));
    objects.push(quad(
        "table",
        Vec3::new(0.2, 0.3, 0.3),
        Vec3::Z * 0.5,
        Vec3::X * 0.4,
        2,
        0,
    ));
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

/// Light does not depend on the unit of length. Factors that are no powers of two round the corners,
/// and now and then a ray near the edge of an element meets its neighbour: one of 32, which is
/// 0.3 % of an element's light. (Powers of two, bit for bit: `scale` in `bad_input`.)
#[test]
fn unit_of_length() {
    let settings = BakeSettings {
        refine: false,
        adapt: false,
        ..BakeSettings::DRAFT
    };
    let elements = irradiance(&solved(furnished(), &settings));
    let vertices = values(&baked(furnished(), &settings));
    for factor in [1e-4, 1e-2, 1e3, 1e6] {
        let other = moved(furnished(), |p| p * factor);
        let found = irradiance(&solved(other.clone(), &settings));
        let (rms, largest) = differences(&found, &elements);
        assert!(rms < 2e-4 && largest < 0.01, "{factor}: {rms}, {largest}");
        let (rms, largest) = differences(&values(&baked(other, &settings)), &vertices);
        assert!(rms < 5e-4 && largest < 0.005, "{factor}: {rms}, {largest}");
    }
}

/// Far from the origin, in coordinates that are rounded there: cells of 23 cm and more in steps of
/// up to 8 mm. Light errs by no more than the cells do. (Coordinates that are exact, bit for bit:
/// `far_from_the_origin` in `bad_input`.)
#[test]
fn rounded_far_from_the_origin() {
    let settings = BakeSettings {
        refine: false,
        adapt: false,
        ..BakeSettings::DRAFT
    };
    let elements = solved(furnished(), &settings);
    let vertices = values(&baked(furnished(), &settings));
    for distance in [1e3_f32, 1e4, 1e5] {
        let far = moved(furnished(), |p| p + Vec3::splat(distance));
        let step = f64::from(distance.next_up() - distance);
        // Rays that meet a neighbour are noise that rounding sets free, however little it is.
        let limit = 4.0 * step / 0.233 + 5e-3;
        let light = solved(far.clone(), &settings);
        for object in 0..8 {
            let [found, truth] =
                [&light, &elements].map(|l| mean(of_object(l, object), |e| e.irradiance.x));
            let ok = (found - truth).abs() <= limit * truth;
            assert!(ok, "{distance}: {object}: {found}, {truth}");
        }
        let (rms, _) = differences(&values(&baked(far, &settings)), &vertices);
        assert!(rms < limit, "{distance}: {rms}, {limit}");
    }
}

fn many_rays() -> BakeSettings {
    BakeSettings {
        elements: 2_000,
        element_rays: 1024,
        refine: false,
        adapt: false,
        ..BakeSettings::BALANCED
    }
}

/// Ten million rays in a convex room: none meets the wall it started from, and all meet another.
#[test]
fn rays_that_meet_their_own_wall() {
    let s = scene(
        room(Vec3::new(3.0, 1.1, 2.3), 7, [0; 6]),
        vec![grey(0.5, 0.5)],
    );
    let settings = BakeSettings {
        elements: 10_000,
        ..many_rays()
    };
    let light = solved(s, &settings);
    assert!(light.elements.len() > 9_700);
    assert!(tight(&light, &settings));
    assert_eq!(astray(&light, &settings).1, 0.0);
}

/// A room 1 m wide and a hair high, down to 4 · 10⁻⁶ m: two offsets of rays. None gets out, none meets
/// the wall it started from.
#[test]
fn planes_a_hair_apart() {
    for gap in [1e-3, 1e-4, 1e-5, 4e-6] {
        let s = scene(
            room(Vec3::new(1.0, gap, 1.0), 4, [0; 6]),
            vec![grey(0.5, 0.5)],
        );
        let light = solved(s, &many_rays());
        assert_eq!(astray(&light, &many_rays()), (0.0, 0.0), "{gap}");
        assert!(furthest_from_one(&light) < 1e-3, "{gap}");
    }
}

/// A sphere in one of a radius so much larger, facing each other.
fn spheres(gap: f32) -> Scene {
    let outer = inward_sphere(8, 0);
    let mut inner = outer.clone();
    inner.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    inner.normals.iter_mut().for_each(|n| *n = -*n);
    let mut objects = vec![inner, outer];
    objects[1]
        .positions
        .iter_mut()
        .for_each(|p| *p *= 1.0 + gap);
    scene(objects, vec![grey(0.5, 0.5)])
}

/// Spheres of which one is larger by 4 · 10⁻⁵, and down to 4 · 10⁻⁶: every ray of the inner one
/// meets the outer one, none tunnels through either, none meets its own facet. A ray starts 16
/// rounding errors off its surface, 3.8 · 10⁻⁶ here, so at 2 · 10⁻⁶ it starts outside: what the
/// inner sphere sends out is reported to have escaped, of a scene that is closed.
#[test]
fn spheres_a_hair_apart() {
    let settings = many_rays();
    for gap in [4e-4, 4e-5, 4e-6] {
        let light = solved(spheres(gap), &settings);
        assert!(tight(&light, &settings), "{gap}");
        for (i, _) in light
            .elements
            .iter()
            .enumerate()
            .filter(|e| e.1.object.0 == 0)
        {
            let row = light.row(i).into_iter().zip(&light.elements);
            let own: f64 = row.filter(|r| r.1.object.0 == 0).map(|r| r.0).sum();
            assert_eq!(own, 0.0, "{gap}");
        }
        assert!(furthest_from_one(&light) < 1e-3, "{gap}");
        assert!(light.report.energy.escaped.x < 1e-5, "{gap}");
    }
    let energy = solved(spheres(2e-6), &settings).report.energy;
    assert!(energy.escaped.x > 0.05 * energy.arrived.x, "{energy:?}");
}

/// A closed box of 10 cm in a plain of 10 km under the sky: coordinates have steps of half a
/// millimetre there, rays start 1 cm off their surface, and no more of them get out than start where
/// a corner was rounded. A box of 1 cm is smaller than that.
#[test]
fn small_box_on_a_large_floor() {
    for (size, limit) in [(0.1_f32, 0.005), (0.05, 0.01)] {
        let ground = quad(
            "ground",
            Vec3::new(-5e3, 0.0, -5e3),
            Vec3::Z * 1e4,
            Vec3::X * 1e4,
            1,
            0,
        );
        let mut walls = room(Vec3::splat(size), 4, [0; 6]);
        let there = Vec3::new(4e3, 0.0, 3e3);
        walls
            .iter_mut()
            .flat_map(|o| &mut o.positions)
            .for_each(|p| *p += there);
        let mut objects = vec![ground];
        objects.extend(walls.into_iter().skip(1));
        let mut s = scene(objects, vec![grey(0.5, 0.0)]);
        s.sky = Vec3::ONE;
        let settings = BakeSettings {
            elements: 500,
            element_rays: 4096,
            refine: false,
            adapt: false,
            ..BakeSettings::BALANCED
        };
        let light = solved(s, &settings);
        for e in (1..6).flat_map(|o| of_object(&light, o)) {
            assert!(e.direct.x < limit, "{size}: {e:?}");
        }
    }
}
