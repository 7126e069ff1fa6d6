#![allow(clippy::unwrap_used, reason = "tests")]

use bevy::mesh::VertexAttributeValues as Values;
use bevy::prelude::*;

use super::attributes::displaced_mesh;
use crate::displacement::{
    Base, DisplacedPart, DisplacementSettings, Spacing, Tessellation, displace,
};
use crate::height_map::{HeightMap, Wrap};
use crate::plugin::radiosity::mesh_data;

/// A ramp along `u`, 0 to 1 over the middle of the map.
fn ramp() -> HeightMap {
    let heights = (0..16).map(|x| x as f32 / 15.0).collect();
    HeightMap::new([16, 1], heights, [Wrap::Clamp; 2]).unwrap()
}

fn raise(mesh: &Mesh) -> (Mesh, DisplacedPart) {
    let data = mesh_data::read(mesh).unwrap();
    let base = Base {
        positions: &data.positions,
        normals: &data.normals,
        uvs: &data.uvs[0],
        triangles: &data.triangles,
    };
    let settings = DisplacementSettings {
        scale: 0.5,
        tessellation: Tessellation::Uniform(Spacing::Metres(0.25)),
        ..DisplacementSettings::default()
    };
    let mut displaced = displace(&[base], &ramp(), &settings, &()).unwrap();
    let part = displaced.parts.remove(0);
    (displaced_mesh(mesh, &data, &part), part)
}

/// A square of 2 m with its front to +z.
fn square() -> Mesh {
    Plane3d::new(Vec3::Z, Vec2::splat(1.0)).into()
}

fn float4(mesh: &Mesh, attribute: bevy::mesh::MeshVertexAttribute) -> Vec<Vec4> {
    match mesh.attribute(attribute) {
        Some(Values::Float32x4(values)) => values.iter().map(|&v| v.into()).collect(),
        other => panic!("{other:?}"),
    }
}

/// The tangent of a ramp goes up with it, and one across it stays.
#[test]
fn tangents_lie_in_the_surface() {
    let along_u = square().with_inserted_attribute(
        Mesh::ATTRIBUTE_TANGENT,
        vec![Vec3::X.extend(1.0).to_array(); 4],
    );
    let (mesh, part) = raise(&along_u);
    let tangents = float4(&mesh, Mesh::ATTRIBUTE_TANGENT);
    let rises = |t: &Vec4| t.y.abs() < 1e-6 && t.x > 0.0 && t.w == 1.0;
    assert!(tangents.iter().all(rises));
    for (tangent, normal) in tangents.iter().zip(&part.normals) {
        assert!(tangent.truncate().dot(*normal).abs() < 1e-5);
        assert!((tangent.truncate().length() - 1.0).abs() < 1e-5);
    }
    assert!(tangents.iter().any(|t| t.z > 0.1));
    let across = square().with_inserted_attribute(
        Mesh::ATTRIBUTE_TANGENT,
        vec![Vec3::Y.extend(-1.0).to_array(); 4],
    );
    for tangent in float4(&raise(&across).0, Mesh::ATTRIBUTE_TANGENT) {
        assert!(tangent.distance(Vec3::Y.extend(-1.0)) < 1e-5, "{tangent}");
    }
}

#[test]
fn colours_and_both_texture_coordinates_are_interpolated() {
    let positions = square();
    let positions = positions.attribute(Mesh::ATTRIBUTE_POSITION).unwrap();
    let colors: Vec<[f32; 4]> = (positions.as_float3().unwrap().iter())
        .map(|p| [p[0], p[1], 0.5, 1.0])
        .collect();
    let second: Vec<[f32; 2]> = colors.iter().map(|c| [3.0 * c[0], c[1]]).collect();
    let source = square()
        .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colors)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_1, second);
    let (mesh, part) = raise(&source);
    let uvs = |attribute| match mesh.attribute(attribute) {
        Some(Values::Float32x2(uvs)) => uvs.clone(),
        other => panic!("{other:?}"),
    };
    let (first, second) = (uvs(Mesh::ATTRIBUTE_UV_0), uvs(Mesh::ATTRIBUTE_UV_1));
    let colors = float4(&mesh, Mesh::ATTRIBUTE_COLOR);
    assert!(colors.len() > 64);
    for (i, p) in part.positions.iter().enumerate() {
        assert!(colors[i].distance(Vec4::new(p.x, p.y, 0.5, 1.0)) < 1e-5);
        assert!((first[i][0] - (0.5 + 0.5 * p.x)).abs() < 1e-5);
        assert!((second[i][0] - 3.0 * p.x).abs() < 1e-5);
    }
}

/// Corners that name their joints in another order: between joints 7 and 2 weights go from one to the other.
#[test]
fn joints_are_merged() {
    let source = square();
    let positions = source.attribute(Mesh::ATTRIBUTE_POSITION).unwrap();
    let left: Vec<bool> = (positions.as_float3().unwrap().iter())
        .map(|p| p[0] < 0.0)
        .collect();
    let joints = left.iter().map(|&left| match left {
        true => [7, 0, 0, 0],
        false => [9, 2, 0, 0],
    });
    let weights = left.iter().map(|&left| match left {
        true => [1.0, 0.0, 0.0, 0.0],
        false => [0.0, 1.0, 0.0, 0.0],
    });
    let (joints, weights) = (joints.collect(), weights.collect::<Vec<[f32; 4]>>());
    let source = source
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, Values::Uint16x4(joints))
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);
    let (mesh, part) = raise(&source);
    let weights = float4(&mesh, Mesh::ATTRIBUTE_JOINT_WEIGHT);
    let Some(Values::Uint16x4(joints)) = mesh.attribute(Mesh::ATTRIBUTE_JOINT_INDEX) else {
        panic!("no joints");
    };
    for (i, p) in part.positions.iter().enumerate() {
        let of = |joint| -> f32 {
            let slots = joints[i].iter().zip(weights[i].to_array());
            slots.filter(|(j, _)| **j == joint).map(|(_, w)| w).sum()
        };
        let share = 0.5 + 0.5 * p.x;
        assert!((of(2) - share).abs() < 1e-5 && (of(7) - (1.0 - share)).abs() < 1e-5);
    }
}
