use glam::{DVec3, Vec3};

use super::*;
use crate::radiosity::form_factor::point_to_polygon;
use crate::radiosity::sampling::unit_float;

/// Pseudo-random numbers in 0..1, one after the other.
struct Dice(u32);

impl Dice {
    fn roll(&mut self) -> f32 {
        self.0 += 1;
        unit_float(hash(self.0, 0xD1CE))
    }

    fn direction(&mut self) -> Vec3 {
        let (z, phi) = (2.0 * self.roll() - 1.0, std::f32::consts::TAU * self.roll());
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    }
}

/// A square of about the form factor `wanted` in a random place over a small one at the origin, and
/// the small one.
fn random_square(wanted: f32, dice: &mut Dice) -> Scene {
    loop {
        let (place, normal) = (dice.direction(), dice.direction());
        let facing = -normal.dot(place);
        if place.y < 0.2 || facing < 0.2 {
            continue;
        }
        let size = (wanted * std::f32::consts::PI / (place.y * facing)).sqrt();
        let u = normal.any_orthonormal_vector() * size;
        let v = normal.cross(u);
        let corner = place - 0.5 * (u + v);
        // Wholly above the horizon, and not upon the small one.
        if [corner, corner + u, corner + v, corner + u + v]
            .iter()
            .any(|c| c.y < 0.02)
        {
            continue;
        }
        let (x, z) = (Vec3::X * 1e-3, Vec3::Z * 1e-3);
        let floor = quad(-0.5 * (x + z), z, x);
        return scene(vec![floor, quad(corner, u, v)]);
    }
}

/// The form factor to the square, found and exact.
fn square(scene: &Scene, resolution: u32, seed: u32) -> (f64, f64) {
    look(scene, &settings(2, seed), |view| {
        let cube = Hemicube::new(view, resolution);
        let row = cube.point_row(0, &mut cube.buffers());
        let of_square = view.elements.of_object(1);
        let found = row
            .entries
            .iter()
            .filter(|e| of_square.contains(&(e.0 as usize)));
        let (position, [_, _, normal]) = Eye::new(&view, ElementId(0)).place();
        let positions = &view.scene.objects[1].positions;
        let corners: Vec<DVec3> = positions.iter().map(|p| p.as_dvec3()).collect();
        let exact = point_to_polygon(position.as_dvec3(), normal.as_dvec3(), &corners);
        (found.map(|e| f64::from(e.1)).sum::<f64>(), exact)
    })
}

struct Errors {
    /// Root of the mean square of relative errors.
    rms: f64,
    /// Squares without a pixel.
    missed: u32,
}

/// Of 60 random squares.
fn errors(wanted: f32, resolution: u32) -> Errors {
    let mut dice = Dice(wanted.to_bits());
    let (mut squares, mut missed) = (0.0, 0);
    for seed in 0..60 {
        let (found, exact) = square(&random_square(wanted, &mut dice), resolution, seed);
        squares += (found / exact - 1.0).powi(2) / 60.0;
        missed += u32::from(found == 0.0);
    }
    Errors {
        rms: squares.sqrt(),
        missed,
    }
}

/// Errors in per cent, root mean square and largest, of 60 squares in random places, as measured
/// with another program: rows for resolutions 32 to 512, columns for form factors of about 0.2,
/// 0.02 and 0.002.
const MEASURED: [[(f64, f64); 3]; 5] = [
    [(0.73, 2.0), (3.7, 13.0), (16.0, 48.0)],
    [(0.20, 1.0), (1.3, 6.4), (6.4, 16.0)],
    [(0.06, 0.34), (0.39, 1.5), (1.9, 6.1)],
    [(0.05, 0.21), (0.13, 0.6), (0.6, 2.3)],
    // The first is 0.02 by the law of the column, R^-1.5; the 60 squares it was measured with,
    // 0.004, were lucky.
    [(0.02, 0.08), (0.04, 0.11), (0.7, 2.6)],
];

#[test]
fn aliasing_is_as_small_as_pixels_allow() {
    for (row, resolution) in MEASURED.iter().zip([32, 64, 128, 256, 512]) {
        for ((expected, _), wanted) in row.iter().zip([0.2, 0.02, 2e-3]) {
            let found = errors(wanted, resolution);
            let rms = 100.0 * found.rms;
            assert!(rms < 1.5 * expected, "R {resolution}, F {wanted}: {rms} %");
            assert_eq!(found.missed, 0);
        }
    }
}

/// What is smaller than a pixel is found by chance or not at all.
#[test]
fn small_things_are_missed_in_coarse_pictures() {
    let missed = [32, 64, 128, 256].map(|r| errors(2e-5, r).missed);
    for (found, measured) in missed.into_iter().zip([56_u32, 43, 11, 0]) {
        assert!(found.abs_diff(measured) <= 6, "{missed:?}");
    }
    for (resolution, rms) in [(128, 0.13), (256, 0.05), (512, 0.014)] {
        let found = errors(2e-4, resolution);
        assert!(found.rms < 1.5 * rms, "R {resolution}: {}", found.rms);
    }
}

/// Pixels of a sixteenth of the smallest thing's solid angle are enough for 5 %.
#[test]
fn pixels_small_beside_the_target_are_enough() {
    for wanted in [0.02, 2e-3, 2e-4_f32] {
        // A pixel has at most the solid angle 4/R², the target at least π F.
        let needed = (16.0 * 4.0 / (std::f32::consts::PI * wanted)).sqrt();
        let found = errors(wanted, (needed as u32).next_multiple_of(2));
        assert!(found.rms < 0.05, "F {wanted}: {}", found.rms);
    }
}

/// Errors differ from one roll to the next, but no more than from one square to the next.
#[test]
fn the_roll_decides_little() {
    let scene = random_square(0.02, &mut Dice(3));
    for (resolution, row) in [(32, MEASURED[0]), (64, MEASURED[1]), (128, MEASURED[2])] {
        let found: Vec<f64> = (0..64)
            .map(|seed| square(&scene, resolution, seed).0)
            .collect();
        let mean = found.iter().sum::<f64>() / 64.0;
        let exact = square(&scene, resolution, 0).1;
        let largest = 0.01 * row[1].1;
        assert!((mean / exact - 1.0).abs() < 0.3 * largest, "{mean} {exact}");
        let off = found.iter().map(|f| (f / mean - 1.0).abs());
        let most = off.fold(0.0, f64::max);
        assert!(most < largest && most > 0.0, "R {resolution}: {most}");
    }
}
