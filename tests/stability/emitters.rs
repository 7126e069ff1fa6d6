//! Emitters that are small, and those that are faint beside others.

use bevy_fresco::radiosity::{BakeSettings, Scene};
use glam::Vec3;

use crate::common::{grey, mean_over, quad, room, scene};
use crate::solved::{apart, baked, mean, of_object, solved};

/// A dim room beside a bright one, of the same shape.
fn dim_and_bright(powers: [f32; 2]) -> Scene {
    let mut objects = Vec::new();
    for (i, _) in powers.iter().enumerate() {
        let at = Vec3::X * (1.1 * i as f32);
        let mut own = room(Vec3::ONE, 6, [0; 6]);
        own.push(quad("lamp", Vec3::new(0.4, 0.95, 0.4), Vec3::X * 0.2, Vec3::Z * 0.2, 1, 1 + i as u32));
        own.iter_mut().flat_map(|o| &mut o.positions).for_each(|p| *p += at);
        objects.extend(own);
    }
    scene(objects, vec![grey(0.5, 0.0), grey(0.0, powers[0]), grey(0.0, powers[1])])
}

#[test]
fn dim_light_beside_bright_light() {
    for preset in [BakeSettings::BALANCED, BakeSettings::FINAL] {
        let alone = dim_and_bright([1.0, 1.0]);
        let shapes = alone.objects.clone();
        let a = baked(alone.clone(), &preset);
        let ae = solved(alone, &preset);
        let both = dim_and_bright([1e-6, 1e6]);
        let b = baked(both.clone(), &preset);
        let e = solved(both, &preset);
        for o in 0..14 {
            let power = if o < 7 { 1e-6 } else { 1e6 };
            eprintln!("object {o}: vertices {} elements {} direct {}", mean_over(&shapes[o], &b.objects[o].light) / power / mean_over(&shapes[o], &a.objects[o].light),
                mean(of_object(&e, o as u32), |e| e.irradiance.x) / power / mean(of_object(&ae, o as u32), |e| e.irradiance.x),
                mean(of_object(&e, o as u32), |e| e.direct.x) / power / mean(of_object(&ae, o as u32), |e| e.direct.x));
        }
        eprintln!("{:?}", e.report.solver);
    }
    let _ = apart;
}
