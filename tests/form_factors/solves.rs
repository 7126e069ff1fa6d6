//! Whole solutions that are known: by a small dense system, and through the door.

use bevy_fresco::radiosity::{BakeSettings, FormFactors, Scene, polygon_to_polygon};
use glam::{DVec3, Vec3};

use crate::closed_form::concentric_spheres;
use crate::common::{grey, inward_sphere, quad, room, scene};
use crate::meshes::{greys, inside_out, mean, settings, solved};
use crate::truth::solutions;

const ANALYTIC: FormFactors = FormFactors::Analytic { visibility_rays: 1 };

/// `B = E + ρ F B` by Gauss's elimination.
fn radiosity(f: &[Vec<f64>], reflectance: &[f64], emission: &[f64]) -> Vec<f64> {
    let n = emission.len();
    let row = |i: usize| -> Vec<f64> {
        let unit = |j| if i == j { 1.0 } else { 0.0 };
        let mut row: Vec<f64> = (0..n).map(|j| unit(j) - reflectance[i] * f[i][j]).collect();
        row.push(emission[i]);
        row
    };
    let mut m: Vec<Vec<f64>> = (0..n).map(row).collect();
    // The diagonal outweighs the rest of its row: no pivoting.
    for i in 0..n {
        let pivot = m[i].clone();
        for other in m.iter_mut().skip(i + 1) {
            let factor = other[i] / pivot[i];
            for (o, p) in other.iter_mut().zip(&pivot).skip(i) {
                *o -= factor * p;
            }
        }
    }
    let mut b = vec![0.0; n];
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| m[i][j] * b[j]).sum();
        b[i] = (m[i][n] - known) / m[i][i];
    }
    b
}

fn near(what: &str, found: f64, truth: f64, tolerance: f64) {
    assert!(
        (found - truth).abs() < tolerance * truth.abs(),
        "{what}: {found} for {truth}"
    );
}

/// Mean radiosity of an object.
fn leaving(scene: Scene, settings: &BakeSettings, objects: &[u32]) -> Vec<f64> {
    let light = solved(scene, settings);
    let mean = |&o: &u32| mean(&light, o, |i| light.elements[i].radiosity.x.into());
    objects.iter().map(mean).collect()
}

#[test]
fn furnace() {
    for t in solutions("furnace") {
        let (e, rho) = (t.number("emission"), t.number("reflectance"));
        let truth = t.values["radiosity"].as_f64().unwrap();
        let materials = vec![grey(rho as f32, e as f32)];
        let scene = scene(room(Vec3::new(1.0, 2.0, 0.5), 2, [0; 6]), materials);
        let settings = BakeSettings {
            max_reflectance: 0.995,
            ..settings(&scene, 0.05, ANALYTIC)
        };
        let light = solved(scene, &settings);
        // What is missing of a row is missed at every bounce.
        let largest = light.report.form_factors.largest_row_sum;
        let tolerance = 1e-4 / (1.0 - rho);
        for e in &light.elements {
            let b: f64 = e.radiosity.x.into();
            assert!(
                (b / truth - 1.0).abs() < tolerance,
                "{b} for {truth}, rows to {largest}"
            );
        }
    }
}

#[test]
fn plates() {
    for t in solutions("plates") {
        let (e, rho) = (t.pair("emission"), t.pair("reflectance"));
        let truth = [0, 1].map(|i| t.values["radiosity"][i].as_f64().unwrap());
        let dense = radiosity(&[vec![0.0, 1.0], vec![1.0, 0.0]], &rho, &e);
        let size = 2e4;
        let objects = vec![
            quad("below", Vec3::ZERO, Vec3::Z * size, Vec3::X * size, 1, 0),
            quad("above", Vec3::Y, Vec3::X * size, Vec3::Z * size, 1, 1),
        ];
        let scene = scene(objects, greys(rho, e));
        let settings = settings(&scene, f64::from(size).powi(2) / 2.0, ANALYTIC);
        let baked = leaving(scene, &settings, &[0, 1]);
        for i in 0..2 {
            near(&t.id, dense[i], truth[i], 1e-13);
            // The gap is a 20,000th of the plates: so much escapes, at every bounce.
            near(&t.id, baked[i], truth[i], 1e-3);
        }
    }
}

