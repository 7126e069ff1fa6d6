//! Views in the place of surfaces' look, to the number.

use bevy::prelude::*;
use bevy_fresco::plugin::FrescoView;

use crate::scenery::{grid, lit, show_fresco};
use crate::stage::{exposure, on_stage};

const LIGHT: Vec3 = Vec3::new(900.0, 500.0, 1300.0);
const EMITTED: Vec3 = Vec3::new(0.1, 0.2, 0.05);

/// The middle of what is seen of a surface of a colour that also emits, lit by the engine's lamp as well.
fn middle(view: FrescoView, light: Vec3) -> Vec3 {
    let picture = on_stage(move |stage| {
        stage.show_view(view);
        stage.shoot(
            |_| (),
            |world| {
                let base = StandardMaterial {
                    base_color: Color::linear_rgb(0.8, 0.4, 0.1),
                    metallic: 0.25,
                    emissive: LinearRgba::from_vec3(EMITTED),
                    ..default()
                };
                show_fresco(world, lit(grid(), light), base, default());
                world.spawn((
                    PointLight {
                        intensity: 1e6,
                        ..default()
                    },
                    Transform::from_xyz(0.0, 0.0, 2.0),
                ));
            },
        )
    });
    Vec3::from(picture.at(0.5, 0.5))
}

#[track_caller]
fn assert_close(found: Vec3, expected: Vec3) {
    let error = (found - expected).abs() / expected.max(Vec3::splat(1e-3));
    assert!(error.max_element() < 0.01, "{found} is not {expected}");
}

#[test]
fn they_show_what_they_say() {
    let light = LIGHT * exposure();
    for view in [
        FrescoView::Irradiance,
        FrescoView::Direct,
        FrescoView::Elements,
    ] {
        assert_close(middle(view, LIGHT), light);
    }
    let reflected = light * Vec3::new(0.8, 0.4, 0.1) * 0.75;
    assert_close(middle(FrescoView::Radiosity, LIGHT), reflected + EMITTED);
    let values = Vec3::new(0.9, 0.1, 0.3);
    assert_close(middle(FrescoView::Error, values), values);
    assert_close(middle(FrescoView::Normals, LIGHT), Vec3::new(0.5, 0.5, 1.0));
    // And back: the lamp and highlights are there again.
    let shaded = middle(FrescoView::Shaded, LIGHT);
    assert!(
        (shaded - reflected - EMITTED).min_element() > 0.01,
        "{shaded}"
    );
}
