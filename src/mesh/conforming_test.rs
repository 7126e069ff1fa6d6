use std::collections::HashMap;

use super::*;
use crate::mesh::test_meshes::{Mesh, cube, grid, random, soup, unshared};

const FREE: Limits = Limits {
    max_vertices: usize::MAX,
    min_edge: 0.0,
};

fn part(mesh: &Mesh) -> Part<'_> {
    Part {
        positions: &mesh.0,
        triangles: &mesh.1,
        refine: true,
    }
}

fn conforming(meshes: &[Mesh]) -> Conforming {
    let parts: Vec<Part> = meshes.iter().map(part).collect();
    Conforming::new(&parts, 0.0)
}

#[test]
fn smoke() {
    let mut mesh = conforming(&[cube(), unshared(&cube())]);
    let mut cuts = 0;
    for i in 0..1000 {
        let face = i * 7 % mesh.faces();
        assert_eq!(mesh.bisect(face, &FREE, &mut |_| cuts += 1), Bisected::Done);
    }
    assert_eq!(mesh.faces(), 24 + cuts);
}

#[test]
fn speed() {
    let meshes = [grid(100, 100)];
    let mut mesh = conforming(&meshes);
    let mut random = random(3);
    let start = std::time::Instant::now();
    let (mut cuts, mut asked) = (0, 0);
    while cuts < 1_000_000 {
        let face = (random() as f64 * mesh.faces() as f64) as u32 % mesh.faces();
        mesh.bisect(face, &FREE, &mut |_| cuts += 1);
        asked += 1;
    }
    eprintln!("random: {cuts} cuts {asked} asked {:?}", start.elapsed());
    let start = std::time::Instant::now();
    let parts = mesh.parts();
    eprintln!(
        "parts {:?} {}",
        start.elapsed(),
        parts[0].mesh.vertices.len()
    );
    let start = std::time::Instant::now();
    let mesh2 = Conforming::new(
        &[Part {
            positions: &parts[0].mesh.positions(&meshes[0].0, &meshes[0].1),
            triangles: &parts[0].mesh.triangles,
            refine: true,
        }],
        1e-6,
    );
    eprintln!("new {:?} {}", start.elapsed(), mesh2.faces());
    let mut mesh = conforming(&[soup(1000, 30000, 1)]);
    let start = std::time::Instant::now();
    let (mut cuts, mut asked) = (0, 0);
    while cuts < 1_000_000 {
        let face = (random() as f64 * mesh.faces() as f64) as u32 % mesh.faces();
        mesh.bisect(face, &FREE, &mut |_| cuts += 1);
        asked += 1;
    }
    eprintln!("soup: {cuts} cuts {asked} asked {:?}", start.elapsed());
}