#[test]
fn spheres_in_spheres() {
    for t in solutions("concentric_spheres") {
        let (e, rho, r) = (t.pair("emission"), t.pair("reflectance"), t.pair("radii"));
        let truth = [0, 1].map(|i| t.values["radiosity"][i].as_f64().unwrap());
        let f = concentric_spheres(r[0], r[1]);
        let dense = radiosity(&[vec![0.0, 1.0], vec![f, 1.0 - f]], &rho, &e);
        let ratio = (r[0] / r[1]) as f32;
        let objects = vec![inside_out(inward_sphere(6, 0), ratio), inward_sphere(6, 1)];
        let scene = scene(objects, greys(rho, e));
        let baked = leaving(
            scene.clone(),
            &BakeSettings {
                elements: 500,
                form_factors: FormFactors::Analytic { visibility_rays: 4 },
                sample_emitters: false,
                refine: false,
                adapt: false,
                ..BakeSettings::FINAL
            },
            &[0, 1],
        );
        for i in 0..2 {
            near(&t.id, dense[i], truth[i], 1e-13);
            near(&t.id, baked[i], truth[i], 0.02);
        }
    }
}

/// Inside a sphere all is lit alike, whatever shines and reflects where (Sumpner 1892).
#[test]
fn integrating_sphere() {
    let t = &solutions("integrating_sphere")[0];
    let (e, rho, share) = (t.pair("emission"), t.pair("reflectance"), t.pair("share"));
    let irradiance = t.values["irradiance"].as_f64().unwrap();
    let dense = radiosity(&[share.to_vec(), share.to_vec()], &rho, &e);
    for i in 0..2 {
        let truth = t.values["radiosity"][i].as_f64().unwrap();
        near("two patches", dense[i], truth, 1e-13);
        near(
            "by the irradiance",
            e[i] + rho[i] * irradiance,
            truth,
            1e-13,
        );
    }
    let means = &solutions("integrating_sphere_means")[0];
    let irradiance = means.number("emission") / (1.0 - means.number("reflectance"));
    near(
        "means",
        irradiance,
        means.values["irradiance"].as_f64().unwrap(),
        1e-13,
    );
}

/// A pattern of numbers in 0..1.
fn pattern(count: usize, stride: f64) -> Vec<f64> {
    (1..=count).map(|i| (i as f64 * stride).fract()).collect()
}

#[test]
fn integrating_sphere_of_any_pattern() {
    let n = 40;
    let (area, emission) = (pattern(n, 0.618), pattern(n, 0.414));
    let reflectance: Vec<f64> = pattern(n, 0.732).iter().map(|r| 0.95 * r).collect();
    let total: f64 = area.iter().sum();
    let shares: Vec<f64> = area.iter().map(|a| a / total).collect();
    let b = radiosity(&vec![shares.clone(); n], &reflectance, &emission);
    let mean = |x: &[f64]| x.iter().zip(&shares).map(|(x, s)| x * s).sum::<f64>();
    let irradiance = mean(&emission) / (1.0 - mean(&reflectance));
    for i in 0..n {
        near(
            "patch",
            b[i],
            emission[i] + reflectance[i] * irradiance,
            1e-12,
        );
    }
}

/// The same as a mesh, three materials by octant.
#[test]
fn integrating_sphere_as_a_mesh() {
    let whole = inward_sphere(8, 0);
    let faces = whole.triangles.len() / 8;
    let octants = (0..8).map(|o| {
        let mut octant = whole.clone();
        octant.triangles = whole.triangles[o * faces..(o + 1) * faces].to_vec();
        octant.material.0 = o as u32 % 3;
        octant
    });
    let materials = vec![grey(0.2, 1.0), grey(0.8, 0.0), grey(0.6, 0.2)];
    let scene = scene(octants.collect(), materials);
    let area = 4.0 * std::f64::consts::PI / (8 * faces) as f64;
    let light = solved(scene.clone(), &settings(&scene, area, ANALYTIC));
    let counts = [3.0, 3.0, 2.0];
    let mean = |x: [f64; 3]| (0..3).map(|i| counts[i] * x[i]).sum::<f64>() / 8.0;
    let irradiance = mean([1.0, 0.0, 0.2]) / (1.0 - mean([0.2, 0.8, 0.6]));
    for e in &light.elements {
        let error = (f64::from(e.irradiance.x) / irradiance - 1.0).abs();
        // 512 flat faces; the worst lie along the border of bright and dark.
        assert!(error < 0.02, "{} for {irradiance}", e.irradiance.x);
    }
}

