#![allow(clippy::unwrap_used, reason = "tests")]

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{
    Indices, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues as Values,
};
use bevy::prelude::*;
use bevy::render::render_resource::VertexFormat;

use super::mesh_data::{MeshProblem, lit_mesh, read};
use crate::mesh::split_long_edges;
use crate::plugin::{ATTRIBUTE_BAKED_LIGHT, ATTRIBUTE_BAKED_LIGHT_GRADIENT};

/// A unit square in the plane z = 0.
fn square(topology: PrimitiveTopology) -> Mesh {
    let corners = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
    ];
    Mesh::new(topology, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners)
}

fn faces_z(mesh: &Mesh) -> usize {
    let data = read(mesh).unwrap();
    for t in &data.triangles {
        let [a, b, c] = t.map(|v| data.positions[v as usize]);
        assert!((b - a).cross(c - a).z > 0.0, "{t:?} is turned over");
    }
    data.triangles.len()
}

#[test]
fn strips_keep_their_side_and_restart() {
    let strip = square(PrimitiveTopology::TriangleStrip);
    assert_eq!(faces_z(&strip), 2);
    let indexed = strip.with_inserted_indices(Indices::U16(vec![0, 1, 2, 3, u16::MAX, 0, 1, 2]));
    assert_eq!(faces_z(&indexed), 3);
}

#[test]
fn lists_need_no_indices() {
    let list = square(PrimitiveTopology::TriangleList);
    // The fourth vertex is left over.
    assert_eq!(faces_z(&list), 1);
    let indexed = list.with_inserted_indices(Indices::U32(vec![0, 1, 2, 2, 1, 3]));
    assert_eq!(faces_z(&indexed), 2);
}

#[test]
fn lines_have_no_surface() {
    let lines = square(PrimitiveTopology::LineList);
    assert_eq!(read(&lines).unwrap_err(), MeshProblem::NoSurface);
}

#[test]
fn every_float_format_is_read_as_shaders_do() {
    let with = |format, values| {
        let colors = MeshVertexAttribute {
            format,
            ..Mesh::ATTRIBUTE_COLOR
        };
        let mesh = square(PrimitiveTopology::TriangleList).with_inserted_attribute(colors, values);
        read(&mesh).unwrap().colors
    };
    let bytes = with(
        VertexFormat::Unorm8x4,
        Values::Unorm8x4(vec![[255, 51, 0, 102]; 4]),
    );
    assert!(bytes[0].abs_diff_eq(Vec4::new(1.0, 0.2, 0.0, 0.4), 1e-6));
    let words = with(
        VertexFormat::Unorm16x4,
        Values::Unorm16x4(vec![[65535, 13107, 0, 26214]; 4]),
    );
    assert!(words[0].abs_diff_eq(bytes[0], 1e-6));
    let signed = with(
        VertexFormat::Snorm8x4,
        Values::Snorm8x4(vec![[127, -128, 0, -127]; 4]),
    );
    assert_eq!(signed[0], Vec4::new(1.0, -1.0, 0.0, -1.0));
    let rgb = with(
        VertexFormat::Float32x3,
        Values::Float32x3(vec![[0.5, 0.25, 0.125]; 4]),
    );
    assert_eq!(rgb[0], Vec4::new(0.5, 0.25, 0.125, 1.0));
    let bgra = with(
        VertexFormat::Unorm8x4Bgra,
        Values::Unorm8x4Bgra(vec![[0, 51, 255, 102]; 4]),
    );
    assert!(bgra[0].abs_diff_eq(bytes[0], 1e-6));
    let packed = 1023 | (341 << 10) | (1 << 30);
    let packed = with(
        VertexFormat::Unorm10_10_10_2,
        Values::Unorm10_10_10_2(vec![packed; 4]),
    );
    assert!(packed[0].abs_diff_eq(Vec4::new(1.0, 1.0 / 3.0, 0.0, 1.0 / 3.0), 1e-6));
}

#[test]
fn attributes_follow_a_refined_mesh() {
    let joints: Vec<[u16; 4]> = (0..4).map(|i| [i, 0, 0, 0]).collect();
    let mesh = square(PrimitiveTopology::TriangleStrip)
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_UV_0,
            vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]],
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, Values::Uint16x4(joints));
    let data = read(&mesh).unwrap();
    let refined = split_long_edges(&data.positions, &data.triangles, 0.3, 1000).unwrap();
    let light = vec![Vec3::X; refined.vertices.len()];
    let lit = lit_mesh(&mesh, &data.triangles, Some(&refined), &light, &light);
    assert_eq!(lit.primitive_topology(), PrimitiveTopology::TriangleList);
    assert_eq!(lit.count_vertices(), refined.vertices.len());
    assert!(lit.contains_attribute(ATTRIBUTE_BAKED_LIGHT));
    assert!(lit.contains_attribute(ATTRIBUTE_BAKED_LIGHT_GRADIENT));
    let again = read(&lit).unwrap();
    assert_eq!(again.triangles.len(), refined.triangles.len());
    for (position, uv) in again.positions.iter().zip(&again.uvs[0]) {
        assert!(
            position.truncate().abs_diff_eq(*uv, 1e-6),
            "{position} {uv}"
        );
    }
    let Some(Values::Uint16x4(joints)) = lit.attribute(Mesh::ATTRIBUTE_JOINT_INDEX) else {
        panic!("joints are lost or changed their format");
    };
    assert!(joints.iter().all(|j| j[0] < 4));
    // Without normals of its own, it gets those of its faces.
    assert!(again.normals.iter().all(|n| n.abs_diff_eq(Vec3::Z, 1e-6)));
}

#[test]
fn an_unrefined_mesh_is_kept_as_it_is() {
    let mesh = square(PrimitiveTopology::TriangleStrip);
    let data = read(&mesh).unwrap();
    let lit = lit_mesh(&mesh, &data.triangles, None, &[Vec3::ONE; 4], &[]);
    assert_eq!(lit.primitive_topology(), PrimitiveTopology::TriangleStrip);
    assert_eq!(lit.with_removed_attribute(ATTRIBUTE_BAKED_LIGHT), mesh);
}
