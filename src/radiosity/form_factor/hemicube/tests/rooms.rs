use glam::{Vec3, Vec4};

use super::*;
use crate::radiosity::element::ElementId;
use crate::radiosity::form_factor::hit_list;
use crate::radiosity::sampling::{cosine_hemisphere, frame, sobol};
use crate::radiosity::scene::{AlphaMode, MaterialId};

/// A box seen from inside, or from outside without its bottom.
fn walls(low: Vec3, size: Vec3, inside: bool) -> Vec<Object> {
    let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    let quad = |a: Vec3, u: Vec3, v: Vec3| {
        if inside {
            quad(low + a, u, v)
        } else {
            quad(low + a, v, u)
        }
    };
    let floor = inside.then(|| quad(Vec3::ZERO, z, x));
    let rest = [
        quad(y, x, z),
        quad(Vec3::ZERO, y, z),
        quad(x, z, y),
        quad(Vec3::ZERO, x, y),
        quad(z, y, x),
    ];
    floor.into_iter().chain(rest).collect()
}

/// A room with two blocks: 32 triangles.
pub(super) fn cornell() -> Vec<Object> {
    let mut objects = walls(Vec3::ZERO, Vec3::splat(5.5), true);
    for (place, size, turn) in [
        (Vec3::new(1.3, 0.0, 1.7), Vec3::new(1.6, 1.65, 1.6), -0.3),
        (Vec3::new(3.6, 0.0, 3.5), Vec3::new(1.6, 3.3, 1.6), 0.3),
    ] {
        let turn = glam::Mat3::from_rotation_y(turn);
        for mut object in walls(-0.5 * size * (Vec3::X + Vec3::Z), size, false) {
            for p in &mut object.positions {
                *p = place + turn * *p;
            }
            objects.push(object);
        }
    }
    objects
}

/// What rays from the point of a hemicube find: the shares of objects, of the sky and of black.
fn rays(view: &View, e: usize, count: u32) -> Vec<f64> {
    let element = ElementId(e as u32);
    let (origin, [_, _, normal]) = Eye::new(view, element).place();
    let own = view
        .elements
        .shape(view.scene, element)
        .next()
        .expect("it has a piece")
        .0;
    let objects = view.scene.objects.len();
    let mut shares = vec![0.0; objects + 2];
    for i in 0..count {
        let [s, t, ..] = sobol(i, 0, hash(77, e as u32));
        let direction = frame(normal) * cosine_hemisphere(s, t);
        let hit = view
            .occluders
            .closest(origin, direction, own, hash(e as u32, i));
        let found = match hit {
            None => objects,
            Some(hit) => view
                .elements
                .at(&hit)
                .map_or(objects + 1, |e| object(view, e.0)),
        };
        shares[found] += 1.0 / f64::from(count);
    }
    shares
}

fn object(view: &View, element: u32) -> usize {
    let holds = |o: &usize| view.elements.of_object(*o).contains(&(element as usize));
    (0..view.scene.objects.len())
        .find(holds)
        .expect("an element has an object")
}

/// The same shares of a row.
fn shares(view: &View, row: &Row) -> Vec<f64> {
    let mut shares = vec![0.0; view.scene.objects.len() + 2];
    for &(j, f) in &row.entries {
        shares[object(view, j)] += f64::from(f);
    }
    let objects = view.scene.objects.len();
    shares[objects] = row.sky.into();
    shares[objects + 1] = 1.0 - shares.iter().sum::<f64>();
    shares
}

/// Holds every row of a scene against 4,096 rays from the same points.
fn agrees_with_rays(scene: &Scene, elements: u32, tolerance: f64) {
    look(scene, &settings(elements, 0), |view| {
        let cube = Hemicube::new(view, 128);
        let mut buffers = cube.buffers();
        for e in 0..view.elements.len() {
            let found = shares(&view, &cube.point_row(e, &mut buffers));
            let expected = rays(&view, e, 4096);
            for (o, (f, r)) in found.iter().zip(&expected).enumerate() {
                assert!(
                    (f - r).abs() < tolerance,
                    "element {e}, object {o}: {f}, rays {r}"
                );
            }
        }
    });
}

