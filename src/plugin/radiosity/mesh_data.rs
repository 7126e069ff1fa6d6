use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;

use crate::mesh::RefinedMesh;
use crate::plugin::{ATTRIBUTE_BAKED_LIGHT, ATTRIBUTE_BAKED_LIGHT_GRADIENT};

/// The part of a mesh that a bake looks at.
#[derive(Debug, Default)]
pub(in crate::plugin) struct MeshData {
    pub(in crate::plugin) positions: Vec<Vec3>,
    /// Empty if the mesh has none.
    pub(in crate::plugin) normals: Vec<Vec3>,
    /// Both sets; a set that the mesh lacks is empty.
    pub(in crate::plugin) uvs: [Vec<Vec2>; 2],
    pub(in crate::plugin) colors: Vec<Vec4>,
    pub(in crate::plugin) triangles: Vec<[u32; 3]>,
}

/// Why a mesh cannot be baked or displaced, as the end of a sentence that starts with the entity's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshProblem {
    /// Its vertices are the renderer's alone.
    #[error(
        "its mesh is not in the main world: add `RenderAssetUsages::MAIN_WORLD` to the mesh's `asset_usage`"
    )]
    NotInMainWorld,
    /// It has no positions, or positions in another format.
    #[error("its mesh has no positions in three floating-point numbers a vertex")]
    NoPositions,
    /// It is no mesh of triangles.
    #[error("its mesh is drawn as points or lines, which have no surface")]
    NoSurface,
}

/// Whether a mesh can be baked or displaced.
pub(in crate::plugin) fn check(mesh: &Mesh) -> Result<(), MeshProblem> {
    // What is only meant for the renderer may be gone in the next frame.
    let stays = mesh.asset_usage.contains(RenderAssetUsages::MAIN_WORLD);
    if !stays || mesh.try_attributes().is_err() || mesh.try_indices_option().is_err() {
        return Err(MeshProblem::NotInMainWorld);
    }
    let position = mesh.try_attribute_option(Mesh::ATTRIBUTE_POSITION);
    if !matches!(position, Ok(Some(p)) if floats(p).is_some_and(|p| p.lanes >= 3)) {
        return Err(MeshProblem::NoPositions);
    }
    match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList | PrimitiveTopology::TriangleStrip => Ok(()),
        _ => Err(MeshProblem::NoSurface),
    }
}

/// Reads a mesh in any vertex format, indexed or not, list or strip.
pub(in crate::plugin) fn read(mesh: &Mesh) -> Result<MeshData, MeshProblem> {
    check(mesh)?;
    let floats = |attribute: MeshVertexAttribute| {
        let values = mesh.try_attribute_option(attribute).ok().flatten();
        values.and_then(floats)
    };
    let positions: Vec<Vec3> = (floats(Mesh::ATTRIBUTE_POSITION))
        .filter(|p| p.lanes >= 3)
        .ok_or(MeshProblem::NoPositions)?
        .vectors(Vec4::truncate);
    let count = positions.len();
    // An attribute of another length is not of these vertices.
    let of_vertices = |attribute, lanes| {
        floats(attribute).filter(|f| f.values.len() == count && f.lanes >= lanes)
    };
    let uvs = [Mesh::ATTRIBUTE_UV_0, Mesh::ATTRIBUTE_UV_1]
        .map(|a| of_vertices(a, 2).map_or_else(Vec::new, |f| f.vectors(|v| v.xy())));
    Ok(MeshData {
        normals: of_vertices(Mesh::ATTRIBUTE_NORMAL, 3)
            .map_or_else(Vec::new, |f| f.vectors(Vec4::truncate)),
        colors: of_vertices(Mesh::ATTRIBUTE_COLOR, 3).map_or_else(Vec::new, |f| f.values),
        triangles: triangles(mesh, count)?,
        positions,
        uvs,
    })
}

fn triangles(mesh: &Mesh, vertices: usize) -> Result<Vec<[u32; 3]>, MeshProblem> {
    let (indices, restart): (Vec<u32>, u32) = match mesh.try_indices_option() {
        Err(_) => return Err(MeshProblem::NotInMainWorld),
        Ok(None) => ((0..vertices as u32).collect(), u32::MAX),
        Ok(Some(Indices::U16(i))) => (i.iter().map(|&i| i.into()).collect(), u16::MAX.into()),
        Ok(Some(Indices::U32(i))) => (i.clone(), u32::MAX),
    };
    match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => Ok(indices.as_chunks::<3>().0.to_vec()),
        PrimitiveTopology::TriangleStrip => Ok(indices
            .split(|&i| i == restart)
            .flat_map(|strip| {
                strip.windows(3).enumerate().map(|(i, w)| match i % 2 {
                    0 => [w[0], w[1], w[2]],
                    _ => [w[1], w[0], w[2]],
                })
            })
            .collect()),
        _ => Err(MeshProblem::NoSurface),
    }
}

