//! Writes a document back as one `.glb`, with the baked light in it.

mod displaced;
mod earlier;
mod glb;
mod gradient;
mod images;
mod instances;
mod interpolate;
mod marks;
mod materials;
mod primitive;
mod projected;
mod refine;
mod skin;
mod vertex_colors;

pub use self::displaced::{DisplacedPrimitive, to_displaced_glb};
pub use self::projected::{ProjectedPrimitive, to_projected_glb};
use self::{earlier::EarlierLight, glb::Glb, gradient::Nodes, vertex_colors::Painter};
use super::{Document, GltfError, PrimitiveKey};
use crate::radiosity::{DirectLight, ObjectLight};

/// How light is stored in the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum LightEncoding {
    /// As the vertex attribute `_BAKED_LIGHT`, for programs that know it. Nothing is lost, and
    /// programs that do not know it show the scene as if it had not been baked.
    #[default]
    Attribute,
    /// As vertex colours on unlit materials, for any viewer. What is brighter than white is cut
    /// off.
    VertexColors {
        /// Factor from cd/m² to the 0..1 of a vertex colour. Limit: > 0.
        exposure: f32,
    },
}

/// What is written and what is said about it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExportOptions {
    /// How light is stored.
    pub encoding: LightEncoding,
    /// Whether the baked light holds the direct light of the file's lights.
    pub direct: DirectLight,
}

/// Baked light and the primitive it belongs to.
#[derive(Clone, Copy, Debug)]
pub struct BakedPrimitive<'a> {
    /// Which primitive of which node.
    pub key: PrimitiveKey,
    /// Its light, for the vertices of the primitive or of a refined mesh.
    pub light: &'a ObjectLight,
    /// The primitive's triangles as imported, which a refined mesh refers to.
    pub triangles: &'a [[u32; 3]],
    /// Import turned the triangles around because the node mirrors them.
    pub flipped: bool,
}

/// A finished `.glb`.
#[derive(Clone, Debug, Default)]
pub struct Exported {
    /// The whole file.
    pub bytes: Vec<u8>,
    /// What somebody who looks at the result should know, a sentence each.
    pub notes: Vec<String>,
}

/// What is known of a document before light is written into it.
struct Before {
    earlier: EarlierLight,
    nodes: Nodes,
}

/// Writes `document` with the light of `baked` as a single `.glb`.
///
/// Everything else in the document goes through as it came. `light_nodes` are the nodes of the
/// lights that took part: they are marked with whether their direct light is baked.
pub fn to_glb(
    document: &Document,
    baked: &[BakedPrimitive<'_>],
    light_nodes: &[usize],
    options: &ExportOptions,
) -> Result<Exported, GltfError> {
    let mut glb = Glb::merge(document)?;
    images::embed_images(&mut glb);
    let targets = instances::separate_instances(&mut glb, baked)?;
    let mut painter = match options.encoding {
        LightEncoding::Attribute => None,
        LightEncoding::VertexColors { exposure } => Some(Painter::new(&glb, &targets, exposure)?),
    };
    let before = Before {
        earlier: EarlierLight::find(&glb),
        nodes: Nodes::new(&glb.json),
    };
    for (&target, baked) in targets.iter().zip(baked) {
        primitive::write_primitive(&mut glb, target, baked, &before, painter.as_mut())?;
    }
    let directional =
        painter.is_none() && baked.iter().any(|baked| !baked.light.gradient.is_empty());
    if let Some(painter) = painter {
        painter.finish(&mut glb);
    }
    marks::mark(&mut glb, light_nodes, options, directional)?;
    glb.finish()
}