/// The walls of the unit cube as `n × n` squares each: floor, ceiling, then the others.
fn cube(n: u32) -> Vec<Vec<[DVec3; 4]>> {
    let squares = |[a, u, v]: [DVec3; 3]| {
        let cell = move |k: u32| {
            let at = |i: u32, j: u32| a + (u * f64::from(i) + v * f64::from(j)) / f64::from(n);
            let (i, j) = (k / n, k % n);
            [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
        };
        (0..n * n).map(cell).collect()
    };
    let (o, x, y, z) = (DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z);
    let walls = [
        [o, z, x],
        [y, x, z],
        [o, y, z],
        [x, z, y],
        [o, x, y],
        [z, y, x],
    ];
    walls.into_iter().map(squares).collect()
}

#[test]
fn cube_of_six_walls() {
    let t = &solutions("cube_form_factors")[0];
    let walls = cube(1);
    let opposed = polygon_to_polygon(&walls[0][0], &walls[1][0]);
    let adjacent = polygon_to_polygon(&walls[0][0], &walls[2][0]);
    near(
        "opposed",
        opposed,
        t.values["opposed"].as_f64().unwrap(),
        1e-14,
    );
    near(
        "adjacent",
        adjacent,
        t.values["adjacent"].as_f64().unwrap(),
        1e-14,
    );
    near("closed", opposed + 4.0 * adjacent, 1.0, 1e-14);
}

/// Form factors and solution exact, so the elements are all that is between this and the truth.
#[test]
fn cube_of_squares() {
    for t in solutions("cube_of_squares") {
        let rho = t.number("reflectance");
        let of_size = t.values["mean radiosity of floor, ceiling, walls"]
            .as_object()
            .unwrap();
        for n in [1_u32, 2, 4] {
            let patches = cube(n).concat();
            let per_wall = (n * n) as usize;
            let row = |a: &[DVec3; 4]| patches.iter().map(|b| polygon_to_polygon(a, b)).collect();
            let f: Vec<Vec<f64>> = patches.iter().map(row).collect();
            let emission: Vec<f64> = (0..patches.len())
                .map(|i| if i / per_wall == 1 { 1.0 } else { 0.0 })
                .collect();
            let b = radiosity(&f, &vec![rho; patches.len()], &emission);
            for wall in 0..3 {
                let of_wall = &b[wall * per_wall..(wall + 1) * per_wall];
                let mean = of_wall.iter().sum::<f64>() / per_wall as f64;
                let truth = of_size[&n.to_string()][wall].as_f64().unwrap();
                near(&format!("{n} squares, wall {wall}"), mean, truth, 1e-12);
            }
        }
    }
}

#[test]
fn cube_with_a_bright_ceiling() {
    for t in solutions("cube") {
        let rho = t.number("reflectance");
        let objects = room(Vec3::ONE, 1, [0, 1, 0, 0, 0, 0]);
        let scene = scene(objects, greys([rho, rho], [0.0, 1.0]));
        let settings = settings(&scene, 0.5 / 121.0, ANALYTIC);
        let found = leaving(scene, &settings, &[0, 1, 2]);
        for (wall, found) in ["mean floor", "mean ceiling", "mean wall"]
            .iter()
            .zip(found)
        {
            let truth = t.values[*wall]["value"].as_f64().unwrap();
            // 121 cells a triangle: what is left is theirs.
            near(wall, found, truth, 2e-3);
        }
    }
}
