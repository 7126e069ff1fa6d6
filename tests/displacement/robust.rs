//! Failure modes 26, 27 and 29: thin pieces, folds, budgets and broken input.

use bevy_fresco::displacement::{
    Base, Displaced, DisplacementError, DisplacementSettings, Spacing, Stop, Tessellation, Watch,
    displace, result_bytes,
};
use bevy_fresco::height_map::{HeightMap, HeightMapError, Wrap};
use glam::{Vec2, Vec3, vec3};

use crate::meshes::{cube, cylinder, map, noise, plane, sphere};
use crate::watertight::assert_watertight;

fn settings(tessellation: Tessellation) -> DisplacementSettings {
    DisplacementSettings {
        tessellation,
        ..DisplacementSettings::default()
    }
}

const TEXELS: Tessellation = Tessellation::Uniform(Spacing::Texels(1.0));

/// The inside of a pipe of radius 1, raised beyond its axis.
#[test]
fn mode_27_folds_are_found_and_clamped() {
    let pipe = cylinder(48, 4, true);
    let run = |scale: f32, clamp_folds: bool| -> Displaced {
        let settings = DisplacementSettings {
            scale,
            clamp_folds,
            ..settings(TEXELS)
        };
        displace(&[pipe.base()], &map([48, 4], |_, _| 1.0), &settings, &()).unwrap()
    };
    let sound = run(0.8, false);
    assert_eq!((sound.report.folded, sound.report.clamped), (0, 0));
    let folded = run(1.2, false);
    assert_eq!(folded.report.folded, folded.report.vertices);
    let clamped = run(1.2, true);
    assert_eq!(clamped.report.folded, 0);
    assert_eq!(clamped.report.clamped, clamped.report.vertices);
    for p in &clamped.parts[0].positions {
        let radius = Vec3::new(p.x, 0.0, p.z).length();
        assert!(radius > 0.02 && p.x.is_finite(), "{radius}");
    }
    assert_watertight("clamped pipe", &[pipe.base()], &clamped, 0.0);
    // Dug in from the outside it is the same.
    let dug = DisplacementSettings {
        scale: -1.2,
        ..settings(TEXELS)
    };
    let rod = cylinder(48, 4, false);
    let dug = displace(&[rod.base()], &map([48, 4], |_, _| 1.0), &dug, &()).unwrap();
    assert_eq!(dug.report.folded, dug.report.vertices);
}

#[test]
fn mode_29_what_there_is_no_room_for_gets_coarser() {
    let map = map([4096; 2], |x, y| ((x ^ y) & 255) as f32 / 255.0);
    let settings = DisplacementSettings {
        max_bytes: 64 << 20,
        ..settings(TEXELS)
    };
    let displaced = displace(&[plane(1.0).base()], &map, &settings, &()).unwrap();
    let report = &displaced.report;
    assert_eq!(report.stop, Stop::Memory);
    assert!(
        report.bytes <= 64 << 20 && report.bytes > 60 << 20,
        "{report:?}"
    );
    let share = report.density.unwrap();
    assert!((0.2..0.3).contains(&share), "{share}");
    let part = &displaced.parts[0];
    let counted = (
        part.positions.len() as u64,
        part.mesh.triangles.len() as u64,
    );
    assert_eq!(counted, (report.vertices, report.triangles));
    assert_eq!(
        report.bytes,
        result_bytes(report.vertices, report.triangles)
    );
    // What is counted is what there is.
    let real = size_of_val(&part.positions[..])
        + size_of_val(&part.normals[..])
        + size_of_val(&part.mesh.vertices[..])
        + size_of_val(&part.mesh.triangles[..])
        + size_of_val(&part.mesh.sources[..]);
    assert_eq!(report.bytes, real as u64);

    let few = DisplacementSettings {
        max_triangles: 1000,
        ..settings
    };
    let displaced = displace(&[cube().base()], &map, &few, &()).unwrap();
    assert_eq!(displaced.report.stop, Stop::Triangles);
    assert!(
        (800..=1000).contains(&displaced.report.triangles),
        "{:?}",
        displaced.report
    );
    assert_watertight("few triangles", &[cube().base()], &displaced, 0.0);
}

/// More than 32 bits can number: coarser, and no overflow on the way.
#[test]
fn mode_29_nothing_overflows() {
    let mut mesh = plane(1.0);
    mesh.uvs.iter_mut().for_each(|uv| *uv *= 1e9);
    let settings = DisplacementSettings {
        max_triangles: 5000,
        max_bytes: u64::MAX,
        ..settings(TEXELS)
    };
    let displaced = displace(&[mesh.base()], &noise(64, 1), &settings, &()).unwrap();
    assert_eq!(displaced.report.stop, Stop::Triangles);
    assert!(displaced.report.triangles > 4000);
    // Nothing asked for, nothing cut.
    let none = DisplacementSettings {
        max_triangles: 0,
        ..settings
    };
    let displaced = displace(&[mesh.base()], &noise(64, 1), &none, &()).unwrap();
    assert_eq!(displaced.report.triangles, 2);
}