/// Values of an attribute as the shader would read them, missing lanes as 0, 0, 0, 1; `None` if the mesh has none
/// or they are integers.
pub(in crate::plugin) fn vectors(mesh: &Mesh, attribute: MeshVertexAttribute) -> Option<Vec<Vec4>> {
    let values = mesh.try_attribute_option(attribute).ok().flatten()?;
    floats(values).map(|floats| floats.values)
}

/// Values of an attribute as the shader would read them, missing lanes as 0, 0, 0, 1.
struct Floats {
    values: Vec<Vec4>,
    lanes: usize,
}

impl Floats {
    fn vectors<T>(self, part: impl Fn(Vec4) -> T) -> Vec<T> {
        self.values.into_iter().map(part).collect()
    }
}

/// `None` for integers, which shaders do not read as floats.
fn floats(values: &VertexAttributeValues) -> Option<Floats> {
    use VertexAttributeValues as V;
    fn widen<const N: usize, T: Copy>(v: &[[T; N]], f: impl Fn(T) -> f32) -> Floats {
        let wide = |lanes: &[T; N]| {
            let mut all = [0.0, 0.0, 0.0, 1.0];
            for (to, from) in all.iter_mut().zip(lanes) {
                *to = f(*from);
            }
            Vec4::from(all)
        };
        Floats {
            values: v.iter().map(wide).collect(),
            lanes: N,
        }
    }
    let unorm8 = |x: u8| f32::from(x) / 255.0;
    let snorm8 = |x: i8| (f32::from(x) / 127.0).max(-1.0);
    let unorm16 = |x: u16| f32::from(x) / 65535.0;
    let snorm16 = |x: i16| (f32::from(x) / 32767.0).max(-1.0);
    Some(match values {
        V::Float32x2(v) => widen(v, |x| x),
        V::Float32x3(v) => widen(v, |x| x),
        V::Float32x4(v) => widen(v, |x| x),
        V::Float16x2(v) => widen(v, |x| x.to_f32()),
        V::Float16x4(v) => widen(v, |x| x.to_f32()),
        V::Float64x2(v) => widen(v, |x| x as f32),
        V::Float64x3(v) => widen(v, |x| x as f32),
        V::Float64x4(v) => widen(v, |x| x as f32),
        V::Unorm8x2(v) => widen(v, unorm8),
        V::Unorm8x4(v) => widen(v, unorm8),
        V::Snorm8x2(v) => widen(v, snorm8),
        V::Snorm8x4(v) => widen(v, snorm8),
        V::Unorm16x2(v) => widen(v, unorm16),
        V::Unorm16x4(v) => widen(v, unorm16),
        V::Snorm16x2(v) => widen(v, snorm16),
        V::Snorm16x4(v) => widen(v, snorm16),
        V::Unorm8x4Bgra(v) => {
            let rgba: Vec<[u8; 4]> = v.iter().map(|&[b, g, r, a]| [r, g, b, a]).collect();
            widen(&rgba, unorm8)
        }
        V::Unorm10_10_10_2(v) => {
            let lane = |x: u32, shift: u32| ((x >> shift) & 1023) as f32 / 1023.0;
            let unpack = |&x: &u32| [lane(x, 0), lane(x, 10), lane(x, 20), (x >> 30) as f32 / 3.0];
            widen(&v.iter().map(unpack).collect::<Vec<_>>(), |x| x)
        }
        V::Float32(v) => widen(&singles(v), |x| x),
        V::Float16(v) => widen(&singles(v), |x| x.to_f32()),
        V::Float64(v) => widen(&singles(v), |x| x as f32),
        V::Unorm8(v) => widen(&singles(v), unorm8),
        V::Snorm8(v) => widen(&singles(v), snorm8),
        V::Unorm16(v) => widen(&singles(v), unorm16),
        V::Snorm16(v) => widen(&singles(v), snorm16),
        _ => return None,
    })
}

