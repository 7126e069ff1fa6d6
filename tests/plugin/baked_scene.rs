//! Light that came with the meshes.

use bevy::prelude::*;
use bevy_fresco::plugin::radiosity::{NoStaticLighting, StaticLighting};
use bevy_fresco::plugin::{ATTRIBUTE_BAKED_LIGHT, BakedScene, FrescoMaterial};

use crate::world::bare_app;

fn mesh(lit: bool) -> Mesh {
    let mesh = Mesh::from(Cuboid::default());
    let count = mesh.count_vertices();
    match lit {
        true => mesh.with_inserted_attribute(ATTRIBUTE_BAKED_LIGHT, vec![[0.5; 3]; count]),
        false => mesh,
    }
}

struct Loaded {
    app: App,
    root: Entity,
    material: Handle<StandardMaterial>,
}

impl Loaded {
    fn new(scene: BakedScene) -> Self {
        let mut app = bare_app();
        let material = StandardMaterial {
            base_color: Color::srgb(0.8, 0.1, 0.1),
            ..default()
        };
        let material = app.world_mut().resource_mut::<Assets<_>>().add(material);
        let root = app.world_mut().spawn((scene, Transform::default())).id();
        Self {
            app,
            root,
            material,
        }
    }

    fn add(&mut self, mesh: impl Into<Handle<Mesh>>, bundle: impl Bundle) -> Entity {
        let look = (Mesh3d(mesh.into()), MeshMaterial3d(self.material.clone()));
        let world = self.app.world_mut();
        world.spawn((look, bundle, ChildOf(self.root))).id()
    }

    fn mesh(&mut self, lit: bool) -> Handle<Mesh> {
        self.app
            .world_mut()
            .resource_mut::<Assets<Mesh>>()
            .add(mesh(lit))
    }

    /// The material that shows light, if it has one.
    fn shown(&self, entity: Entity) -> Option<&FrescoMaterial> {
        let world = self.app.world();
        let material = world.get::<MeshMaterial3d<FrescoMaterial>>(entity)?;
        assert!(
            world
                .get::<MeshMaterial3d<StandardMaterial>>(entity)
                .is_none()
        );
        world.resource::<Assets<FrescoMaterial>>().get(&material.0)
    }
}

#[test]
fn meshes_with_light_show_it_and_others_stay() {
    let mut loaded = Loaded::new(BakedScene {
        gain: 2.0,
        ..default()
    });
    let (lit, dark) = (loaded.mesh(true), loaded.mesh(false));
    let [a, b] = [(); 2].map(|()| loaded.add(lit.clone(), ()));
    let without = loaded.add(dark, ());
    // Baked here, which is another plugin's business.
    let elsewhere = loaded.add(lit.clone(), StaticLighting::default());
    let left_out = (StaticLighting::default(), NoStaticLighting);
    let left_out = loaded.add(lit.clone(), left_out);
    let world = loaded.app.world_mut();
    let outside = world
        .spawn((Mesh3d(lit), MeshMaterial3d(loaded.material.clone())))
        .id();
    loaded.app.update();
    for entity in [a, b, left_out] {
        let material = loaded.shown(entity).expect("its light is shown");
        assert_eq!(material.extension.baked_light_gain, 2.0);
        assert_eq!(material.base.base_color, Color::srgb(0.8, 0.1, 0.1));
    }
    let of = |entity| {
        loaded
            .app
            .world()
            .get::<MeshMaterial3d<FrescoMaterial>>(entity)
    };
    assert_eq!(of(a), of(b), "one material stays one");
    for entity in [without, outside] {
        assert!(loaded.shown(entity).is_none());
    }
    let elsewhere = loaded.shown(elsewhere);
    assert!(elsewhere.is_none_or(|material| material.extension.baked_light_gain == 1.0));
}

#[test]
fn a_mesh_that_is_loaded_later_shows_its_light_then() {
    let mut loaded = Loaded::new(BakedScene::default());
    let handle = loaded
        .app
        .world()
        .resource::<Assets<Mesh>>()
        .reserve_handle();
    let entity = loaded.add(handle.clone(), ());
    for _ in 0..3 {
        loaded.app.update();
    }
    assert!(loaded.shown(entity).is_none());
    let mut meshes = loaded.app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes
        .insert(&handle, mesh(true))
        .expect("its place is kept");
    loaded.app.update();
    assert!(loaded.shown(entity).is_some());
}

/// Lights of the scene keep off what has their light already; others, and those left to the engine, do not.
#[test]
fn light_does_not_come_twice() {
    for direct in [true, false] {
        let mut loaded = Loaded::new(BakedScene {
            direct,
            ..default()
        });
        let root = loaded.root;
        let world = loaded.app.world_mut();
        let point = world.spawn((PointLight::default(), ChildOf(root))).id();
        let spot = world.spawn((SpotLight::default(), ChildOf(root))).id();
        let sun = world
            .spawn((DirectionalLight::default(), ChildOf(root)))
            .id();
        let torch = world.spawn(PointLight::default()).id();
        loaded.app.update();
        let world = loaded.app.world();
        let affects = [
            world
                .get::<PointLight>(point)
                .unwrap()
                .affects_lightmapped_mesh_diffuse,
            world
                .get::<SpotLight>(spot)
                .unwrap()
                .affects_lightmapped_mesh_diffuse,
            world
                .get::<DirectionalLight>(sun)
                .unwrap()
                .affects_lightmapped_mesh_diffuse,
        ];
        assert_eq!(affects, [!direct; 3]);
        let torch = world.get::<PointLight>(torch).unwrap();
        assert!(torch.affects_lightmapped_mesh_diffuse);
    }
}

#[test]
fn a_scene_may_be_marked_later() {
    let mut loaded = Loaded::new(BakedScene::default());
    let root = loaded.root;
    let world = loaded.app.world_mut();
    world.entity_mut(root).remove::<BakedScene>();
    let point = world.spawn((PointLight::default(), ChildOf(root))).id();
    loaded.app.update();
    let affects = |app: &App| {
        app.world()
            .get::<PointLight>(point)
            .unwrap()
            .affects_lightmapped_mesh_diffuse
    };
    assert!(affects(&loaded.app));
    loaded
        .app
        .world_mut()
        .entity_mut(root)
        .insert(BakedScene::default());
    loaded.app.update();
    assert!(!affects(&loaded.app));
}