#[test]
fn mode_29_what_is_broken_is_told() {
    let nan = HeightMap::new([2; 2], vec![0.0, 1.0, f32::NAN, 0.0], [Wrap::Clamp; 2]);
    assert_eq!(nan, Err(HeightMapError::NotFinite { x: 0, y: 1 }));

    let rough = noise(8, 1);
    let error = |base: Base, settings: DisplacementSettings| {
        displace(&[base], &rough, &settings, &())
            .unwrap_err()
            .to_string()
    };
    let told = |scale: f32| {
        error(
            plane(1.0).base(),
            DisplacementSettings {
                scale,
                ..settings(TEXELS)
            },
        )
    };
    assert!(told(f32::NAN).contains("scale of NaN"));
    let high = told(1e30);
    assert!(
        high.starts_with("with a scale of 1e30 heights reach 9.9"),
        "{high}"
    );
    assert!(high.ends_with("choose a smaller scale"), "{high}");
    let spacing = settings(Tessellation::Uniform(Spacing::Texels(0.0)));
    assert!(error(plane(1.0).base(), spacing).starts_with("spacing of 0"));
    let tolerance = settings(Tessellation::Adaptive { tolerance: -1.0 });
    assert!(error(plane(1.0).base(), tolerance).starts_with("tolerance of -1"));

    let mut mesh = plane(1.0);
    mesh.positions[2].y = f32::INFINITY;
    assert!(error(mesh.base(), settings(TEXELS)).contains("vertex 2 of part 0 has a position"));
    let mut mesh = plane(1.0);
    mesh.uvs[1].x = f32::NAN;
    assert!(
        error(mesh.base(), settings(TEXELS)).contains("vertex 1 of part 0 has a texture coord")
    );
    let mut mesh = plane(1.0);
    mesh.triangles[1][0] = 9;
    assert!(error(mesh.base(), settings(TEXELS)).contains("triangle 1 of part 0 has vertex 9"));
    let mut mesh = plane(1.0);
    mesh.uvs.clear();
    assert!(error(mesh.base(), settings(TEXELS)).contains("has no texture coordinates"));
    mesh.uvs = vec![Vec2::ZERO; 3];
    assert!(error(mesh.base(), settings(TEXELS)).contains("4 vertices and 3 texture coordinates"));
}

#[test]
fn mode_29_what_can_be_mended_is_counted() {
    let mut mesh = sphere(8, 4);
    mesh.normals[3] = Vec3::ZERO;
    mesh.normals[4] = Vec3::NAN;
    // Without area: two corners the same, and three on a line.
    let last = mesh.triangles.len() as u32;
    mesh.triangles.push([12, 12, 13]);
    let a = mesh.vertex(vec3(5.0, 0.0, 0.0), Vec3::Y, Vec2::ZERO);
    let b = mesh.vertex(vec3(6.0, 0.0, 0.0), Vec3::Y, Vec2::X);
    let c = mesh.vertex(vec3(7.0, 0.0, 0.0), Vec3::Y, Vec2::X * 2.0);
    mesh.triangles.push([a, b, c]);
    for scale in [0.1, -0.1, 1000.0, 0.0] {
        let settings = DisplacementSettings {
            scale,
            ..settings(TEXELS)
        };
        let displaced = displace(&[mesh.base()], &noise(16, 4), &settings, &()).unwrap();
        assert_eq!(
            (displaced.report.mended_normals, displaced.report.zero_area),
            (2, 2)
        );
        let part = &displaced.parts[0];
        assert!(part.positions.iter().all(|p| p.is_finite()));
        assert!(part.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-4));
        assert!(
            part.mesh.sources.contains(&last),
            "what has no area is kept"
        );
    }
}

/// Two sheets back to back have normals that cancel out: they stay, and it is told.
#[test]
fn mode_29_sheets_back_to_back_stay() {
    let mut mesh = plane(1.0);
    let back = mesh.clone();
    for (p, uv) in back.positions.iter().zip(&back.uvs) {
        mesh.vertex(*p, Vec3::NEG_Z, *uv);
    }
    mesh.triangles.extend([[4, 6, 5], [4, 7, 6]]);
    let displaced = displace(&[mesh.base()], &noise(8, 4), &settings(TEXELS), &()).unwrap();
    assert_eq!(displaced.report.undirected, 4);
    assert!(displaced.parts[0].positions.iter().all(|p| p.z == 0.0));
}

#[test]
fn nothing_comes_of_nothing() {
    let none = displace(&[], &noise(4, 1), &settings(TEXELS), &()).unwrap();
    assert_eq!((none.parts.len(), none.report.triangles), (0, 0));
    let empty = displace(
        &[Base::default(), plane(1.0).base()],
        &noise(4, 1),
        &settings(TEXELS),
        &(),
    );
    let empty = empty.unwrap();
    assert_eq!(empty.parts[0].positions.len(), 0);
    assert_eq!(empty.parts[1].mesh.triangles.len(), 32);
}

#[test]
fn whoever_watches_can_stop_it() {
    struct Stopped;
    impl Watch for Stopped {
        fn goes_on(&self, _: &'static str, _: f32) -> bool {
            false
        }
    }
    for tessellation in [TEXELS, Tessellation::Adaptive { tolerance: 0.001 }] {
        let result = displace(
            &[plane(1.0).base()],
            &noise(8, 1),
            &settings(tessellation),
            &Stopped,
        );
        assert_eq!(result, Err(DisplacementError::Cancelled));
    }
}
