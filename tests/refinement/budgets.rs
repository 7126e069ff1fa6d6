//! Vertices, memory and seconds are kept, the report says which of them ended the bake, and how few
//! vertices are enough.

use std::time::Instant;

use bevy_fresco::radiosity::{Bake, BakeError, BakeSettings, ObjectLight, Scene, Stopped, bake};
use rayon::ThreadPoolBuilder;

use crate::known::error::measure;
use crate::known::scenes::{court, lit_scenes, room_with_panel};
use crate::truth::{Known, known};

/// More than can be had.
const LEAST_ERROR: f32 = 0.001;

fn run(scene: &Scene, settings: &BakeSettings) -> Bake {
    bake(&scene.clone().validate().unwrap(), settings, &()).unwrap()
}

fn vertices(baked: &Bake) -> usize {
    baked.objects.iter().map(|o| o.light.len()).sum()
}

/// The light of all objects, to the bit.
fn lights(baked: &Bake) -> Vec<Vec<[u32; 3]>> {
    let bits = |o: &ObjectLight| {
        o.light
            .iter()
            .map(|l| l.to_array().map(f32::to_bits))
            .collect()
    };
    baked.objects.iter().map(bits).collect()
}

#[test]
fn vertices_are_kept_and_used() {
    for scene in lit_scenes().map(|layout| layout.scene()) {
        for allowed in [1_000, 4_000] {
            let settings = BakeSettings {
                refine: true,
                error: LEAST_ERROR,
                max_vertices: allowed,
                ..BakeSettings::DRAFT
            };
            let baked = run(&scene, &settings);
            let used = vertices(&baked);
            assert_eq!(baked.report.stopped, Stopped::Vertices);
            assert!(used <= allowed as usize, "{used} of {allowed}");
            assert!(
                used as f64 >= 0.95 * f64::from(allowed),
                "{used} of {allowed}"
            );
        }
    }
}

/// Hard shadows of the sun take no more vertices than a game has to spare for them.
#[test]
fn hard_shadows_are_followed() {
    let Known { layout, truth } = known(0);
    let settings = BakeSettings {
        refine: true,
        error: 0.03,
        max_vertices: 10_000,
        ..BakeSettings::default()
    };
    let baked = run(&layout.scene(), &settings);
    let error = measure(layout, truth, &baked, 40_000).rmse;
    assert!(error <= 0.03, "{error}");
    assert!(vertices(&baked) <= 6_000, "{}", vertices(&baked));
}

/// With a quarter of the vertices the light is no worse than with all edges cut to one length.
#[test]
fn a_quarter_of_the_vertices_is_enough() {
    for scene in [0, 4] {
        let Known { layout, truth } = known(scene);
        let error = |baked: &Bake| measure(layout, truth, baked, 40_000).rmse;
        for max_edge in [0.2, 0.1] {
            let even = BakeSettings {
                refine: false,
                max_edge: Some(max_edge),
                ..BakeSettings::default()
            };
            let even = run(&layout.scene(), &even);
            let placed = BakeSettings {
                refine: true,
                error: 0.5 * error(&even) as f32,
                max_vertices: vertices(&even) as u32 / 4,
                ..BakeSettings::default()
            };
            let placed = run(&layout.scene(), &placed);
            let name = layout.name;
            assert!(
                error(&placed) <= error(&even),
                "{name}: {} vertices {}, {} vertices {}",
                vertices(&placed),
                error(&placed),
                vertices(&even),
                error(&even)
            );
        }
    }
}

/// Vertices that are given are kept, though fewer are allowed.
#[test]
fn given_vertices_are_kept() {
    let scene = court().scene();
    let settings = BakeSettings {
        refine: true,
        max_vertices: 1,
        ..BakeSettings::DRAFT
    };
    let given: usize = scene.objects.iter().map(|o| o.positions.len()).sum();
    assert!(vertices(&run(&scene, &settings)) >= given);
}