fn singles<T: Copy>(v: &[T]) -> Vec<[T; 1]> {
    v.iter().map(|&x| [x]).collect()
}

/// A copy of a mesh that carries light, and its gradient in the space of the mesh if there is one: refined
/// first if the bake did so.
pub(in crate::plugin) fn lit_mesh(
    source: &Mesh,
    triangles: &[[u32; 3]],
    refinement: Option<&RefinedMesh>,
    light: &[Vec3],
    gradient: &[Vec3],
) -> Mesh {
    let mut mesh = match refinement {
        None => source.clone(),
        Some(refinement) => refined(source, triangles, refinement),
    };
    let arrays = |values: &[Vec3]| -> Vec<[f32; 3]> { values.iter().map(Vec3::to_array).collect() };
    mesh.insert_attribute(ATTRIBUTE_BAKED_LIGHT, arrays(light));
    if gradient.is_empty() {
        // The source may have been loaded with one.
        mesh.remove_attribute(ATTRIBUTE_BAKED_LIGHT_GRADIENT);
    } else {
        mesh.insert_attribute(ATTRIBUTE_BAKED_LIGHT_GRADIENT, arrays(gradient));
    }
    mesh
}

/// Every attribute carried over to the refined mesh: floats interpolated, integers of the nearest corner.
pub(in crate::plugin) fn refined(
    source: &Mesh,
    triangles: &[[u32; 3]],
    refinement: &RefinedMesh,
) -> Mesh {
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, source.asset_usage);
    mesh.enable_raytracing = source.enable_raytracing;
    let positions = source.try_attribute(Mesh::ATTRIBUTE_POSITION);
    let count = positions.map_or(0, VertexAttributeValues::len);
    for (attribute, values) in source.try_attributes().into_iter().flatten() {
        // An attribute of another length is not of these vertices.
        if values.len() != count {
            continue;
        }
        let values = interpolated(values, triangles, refinement);
        let attribute = MeshVertexAttribute {
            format: (&values).into(),
            ..*attribute
        };
        mesh.insert_attribute(attribute, values);
    }
    let corners = refinement.triangles.iter().flatten().copied().collect();
    mesh.insert_indices(Indices::U32(corners));
    // A mesh without normals is flat shaded, and refinement gave each face corners of its own.
    if !mesh.contains_attribute(Mesh::ATTRIBUTE_NORMAL) {
        mesh.compute_smooth_normals();
    }
    mesh
}

fn interpolated(
    values: &VertexAttributeValues,
    triangles: &[[u32; 3]],
    refinement: &RefinedMesh,
) -> VertexAttributeValues {
    let Some(floats) = floats(values) else {
        return nearest(values, triangles, refinement);
    };
    let blended = refinement.interpolate(triangles, |[a, b, c], w| {
        let [a, b, c] = [a, b, c].map(|v| floats.values[v as usize]);
        a * w.x + b * w.y + c * w.z
    });
    let lanes = |v: &Vec4| v.to_array();
    match floats.lanes {
        1 => VertexAttributeValues::Float32(blended.iter().map(|v| v.x).collect()),
        2 => VertexAttributeValues::Float32x2(blended.iter().map(|v| v.xy().into()).collect()),
        3 => VertexAttributeValues::Float32x3(blended.iter().map(|v| v.xyz().into()).collect()),
        _ => VertexAttributeValues::Float32x4(blended.iter().map(lanes).collect()),
    }
}

/// Integers, joint indices for one, have no in-between.
fn nearest(
    values: &VertexAttributeValues,
    triangles: &[[u32; 3]],
    refinement: &RefinedMesh,
) -> VertexAttributeValues {
    use VertexAttributeValues as V;
    let corners = refinement.interpolate(triangles, |t, w| t[Vec3::max_position(w)] as usize);
    macro_rules! pick {
        ($($format:ident),*) => {
            match values {
                $(V::$format(v) => V::$format(corners.iter().map(|&c| v[c]).collect()),)*
                other => other.clone(),
            }
        };
    }
    pick!(
        Uint8, Uint8x2, Uint8x4, Sint8, Sint8x2, Sint8x4, Uint16, Uint16x2, Uint16x4, Sint16,
        Sint16x2, Sint16x4, Uint32, Uint32x2, Uint32x3, Uint32x4, Sint32, Sint32x2, Sint32x3,
        Sint32x4
    )
}
