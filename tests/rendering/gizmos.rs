//! Lines over a lit surface are drawn, and without an error of the renderer.

use bevy::prelude::*;
use bevy_fresco::plugin::radiosity::{RadiosityGizmos, RadiosityStatus, StaticLighting};

use crate::scenery::grid;
use crate::stage::on_stage;

#[test]
fn lines_are_drawn() {
    let [with, without] = on_stage(|stage| {
        stage.shoot(
            |_| (),
            |world| {
                let mesh = world.resource_mut::<Assets<Mesh>>().add(grid());
                let grey = StandardMaterial::from_color(Color::srgb(0.5, 0.5, 0.5));
                let grey = world.resource_mut::<Assets<StandardMaterial>>().add(grey);
                let surface = (
                    Mesh3d(mesh),
                    MeshMaterial3d(grey),
                    StaticLighting::default(),
                );
                world.spawn((surface, Transform::default()));
                let light = PointLight {
                    intensity: 1e5,
                    ..default()
                };
                world.spawn((light, Transform::from_xyz(0.0, 0.0, 1.0)));
            },
        );
        for _ in 0..200 {
            if stage
                .app()
                .world()
                .resource::<RadiosityStatus>()
                .is_up_to_date()
            {
                break;
            }
            stage.change(|_| std::thread::sleep(std::time::Duration::from_millis(20)));
        }
        let with = stage.change(|world| {
            world.insert_resource(RadiosityGizmos {
                elements: true,
                contacts: true,
                form_factors: Some(Ray3d {
                    origin: Vec3::new(0.0, 0.0, 1.0),
                    direction: Dir3::NEG_Z,
                }),
                hemicube: true,
            });
        });
        let without = stage.change(|world| world.insert_resource(RadiosityGizmos::default()));
        [with, without]
    });
    let pairs = with.pixels.iter().zip(&without.pixels);
    let changed = pairs.filter(|(a, b)| a != b).count();
    // Outlines cross most of the 64 rows.
    assert!(changed > 200, "{changed} pixels");
    let is_green = |p: &&[f32; 4]| p[1] > 4.0 * p[0] && p[1] > 4.0 * p[2] && p[1] > 0.1;
    assert!(with.pixels.iter().filter(is_green).count() > 10);
}
