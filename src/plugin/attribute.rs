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
