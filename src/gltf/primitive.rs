//! One primitive as the file has it: attributes, triangles, morph targets in their default state.

use glam::{DVec3, Vec2, Vec3, Vec4};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, MorphTarget, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::accessor::Accessors;
use super::notes::Notes;

/// A primitive in the space of its mesh.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    pub(super) positions: Vec<DVec3>,
    /// As many as positions, or none. May hold zeros and NaN.
    pub(super) normals: Vec<DVec3>,
    pub(super) uvs: Vec<Vec<Vec2>>,
    pub(super) colors: Vec<Vec4>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Whether the triangles were turned around.
    pub(super) flipped: bool,
    /// Joints and weights, the same number (a multiple of four) for every vertex; or none.
    pub(super) joints: Vec<u32>,
    pub(super) weights: Vec<f32>,
}

/// Reads primitives. `name` is what notes call them.
#[derive(Debug)]
pub(super) struct Reader<'a, 'n> {
    pub(super) accessors: Accessors<'a>,
    pub(super) name: &'a str,
    pub(super) notes: &'n mut Notes,
}

impl Reader<'_, '_> {
    /// The primitive, or nothing if it has no triangles; a note says so then.
    pub(super) fn read(
        &mut self,
        primitive: &Primitive,
        morph_weights: &[f32],
    ) -> Result<Option<Geometry>, String> {
        let Checked::Valid(mode) = primitive.mode else {
            return Err("has an unknown mode".to_owned());
        };
        let kind = match mode {
            Mode::Points => "points",
            Mode::Lines | Mode::LineLoop | Mode::LineStrip => "lines",
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan => "triangles",
        };
        if kind != "triangles" {
            self.note(&format!("consists of {kind}, which have no surface"));
            return Ok(None);
        }
        let Some(positions) = find(primitive, Semantic::Positions) else {
            self.note("has no positions");
            return Ok(None);
        };
        self.refuse_compressed(primitive, positions)?;
        let mut geometry = Geometry {
            positions: self.vectors(positions)?,
            ..Geometry::default()
        };
        geometry.triangles = self.triangles(primitive, mode, geometry.positions.len())?;
        if geometry.triangles.is_empty() {
            self.note("has no triangles");
            return Ok(None);
        }
        self.read_attributes(primitive, &mut geometry)?;
        self.morph(primitive, morph_weights, &mut geometry)?;
        match geometry.positions.iter().position(|p| !p.is_finite()) {
            Some(vertex) => Err(format!(
                "has a position that is no number (vertex {vertex})"
            )),
            None => Ok(Some(geometry)),
        }
    }

    fn note(&mut self, what: &str) {
        self.notes.add(format!("{} {what}: left out.", self.name));
    }

    /// Without its extension a compressed primitive would be all zeros.
    fn refuse_compressed(&self, primitive: &Primitive, positions: usize) -> Result<(), String> {
        let draco = "KHR_draco_mesh_compression";
        let extensions = primitive.extensions.as_ref();
        let compressed = extensions.is_some_and(|all| all.others.contains_key(draco));
        if compressed && self.accessors.is_empty(positions) {
            return Err(format!(
                "is compressed with {draco} and has no uncompressed copy: export uncompressed"
            ));
        }
        Ok(())
    }

    fn read_attributes(
        &mut self,
        primitive: &Primitive,
        geometry: &mut Geometry,
    ) -> Result<(), String> {
        let count = geometry.positions.len();
        let same = |what: &str, other: usize| {
            let message = || format!("has {count} positions but {other} {what}");
            if other == count {
                Ok(())
            } else {
                Err(message())
            }
        };
        if let Some(accessor) = find(primitive, Semantic::Normals) {
            geometry.normals = self.vectors(accessor)?;
            same("normals", geometry.normals.len())?;
        }
        while let Some(accessor) = find(primitive, Semantic::TexCoords(geometry.uvs.len() as u32)) {
            let (values, width) = self.finite(accessor, &[Type::Vec2], 0.0)?;
            let uvs: Vec<_> = values.chunks_exact(width).map(Vec2::from_slice).collect();
            same("texture coordinates", uvs.len())?;
            geometry.uvs.push(uvs);
        }
        if let Some(accessor) = find(primitive, Semantic::Colors(0)) {
            let (values, width) = self.finite(accessor, &[Type::Vec3, Type::Vec4], 1.0)?;
            let colors = values.chunks_exact(width);
            geometry.colors = colors
                .map(|c| Vec4::new(c[0], c[1], c[2], c.get(3).copied().unwrap_or(1.0)))
                .collect();
            same("colours", geometry.colors.len())?;
        }
        self.read_skin(primitive, geometry)
    }