/// Each pixel shows the element that a ray through its centre meets.
#[test]
fn pixels_show_what_rays_through_them_meet() {
    let resolution = 32;
    for elements in [200, 3000, 60_000] {
        look(&scene(cornell()), &settings(elements, 0), |view| {
            let cube = Hemicube::new(view, resolution as u32);
            let (mut buffers, mut weights) = (cube.buffers(), vec![0.0; resolution]);
            for e in (0..view.elements.len()).step_by(view.elements.len() / 40) {
                let row = cube.point_row(e, &mut buffers);
                let mut off = vec![0.0; view.elements.len()];
                row.entries.iter().for_each(|&(j, f)| off[j as usize] = f);
                let (origin, axes) = Eye::new(&view, ElementId(e as u32)).place();
                for face in &FACES {
                    let rays = face.linear(face.turned(&axes), resolution);
                    for y in 0..face.rows(resolution) {
                        cube.deltas.row(face, y, &mut weights);
                        for (x, &weight) in weights.iter().enumerate() {
                            let ray = (rays.at_row(y) + rays.column * x as f32).normalize();
                            let hit = view.occluders.closest(origin, ray, u32::MAX, 0);
                            if let Some(j) = hit.and_then(|hit| view.elements.at(&hit)) {
                                off[j.0 as usize] -= weight;
                            }
                        }
                    }
                }
                // A pixel whose centre is on an edge may belong to either side.
                let wrong = 0.5 * off.iter().map(|f| f.abs()).sum::<f32>();
                assert!(wrong < 2e-3, "{elements} elements, row {e}: {wrong}");
            }
        });
    }
}

#[test]
fn a_room_looks_as_rays_find_it() {
    agrees_with_rays(&scene(cornell()), 400, 0.012);
}

#[test]
fn through_a_window_the_sky_shows() {
    let mut objects = cornell();
    // Half of one wall and a hole in the ceiling, from which a one-sided awning hangs.
    objects[4].triangles.pop();
    objects[1].triangles.pop();
    objects.push(quad(
        Vec3::new(1.0, 4.0, 1.0),
        Vec3::X * 3.0,
        Vec3::new(0.0, 1.0, 2.0),
    ));
    let scene = scene(objects);
    agrees_with_rays(&scene, 400, 0.012);
    look(&scene, &settings(400, 0), |view| {
        let cube = Hemicube::new(view, 64);
        let mut buffers = cube.buffers();
        let rows = (0..view.elements.len()).map(|e| cube.point_row(e, &mut buffers));
        let sky: f64 = rows.map(|r| f64::from(r.sky)).sum();
        assert!(sky > 0.05 * view.elements.len() as f64);
    });
}

#[test]
fn light_passes_what_is_there_in_part() {
    let mut scene = scene(cornell());
    scene.materials.push(Material {
        base_color: Vec4::new(0.5, 0.5, 0.5, 0.4),
        alpha: AlphaMode::Blend,
        double_sided: true,
        ..Material::default()
    });
    for height in [2.0, 4.5] {
        scene.objects.push(Object {
            material: MaterialId(1),
            ..quad(Vec3::new(0.5, height, 0.5), Vec3::X * 4.5, Vec3::Z * 4.5)
        });
    }
    // Both sides take chances at each pixel or ray.
    agrees_with_rays(&scene, 300, 0.04);
}

#[test]
fn means_are_those_of_the_hit_list() {
    let settings = BakeSettings {
        element_rays: 4096,
        ..settings(600, 0)
    };
    look(&scene(cornell()), &settings, |view| {
        let (traced, _) = hit_list::trace(&view, None, &()).expect("nobody cancels");
        let cube = Hemicube::new(view, 64);
        let mut buffers = cube.buffers();
        let mut means = [vec![0.0; 18], vec![0.0; 18]];
        let area = view.elements.area.iter().map(|&a| f64::from(a));
        let total: f64 = area.clone().sum();
        for (e, area) in area.enumerate() {
            let mut hits = Row::default();
            traced.rows.each(e, |j, f| hits.entries.push((j, f)));
            let rows = [cube.point_row(e, &mut buffers), hits];
            for (mean, row) in means.iter_mut().zip(&rows) {
                for (sum, share) in mean.iter_mut().zip(shares(&view, row)) {
                    *sum += area / total * share;
                }
            }
        }
        for (cube, rays) in means[0].iter().zip(&means[1]) {
            assert!((cube - rays).abs() < 0.004, "{means:?}");
        }
    });
}

