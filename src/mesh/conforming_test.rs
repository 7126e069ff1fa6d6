use super::*;
use crate::mesh::test_meshes::{Mesh, cube, unshared};

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
