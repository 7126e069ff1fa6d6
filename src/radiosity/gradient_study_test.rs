//! How well a gradient foretells the irradiance of turned normals, and how well a mean direction would:
//! `cargo test --lib -- gradient_study --nocapture` prints the table of `docs/directional_light.md`.

#![allow(clippy::print_stdout, reason = "the table")]

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::gradient::gradient_about_z;
use super::reshade;
use crate::mesh::test_meshes::random;

/// Directions above the surface, evenly spread, with the radiance from there.
type Field = Vec<(DVec3, f64)>;

fn direction(alpha: f64, phi: f64) -> DVec3 {
    let (alpha, phi) = (alpha.to_radians(), phi.to_radians());
    DVec3::new(
        alpha.sin() * phi.cos(),
        alpha.sin() * phi.sin(),
        alpha.cos(),
    )
}

/// A round lamp of this radius, in degrees, so many degrees off the normal.
fn lamp(d: DVec3, (alpha, phi): (f64, f64), radius: f64) -> bool {
    d.dot(direction(alpha, phi)) > radius.to_radians().cos()
}

/// Light as surfaces in rooms see it.
fn fields() -> Vec<(&'static str, Field)> {
    let off = |d: DVec3| d.z.acos().to_degrees();
    let at = |d: DVec3, phi: f64, half: f64| {
        (d.y.atan2(d.x).to_degrees() - phi)
            .rem_euclid(360.0)
            .min((phi - d.y.atan2(d.x).to_degrees()).rem_euclid(360.0))
            < half
    };
    let value = |on: bool, radiance: f64| if on { radiance } else { 0.0 };
    type Of<'a> = Box<dyn Fn(DVec3) -> f64 + 'a>;
    let list: Vec<(&str, Of)> = vec![
        ("the same from everywhere", Box::new(|_| 1.0)),
        (
            "lamp at 40°",
            Box::new(|d| 0.5 + value(lamp(d, (40.0, 20.0), 10.0), 60.0)),
        ),
        (
            "lamp at 70°",
            Box::new(|d| 0.5 + value(lamp(d, (70.0, 20.0), 10.0), 60.0)),
        ),
        (
            "sun at 80°, sky",
            Box::new(|d| 1.0 + value(lamp(d, (80.0, 20.0), 5.0), 400.0)),
        ),
        (
            "window",
            Box::new(|d| {
                if off(d) > 55.0 && at(d, 180.0, 30.0) {
                    10.0
                } else {
                    0.5
                }
            }),
        ),
        (
            "corner, lamp",
            Box::new(|d| {
                let wall = if d.x > 0.0 && off(d) > 17.0 { 1.0 } else { 0.3 };
                wall + value(lamp(d, (29.0, 115.0), 12.0), 15.0)
            }),
        ),
        (
            "two lamps at 50°",
            Box::new(|d| {
                let both = [20.0, 200.0].map(|phi| value(lamp(d, (50.0, phi), 10.0), 40.0));
                0.3 + both[0] + both[1]
            }),
        ),
        (
            "bright horizon",
            Box::new(|d| if off(d) > 60.0 { 3.0 } else { 0.2 }),
        ),
    ];
    let (rings, sides) = (60, 120);
    let grid: Vec<DVec3> = (0..rings)
        .flat_map(|i| (0..sides).map(move |j| (i, j)))
        .map(|(i, j)| {
            let z = (f64::from(i) + 0.5) / f64::from(rings);
            let phi = TAU * (f64::from(j) + 0.5) / f64::from(sides);
            let s = (1.0 - z * z).sqrt();
            DVec3::new(s * phi.cos(), s * phi.sin(), z)
        })
        .collect();
    let weight = TAU / (PI * f64::from(rings * sides));
    list.into_iter()
        .map(|(name, of)| (name, grid.iter().map(|&d| (d, weight * of(d))).collect()))
        .collect()
}

/// Irradiance / π of a normal.
fn irradiance(field: &Field, normal: DVec3) -> f64 {
    field.iter().map(|(d, l)| l * d.dot(normal).max(0.0)).sum()
}

fn gradient(field: &Field) -> DVec3 {
    let of = |(d, l): &(DVec3, f64)| gradient_about_z(d.as_vec3()).as_dvec3() * (l * d.z);
    field.iter().map(of).sum()
}

/// The other way: the mean direction of the light, weighted by the cosine, taken for one lamp and light that
/// is the same from everywhere, `d = k l + (1 − k) 2/3 n`.
fn by_mean_direction(field: &Field, normal: DVec3) -> f64 {
    let whole = irradiance(field, DVec3::Z);
    let mean: DVec3 = field.iter().map(|(d, l)| *d * (l * d.z)).sum::<DVec3>() / whole;
    let up = mean.z - 2.0 / 3.0;
    let square = mean.x * mean.x + mean.y * mean.y + up * up;
    let k = (4.0 / 3.0 * up + (16.0 / 9.0 * up * up + 20.0 / 9.0 * square).sqrt()) * 0.9;
    let k = k.clamp(1e-6, 1.0);
    let lamp = (mean - DVec3::Z * (1.0 - k) * 2.0 / 3.0) / k;
    let lamp = lamp.normalize_or(DVec3::Z);
    let by_lamp = lamp.dot(normal).max(0.0) / lamp.z.max(0.1);
    whole * (k * by_lamp + (1.0 - k) * 0.5 * (1.0 + normal.z))
}

#[test]
fn gradients_foretell_turned_normals() {
    println!(
        "| light | slopes up to | ignored | mean direction | gradient |\n|---|---|---|---|---|"
    );
    let mut random = random(3);
    for (name, field) in fields() {
        let whole = irradiance(&field, DVec3::Z);
        let light = Vec3::splat(whole as f32);
        let gradient = gradient(&field).as_vec3();
        for slope in [20.0_f64, 30.0, 45.0] {
            let mut squares = [0.0; 3];
            let count = 100;
            for _ in 0..count {
                let z = 1.0 - f64::from(random()) * (1.0 - slope.to_radians().cos());
                let (s, phi) = ((1.0 - z * z).sqrt(), TAU * f64::from(random()));
                let normal = DVec3::new(s * phi.cos(), s * phi.sin(), z);
                let truth = irradiance(&field, normal);
                let told = reshade(light, gradient, Vec3::Z, normal.as_vec3());
                let told = [whole, by_mean_direction(&field, normal), f64::from(told.x)];
                for (square, told) in squares.iter_mut().zip(told) {
                    *square += ((told - truth) / whole).powi(2) / f64::from(count);
                }
            }
            let [ignored, mean, gradient] = squares.map(|s| 100.0 * s.sqrt());
            println!("| {name} | {slope}° | {ignored:.1} % | {mean:.1} % | {gradient:.1} % |");
            assert!(gradient < ignored / 3.0, "{name}, {slope}°");
        }
    }
}
