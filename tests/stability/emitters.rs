//! Emitters that are small, and those that are faint beside others.

use bevy_fresco::radiosity::{BakeSettings, Element, Object, Scene};
use glam::Vec3;

use crate::common::{grey, quad, room, scene};
use crate::solved::{apart, baked, mean, of_object, solved};

/// A black unit room with a lamp of that width below its ceiling.
fn with_lamp(width: f32) -> Scene {
    let mut objects = room(Vec3::ONE, 4, [0; 6]);
    let corner = Vec3::new(0.5 - 0.5 * width, 0.95, 0.5 - 0.5 * width);
    objects.push(quad("lamp", corner, Vec3::X * width, Vec3::Z * width, 1, 1));
    scene(objects, vec![grey(0.0, 0.0), grey(0.0, 1.0)])
}

/// The error that a note on lamps left to chance tells of.
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
        refine: false,
        adapt: false,
        ..BakeSettings::BALANCED
    };
    for width in [0.2, 0.1, 0.05] {
        let truth = solved(
            with_lamp(width),
            &BakeSettings {
                refine: false,
                adapt: false,
                ..BakeSettings::FINAL
            },
        );
        let truth = mean(of_object(&truth, 0), |e| e.direct.x);
        let light = solved(with_lamp(width), &chance);
        let square = mean(of_object(&light, 0), |e| {
            (e.direct.x - truth as f32).powi(2)
        });
        let found = square.sqrt() / truth;
        let told = note(&light.report.notes).unwrap();
        assert!(
            (0.5..1.5).contains(&(found / told)),
            "{width}: {found}, {told}"
        );
        let bake = baked(with_lamp(width), &chance);
        let told = note(&bake.report.notes).unwrap();
        let found = f64::from(bake.report.sampling_error);
        assert!(
            (0.3..1.5).contains(&(found / told)),
            "{width}: {found}, {told}"
        );
    }
    assert_eq!(
        note(
            &solved(
                with_lamp(0.1),
                &BakeSettings {
                    refine: false,
                    adapt: false,
                    ..BakeSettings::BALANCED
                }
            )
            .report
            .notes
        ),
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

/// How far light of one lamp in a million beside one of a million is from what it is beside its
/// like, relative: the worst direct light of any wall, and the worst of all light, in each room.
/// Last, the bound that the report gives on the error, as a share of the dim room's light.
fn errors_of_dim_and_bright(settings: &BakeSettings) -> ([f64; 2], [f64; 2], f64) {
    let like = solved(two_rooms([1.0, 1.0]), settings);
    let powers = [1e-6, 1e6];
    let both = solved(two_rooms(powers), settings);
    let (mut direct, mut all) = ([0.0_f64; 2], [0.0_f64; 2]);
    for object in (0..14).filter(|o| o % 7 != 6) {
        let at = object / 7;
        let worse = |worst: f64, light: fn(&Element) -> f32| {
            let [found, truth] = [&both, &like].map(|l| mean(of_object(l, object as u32), light));
            // The ceilings lie behind the lamps.
            let error = apart(found / f64::from(powers[at]), truth);
            if truth > 0.0 { worst.max(error) } else { worst }
        };
        direct[at] = worse(direct[at], |e| e.direct.x);
        all[at] = worse(all[at], |e| e.irradiance.x);
    }
    let dim = mean(of_object(&like, 0), |e| e.irradiance.x) * f64::from(powers[0]);
    (direct, all, both.report.solver.error_bound / dim)
}

/// Lamps of 10⁻⁶ and 10⁶ in rooms of their own: direct light is right in both within 2 %, though
/// the samples of the dim room mostly go to the lamp that it cannot see, and all light is in the
/// bright one. In the dim room light that bounced may be wrong by what the solver's tolerance is of
/// the bright one: by no more than the report says.
#[test]
fn dim_light_beside_bright_light() {
    let (direct, all, bound) = errors_of_dim_and_bright(&BakeSettings {
        refine: false,
        adapt: false,
        ..BakeSettings::FINAL
    });
    assert!(direct.iter().all(|&e| e < 0.02), "{direct:?}");
    assert!(all[1] < 0.02, "{all:?}");
    assert!(all[0] < bound.max(0.02), "{all:?}, {bound}");
}

/// All light in both, within 2 %.
#[test]
fn bounced_dim_light_beside_bright_light() {
    let (_, all, _) = errors_of_dim_and_bright(&BakeSettings {
        refine: false,
        adapt: false,
        ..BakeSettings::FINAL
    });
    assert!(all.iter().all(|&e| e < 0.02), "{all:?}");
}
