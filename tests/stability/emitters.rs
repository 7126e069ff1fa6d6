//! Emitters that are small, and those that are faint beside others.

use bevy_fresco::radiosity::{BakeSettings, Object, Scene};
use glam::Vec3;

use crate::common::{grey, mean_over, quad, room, scene};
use crate::solved::{apart, baked, mean, of_object, solved};

/// A black unit room with a lamp of that width below its ceiling.
fn with_lamp(width: f32) -> Scene {
    let mut objects = room(Vec3::ONE, 4, [0; 6]);
    let corner = Vec3::new(0.5 - 0.5 * width, 0.95, 0.5 - 0.5 * width);
    objects.push(quad("lamp", corner, Vec3::X * width, Vec3::Z * width, 1, 1));
    scene(objects, vec![grey(0.0, 0.0), grey(0.0, 1.0)])
}

fn note(notes: &[String]) -> Option<f64> {
    let note = notes.iter().find(|n| n.contains("sample_emitters"))?;
    let figure = note.split("err by ").nth(1)?.split(' ').next()?;
    Some(figure.parse::<f64>().ok()? / 100.0)
}

/// A lamp that is not sampled is found by few rays. The report names the setting and says how much
/// light is about to err; the scatter over the floor's elements is that much (rays spread evenly do
/// better than chance, so somewhat less). A sampled lamp, and a luminous ceiling that rays find with
/// ease, are no cause for a note.
#[test]
fn tiny_lamp_left_to_chance() {
    let chance = BakeSettings {
        sample_emitters: false,
        ..BakeSettings::BALANCED
    };
    for width in [0.2, 0.1, 0.05] {
        let truth = solved(with_lamp(width), &BakeSettings::FINAL);
        let truth = mean(of_object(&truth, 0), |e| e.direct.x);
        let light = solved(with_lamp(width), &chance);
        let square = mean(of_object(&light, 0), |e| {
            (e.direct.x - truth as f32).powi(2)
        });
        let found = square.sqrt() / truth;
        let told = note(&light.report.notes).unwrap();
        eprintln!("lamp {width}: found {found} told {told}");
        let bake = baked(with_lamp(width), &chance);
        eprintln!(
            "vertices: {:?} sampling error {}",
            note(&bake.report.notes),
            bake.report.sampling_error
        );
    }
    assert_eq!(
        note(&solved(with_lamp(0.1), &BakeSettings::BALANCED).report.notes),
        None
    );
    let ceiling = scene(
        room(Vec3::ONE, 4, [0, 1, 0, 0, 0, 0]),
        vec![grey(0.5, 0.0), grey(0.5, 1.0)],
    );
    assert_eq!(note(&solved(ceiling, &chance).report.notes), None);
}

/// Two closed rooms side by side, a lamp of one power in each.
fn two_rooms(powers: [f32; 2]) -> Scene {
    let mut objects: Vec<Object> = Vec::new();
    for at in [0, 1] {
        let mut own = room(Vec3::ONE, 4, [0; 6]);
        let corner = Vec3::new(0.2, 0.95, 0.2);
        own.push(quad(
            "lamp",
            corner,
            Vec3::X * 0.6,
            Vec3::Z * 0.6,
            1,
            1 + at,
        ));
        let beside = Vec3::X * (1.1 * at as f32);
        own.iter_mut()
            .flat_map(|o| &mut o.positions)
            .for_each(|p| *p += beside);
        objects.extend(own);
    }
    let [a, b] = powers.map(|power| grey(0.0, power));
    scene(objects, vec![grey(0.5, 0.0), a, b])
}

#[test]
fn dim_light_beside_bright_light() {
    let settings = BakeSettings::FINAL;
    let alone = solved(two_rooms([1.0, 1.0]), &settings);
    let shapes = two_rooms([1.0; 2]).objects;
    let alone_v = baked(two_rooms([1.0, 1.0]), &settings);
    let powers = [1e-6, 1e6];
    let both = solved(two_rooms(powers), &settings);
    let both_v = baked(two_rooms(powers), &settings);
    for o in 0..14 {
        if o % 7 == 6 {
            continue;
        }
        let power = f64::from(powers[o / 7]);
        let d = |l, f: fn(&bevy_fresco::radiosity::Element) -> f32| mean(of_object(l, o as u32), f);
        eprintln!(
            "{o}: direct {} all {} vertices {}",
            apart(d(&both, |e| e.direct.x) / power, d(&alone, |e| e.direct.x)),
            apart(
                d(&both, |e| e.irradiance.x) / power,
                d(&alone, |e| e.irradiance.x)
            ),
            apart(
                mean_over(&shapes[o], &both_v.objects[o].light) / power,
                mean_over(&shapes[o], &alone_v.objects[o].light)
            )
        );
    }
}
