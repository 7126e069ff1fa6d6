use thiserror::Error;

/// Why nothing is displaced.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DisplacementError {
    /// A setting is outside its limits.
    #[error("{what} of {value}: it must be {limits}")]
    Setting {
        /// Which.
        what: &'static str,
        /// What it is.
        value: f32,
        /// What it may be.
        limits: &'static str,
    },
    /// Not one value for each vertex.
    #[error("part {part} has {vertices} vertices and {found} {what}: there must be as many")]
    Count {
        /// Which mesh of those given.
        part: usize,
        /// How many vertices it has.
        vertices: usize,
        /// Of what there are more or fewer.
        what: &'static str,
        /// How many of those.
        found: usize,
    },
    /// There are no texture coordinates to find heights by.
    #[error("part {part} has no texture coordinates, which tell where on the map it is: unwrap it")]
    NoUvs {
        /// Which mesh of those given.
        part: usize,
    },
    /// A triangle has a vertex that there is not.
    #[error(
        "triangle {triangle} of part {part} has vertex {vertex}, and there are {count}: the mesh is broken"
    )]
    Index {
        /// Which mesh of those given.
        part: usize,
        /// Which triangle.
        triangle: usize,
        /// The vertex it has.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// A vertex has a position or texture coordinate that is no number.
    #[error("vertex {vertex} of part {part} has a {what} that is no finite number: mend the mesh")]
    NotFinite {
        /// Which mesh of those given.
        part: usize,
        /// Which vertex.
        vertex: usize,
        /// Which value of it.
        what: &'static str,
    },
    /// There are more triangles than 32 bits number.
    #[error(
        "the meshes have {0} triangles together, more than can be numbered: displace fewer at a time"
    )]
    TooLarge(u64),
    /// Heights go beyond what 32-bit positions hold.
    #[error("with a scale of {scale:e} heights reach {height:e} m: choose a smaller scale")]
    TooHigh {
        /// The scale that was asked for.
        scale: f32,
        /// The largest distance from the base.
        height: f32,
    },
    /// Whoever watched asked to stop.
    #[error("stopped")]
    Cancelled,
}