/// Floor runs on under a block. It sees the insides of the block, which are black; without back
/// faces it sees the room, however fine the picture.
#[test]
fn floor_under_a_block_is_in_the_dark() {
    let mut objects = walls(Vec3::ZERO, Vec3::splat(3.0), true);
    objects.extend(walls(Vec3::new(1.0, 0.0, 1.0), Vec3::ONE, false));
    look(&scene(objects), &settings(1500, 0), |view| {
        let under = |e: &usize| {
            let (center, _) = view.elements.middle(view.scene, ElementId(*e as u32));
            let place = center * view.scene.scale;
            // The scene is centred.
            place.x.abs().max(place.z.abs()) < 0.48
        };
        let buried: Vec<usize> = view.elements.of_object(0).filter(under).collect();
        assert!(buried.len() > 10);
        for resolution in [32, 64, 128] {
            let mut cube = Hemicube::new(view, resolution);
            let mut buffers = cube.buffers();
            for &e in &buried {
                let row = cube.point_row(e, &mut buffers);
                assert_eq!((row.sum(), row.sky), (0.0, 0.0), "element {e}");
            }
            cube.culled = true;
            let sum = |&e: &usize| cube.point_row(e, &mut buffers).sum();
            let least = buried.iter().map(sum).fold(1.0, f64::min);
            assert!(least > 0.99, "R {resolution}: {least}");
        }
    });
}

/// Every wall twice, cut along the other diagonal, and every wall with a twin that faces away.
#[test]
fn one_of_several_walls_at_one_place_is_seen() {
    let single = cornell();
    let mut double = single.clone();
    for o in &single {
        let mut again = o.clone();
        again.triangles = vec![[1, 2, 3], [1, 3, 0]];
        let mut turned = o.clone();
        turned.triangles = vec![[0, 2, 1], [0, 3, 2]];
        double.extend([turned, again]);
    }
    look(&scene(double), &settings(1200, 0), |view| {
        let cube = Hemicube::new(view, 64);
        let mut buffers = cube.buffers();
        // Whichever of the three is seen, the wall is the same.
        let by_wall = |shares: Vec<f64>| {
            let mut walls = shares[..single.len()].to_vec();
            for (copy, share) in shares[single.len()..].iter().enumerate() {
                match walls.get_mut(copy / 2) {
                    Some(wall) => *wall += share,
                    None => walls.push(*share),
                }
            }
            walls
        };
        for e in (0..single.len()).flat_map(|o| view.elements.of_object(o)) {
            let row = cube.point_row(e, &mut buffers);
            assert_eq!(row, cube.point_row(e, &mut buffers));
            let found = by_wall(shares(&view, &row));
            let expected = by_wall(rays(&view, e, 1024));
            for (wall, (f, r)) in found.iter().zip(&expected).enumerate() {
                assert!(
                    (f - r).abs() < 0.03,
                    "element {e}, wall {wall}: {f}, rays {r}"
                );
            }
            // No black side shows, not even at one pixel.
            assert!(found[found.len() - 1].abs() < 1e-6, "{found:?}");
        }
    });
}

#[test]
fn inside_a_closed_room_rows_are_one() {
    look(
        &scene(walls(Vec3::ZERO, Vec3::new(2.0, 1.0, 3.0), true)),
        &settings(500, 0),
        |view| {
            for resolution in [16, 34, 128] {
                let cube = Hemicube::new(view, resolution);
                let mut buffers = cube.buffers();
                for e in 0..view.elements.len() {
                    let row = cube.point_row(e, &mut buffers);
                    assert!((row.sum() - 1.0).abs() < 1e-5, "element {e}: {}", row.sum());
                    assert!(row.entries.is_sorted_by(|a, b| a.0 < b.0));
                }
            }
        },
    );
}