    /// Joints and weights, those of several sets one after the other for each vertex.
    fn read_skin(&mut self, primitive: &Primitive, geometry: &mut Geometry) -> Result<(), String> {
        let count = geometry.positions.len();
        let mut sets = Vec::new();
        while let (Some(joints), Some(weights)) = (
            find(primitive, Semantic::Joints(sets.len() as u32)),
            find(primitive, Semantic::Weights(sets.len() as u32)),
        ) {
            let (joints, _) = self.accessors.integers(joints, Type::Vec4)?;
            let (weights, _) = self.finite(weights, &[Type::Vec4], 0.0)?;
            if joints.len() != 4 * count || weights.len() != 4 * count {
                return Err(format!(
                    "has {count} positions but not as many joints and weights"
                ));
            }
            sets.push((joints, weights));
        }
        for vertex in 0..count {
            for (joints, weights) in &sets {
                geometry.joints.extend(&joints[4 * vertex..][..4]);
                geometry.weights.extend(&weights[4 * vertex..][..4]);
            }
        }
        Ok(())
    }

    fn morph(
        &mut self,
        primitive: &Primitive,
        weights: &[f32],
        geometry: &mut Geometry,
    ) -> Result<(), String> {
        let targets = primitive.targets.as_deref().unwrap_or_default();
        if targets.is_empty() {
            return Ok(());
        }
        self.notes.add(format!(
            "{} has morph targets: its default shape is used.",
            self.name
        ));
        for (target, &weight) in targets.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
            let MorphTarget {
                positions, normals, ..
            } = target;
            for (deltas, base) in [
                (positions, &mut geometry.positions),
                (normals, &mut geometry.normals),
            ] {
                let Some(deltas) = deltas.filter(|_| !base.is_empty()) else {
                    continue;
                };
                let deltas = self.vectors(deltas.value())?;
                if deltas.len() != base.len() {
                    return Err(format!(
                        "has {} vertices but a morph target of {}",
                        base.len(),
                        deltas.len()
                    ));
                }
                for (value, delta) in base.iter_mut().zip(deltas) {
                    *value += f64::from(weight) * delta;
                }
            }
        }
        Ok(())
    }

    fn vectors(&self, accessor: usize) -> Result<Vec<DVec3>, String> {
        let (values, width) = self.accessors.floats(accessor, &[Type::Vec3])?;
        let vectors = values.chunks_exact(width);
        Ok(vectors.map(|v| Vec3::from_slice(v).as_dvec3()).collect())
    }

    /// Numbers, with `instead` for those that are none.
    fn finite(
        &mut self,
        accessor: usize,
        types: &[Type],
        instead: f32,
    ) -> Result<(Vec<f32>, usize), String> {
        let (mut values, width) = self.accessors.floats(accessor, types)?;
        let mut bad = 0;
        for value in values.iter_mut().filter(|value| !value.is_finite()) {
            *value = instead;
            bad += 1;
        }
        if bad > 0 {
            self.notes.add(format!(
                "{} has values in accessors[{accessor}] that are no numbers ({bad}): {instead} is \
                 used instead.",
                self.name
            ));
        }
        Ok((values, width))
    }

    fn triangles(
        &mut self,
        primitive: &Primitive,
        mode: Mode,
        vertices: usize,
    ) -> Result<Vec<[u32; 3]>, String> {
        let indices = match primitive.indices {
            Some(accessor) => self.accessors.integers(accessor.value(), Type::Scalar)?.0,
            None => {
                let count = u32::try_from(vertices).map_err(|_| "has too many vertices")?;
                (0..count).collect()
            }
        };
        if let Some(index) = indices.iter().find(|&&index| index as usize >= vertices) {
            return Err(format!("has index {index}, but only {vertices} vertices"));
        }
        if mode == Mode::Triangles && indices.len() % 3 != 0 {
            self.notes.add(format!(
                "{} has {} indices, which is no multiple of three: the last ones are left out.",
                self.name,
                indices.len()
            ));
        }
        Ok(assemble(&indices, mode))
    }
}

/// Triangles of an index list, all wound as the first.
fn assemble(indices: &[u32], mode: Mode) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let triples = indices.windows(3).enumerate();
            triples
                .map(|(i, t)| {
                    if i % 2 == 0 {
                        [t[0], t[1], t[2]]
                    } else {
                        [t[0], t[2], t[1]]
                    }
                })
                .collect()
        }
        Mode::TriangleFan => {
            let rim = indices.get(1..).unwrap_or_default().windows(2);
            rim.map(|t| [t[0], t[1], indices[0]]).collect()
        }
        _ => indices
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]])
            .collect(),
    }
}

fn find(primitive: &Primitive, semantic: Semantic) -> Option<usize> {
    let accessor = primitive.attributes.get(&Checked::Valid(semantic));
    accessor.map(|accessor| accessor.value())
}
