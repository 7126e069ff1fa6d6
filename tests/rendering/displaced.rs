//! Relief of displaced meshes as the renderer sees it.

use bevy::light::NotShadowCaster;
use bevy::prelude::*;
use bevy_fresco::displacement::{Spacing, Tessellation};
use bevy_fresco::height_map::{HeightMap, Wrap};
use bevy_fresco::plugin::bump::HeightImage;
use bevy_fresco::plugin::displacement::{Displacement, DisplacementStatus};

use crate::picture::Picture;
use crate::scenery::{add, grid};
use crate::stage::{Stage, on_stage};

/// Half a metre high on a square of a metre in the middle of a floor, in the light of a sun that is 20° above the
/// floor on the left; or the square as it was.
fn hill_on_a_floor(stage: &mut Stage, displaced: bool, casts: bool) -> Picture {
    let scene = move |world: &mut World| {
        let (n, side) = (16, 1.0 / 16.0);
        let heights = (0..n * n).map(|i| {
            let at = UVec2::new(i % n, i / n).as_vec2() + 0.5;
            let from_middle = (at * side - 0.5).length().min(0.5);
            0.5 + 0.5 * (std::f32::consts::TAU * from_middle).cos()
        });
        let map = HeightMap::new([n; 2], heights.collect(), [Wrap::Clamp; 2]).unwrap();
        let map = world
            .resource_mut::<Assets<HeightImage>>()
            .add(HeightImage::new(map));
        let material = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial::default());
        let floor = add(world, grid());
        world.spawn((Mesh3d(floor), MeshMaterial3d(material.clone())));
        let square = add(world, Rectangle::new(1.0, 1.0).into());
        let mut square = world.spawn((
            Mesh3d(square),
            MeshMaterial3d(material),
            Transform::from_xyz(0.0, 0.0, 0.002),
        ));
        if displaced {
            let mut displacement = Displacement::new(map, 0.5);
            displacement.settings.tessellation = Tessellation::Uniform(Spacing::Texels(0.5));
            square.insert(displacement);
        }
        if !casts {
            square.insert(NotShadowCaster);
        }
        let sun = Transform::from_xyz(-1.0, 0.0, 20.0_f32.to_radians().tan());
        world.spawn((
            DirectionalLight {
                shadow_maps_enabled: true,
                ..default()
            },
            sun.looking_at(Vec3::ZERO, Vec3::Z),
        ));
    };
    stage.shoot(|_| (), scene);
    // The relief comes from the background.
    loop {
        let picture = stage.change(|_| ());
        let mut statuses = (stage.app().world())
            .try_query::<&DisplacementStatus>()
            .unwrap();
        let status = statuses.iter(stage.app().world()).next().cloned();
        match status {
            None => return picture,
            Some(DisplacementStatus::Done(_)) => return stage.change(|_| ()),
            Some(DisplacementStatus::Failed(problem)) => panic!("{problem}"),
            Some(_) => {}
        }
    }
}

/// Behind the hill the floor is dark, and beside its shadow it is as bright as without a hill.
#[test]
fn displaced_relief_casts_shadows() {
    let [raised, flat, without] = on_stage(|stage| {
        [(true, true), (false, true), (true, false)]
            .map(|(displaced, casts)| hill_on_a_floor(stage, displaced, casts))
    });
    let brightness = |picture: &Picture, x: f32, y: f32| Vec3::from(picture.at(x, y)).length();
    let save = || [&raised, &flat, &without].map(|p| p.save("hill and its shadow"));
    let (behind, beside) = ((0.88, 0.5), (0.88, 0.06));
    let lit = brightness(&flat, behind.0, behind.1);
    let dark = brightness(&raised, behind.0, behind.1);
    assert!(
        lit > 0.0 && dark < 0.05 * lit,
        "{dark} of {lit}: {:?}",
        save()
    );
    // It is the hill's shadow: without it there is none.
    let no_shadow = brightness(&without, behind.0, behind.1);
    assert!(
        (no_shadow - lit).abs() < 0.01 * lit,
        "{no_shadow} of {lit}: {:?}",
        save()
    );
    let (beside, as_before) = (
        brightness(&raised, beside.0, beside.1),
        brightness(&flat, beside.0, beside.1),
    );
    assert!(
        (beside - as_before).abs() < 0.01 * as_before,
        "{beside} of {as_before}: {:?}",
        save()
    );
}
