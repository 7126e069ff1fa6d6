use bevy::mesh::{MeshVertexAttribute, VertexFormat};

/// Baked light of a vertex: irradiance / π, linear RGB in cd/m².
///
/// In glTF files it is the attribute `_BAKED_LIGHT`. Bevy loads it if its glTF plugin is told:
///
/// ```text
/// DefaultPlugins.set(
///     GltfPlugin::default().add_custom_vertex_attribute("BAKED_LIGHT", ATTRIBUTE_BAKED_LIGHT),
/// )
/// ```
///
/// (the name without the underscore, which the loader takes off).
pub const ATTRIBUTE_BAKED_LIGHT: MeshVertexAttribute =
    MeshVertexAttribute::new("BakedLight", 0xF2E5_C0BA, VertexFormat::Float32x3);

/// Where the baked light of a vertex comes from, so that bumps can be shaded by it: its gradient by the
/// normal ([`ObjectLight::gradient`](crate::radiosity::ObjectLight::gradient)), in the space of the mesh
/// ([`local_gradients`](crate::radiosity::local_gradients)).
///
/// In glTF files it is the attribute `_BAKED_LIGHT_GRADIENT`, which Bevy is told to load as `BAKED_LIGHT_GRADIENT`:
/// see [`ATTRIBUTE_BAKED_LIGHT`].
pub const ATTRIBUTE_BAKED_LIGHT_GRADIENT: MeshVertexAttribute =
    MeshVertexAttribute::new("BakedLightGradient", 0xF2E5_C0BB, VertexFormat::Float32x3);

/// Whether an attribute is written by bakes.
pub(super) fn is_baked(attribute: &MeshVertexAttribute) -> bool {
    [ATTRIBUTE_BAKED_LIGHT.id, ATTRIBUTE_BAKED_LIGHT_GRADIENT.id].contains(&attribute.id)
}