/// An error that takes far longer than there is time for. How long the bake takes when the machine
/// has other things to do is not its fault, so the best of five runs counts.
#[test]
fn seconds_are_kept() {
    let scene = court().scene();
    let seconds = 2.0;
    let settings = BakeSettings {
        refine: true,
        error: LEAST_ERROR,
        max_vertices: 10_000_000,
        max_seconds: Some(seconds),
        ..BakeSettings::DRAFT
    };
    let runs = (0..5).map(|_| {
        let start = Instant::now();
        let baked = run(&scene, &settings);
        assert_eq!(baked.report.stopped, Stopped::Seconds);
        (start.elapsed().as_secs_f64(), vertices(&baked))
    });
    let (took, placed): (Vec<f64>, Vec<usize>) = runs.unzip();
    let least = took.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(least <= 1.05 * f64::from(seconds) + 0.05, "{took:?} s");
    assert!(placed.iter().any(|&n| n > 200), "{placed:?} vertices");
}

#[test]
fn memory_is_kept() {
    let scene = court().scene();
    let settings = |max_memory| BakeSettings {
        refine: true,
        error: 0.003,
        max_vertices: 30_000,
        max_memory,
        ..BakeSettings::DRAFT
    };
    let free = run(&scene, &settings(8 << 30));
    let refused = bake(&scene.clone().validate().unwrap(), &settings(1), &());
    let Err(BakeError::Memory { needed, .. }) = refused else {
        panic!("a bake in one byte");
    };
    // Beside what it takes in any case, room for half of the vertices.
    let allowed = needed + 800 * vertices(&free) as u64;
    let kept = run(&scene, &settings(allowed));
    assert_eq!(kept.report.stopped, Stopped::Memory);
    assert!(
        kept.report.bytes <= allowed,
        "{} of {allowed}",
        kept.report.bytes
    );
    assert!(vertices(&kept) < vertices(&free));
}

/// A pass that was not good enough is added to, not done again: with memory for the rays it takes fewer, and finds
/// the same.
#[test]
fn rays_of_an_earlier_pass_count() {
    let scene = lit_scenes().into_iter().find(|l| l.name == "partition");
    let scene = scene.unwrap().scene();
    let with = |max_memory| {
        let settings = BakeSettings {
            refine: true,
            error: 0.01,
            max_memory,
            ..BakeSettings::DRAFT
        };
        run(&scene, &settings)
    };
    let (kept, thrown) = (with(8 << 30), with(48 << 20));
    let (fewer, all) = (kept.report.work, thrown.report.work);
    assert!(fewer.fits > 1, "one pass");
    assert!(
        fewer.gather_rays < all.gather_rays,
        "{} of {}",
        fewer.gather_rays,
        all.gather_rays
    );
    assert!(lights(&kept) == lights(&thrown), "other light");
}

/// The error that was asked for ends the bake, long before any budget does.
#[test]
fn the_error_ends_the_bake() {
    for scene in lit_scenes().map(|layout| layout.scene()) {
        let settings = BakeSettings {
            refine: true,
            error: 0.1,
            ..BakeSettings::DRAFT
        };
        let report = run(&scene, &settings).report;
        assert_eq!(report.stopped, Stopped::Error);
        assert!(
            report.error.total > 0.0 && report.error.total <= 0.1,
            "{:?}",
            report.error
        );
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    for layout in [court(), room_with_panel()] {
        let scene = layout.scene();
        for settings in [
            BakeSettings {
                refine: true,
                error: 0.1,
                max_vertices: 4_000,
                ..BakeSettings::DRAFT
            },
            BakeSettings {
                max_edge: Some(0.6),
                ..BakeSettings::DRAFT
            },
        ] {
            let on = |threads: usize| {
                let pool = ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .unwrap();
                let baked = pool.install(|| run(&scene, &settings));
                let meshes = baked.objects.iter().map(|o| o.mesh.clone());
                (lights(&baked), meshes.collect::<Vec<_>>())
            };
            let one = on(1);
            assert!(one == on(2) && one == on(5), "{}", layout.name);
        }
    }
}
