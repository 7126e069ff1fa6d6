use glam::DVec2;
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

/// A point of the triangle that is cut.
#[derive(Clone, Copy)]
pub(super) struct Vertex {
    pub(super) at: DVec2,
    /// Which of the triangle's edges it is on, a bit each.
    pub(super) edges: u8,
}

/// The parts of a triangle, as indices of its points, counter-clockwise.
pub(super) struct Parts {
    pub(super) triangles: Vec<[u32; 3]>,
    /// Edges of parts that are contacts.
    pub(super) contacts: Vec<[u32; 2]>,
}

struct Site {
    at: Point2<f64>,
    index: u32,
}

impl HasPosition for Site {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

/// Cuts a triangle into the constrained Delaunay triangulation of `vertices`.
///
/// `outline` goes round the triangle through all vertices on its edges, `links` are the lines that
/// have to be edges. A link that crosses another is left out: the lines were arranged not to, but
/// rounding may have them.
pub(super) fn triangulate(vertices: &[Vertex], outline: &[u32], links: &[[u32; 2]]) -> Parts {
    let mut cdt = ConstrainedDelaunayTriangulation::<Site>::new();
    let handles: Vec<Option<FixedVertexHandle>> = (vertices.iter().enumerate())
        .map(|(index, vertex)| {
            let at = spade::mitigate_underflow(Point2::new(vertex.at.x, vertex.at.y));
            let index = index as u32;
            cdt.insert(Site { at, index }).ok()
        })
        .collect();
    let round = outline.iter().zip(outline.iter().cycle().skip(1));
    let lines = round.map(|(&a, &b)| [a, b]).chain(links.iter().copied());
    for [a, b] in lines {
        if let [Some(a), Some(b)] = [a, b].map(|i| handles[i as usize])
            && a != b
        {
            cdt.try_add_constraint(a, b);
        }
    }
    let is_on_edge = |corners: &[u32]| {
        let shared = |edges, &i: &u32| edges & vertices[i as usize].edges;
        corners.iter().fold(0b111, shared) != 0
    };
    // The points of an edge are on one line but for rounding. What shows beyond it is no part.
    let triangles = (cdt.inner_faces())
        .map(|face| face.vertices().map(|v| v.data().index))
        .filter(|corners| !is_on_edge(corners))
        .collect();
    let contacts = (cdt.undirected_edges())
        .filter(|edge| edge.is_constraint_edge())
        .map(|edge| edge.vertices().map(|v| v.data().index))
        .filter(|ends| !is_on_edge(ends))
        .collect();
    Parts {
        triangles,
        contacts,
    }
}
