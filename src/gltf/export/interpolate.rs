//! Carries vertex attributes over to the vertices of a refined mesh.

use crate::{gltf::accessor_json::AccessorData, mesh::RefinedMesh};

/// What to do with an attribute between the corners of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// Interpolate.
    Linear,
    /// Interpolate the first three numbers and make their length 1; take what follows, the
    /// handedness of a tangent, from the heaviest corner.
    Direction,
    /// Take the heaviest corner: numbers that name something.
    Nearest,
}

impl Rule {
    pub(super) fn of(attribute: &str) -> Self {
        match attribute {
            "NORMAL" | "TANGENT" => Self::Direction,
            name if name.starts_with("_FEATURE_ID_") => Self::Nearest,
            _ => Self::Linear,
        }
    }
}

/// The source vertices and weights that make up each vertex of a refined mesh.
pub(super) struct Blend {
    corners: Vec<[(usize, f64); 3]>,
    source_count: usize,
}

impl Blend {
    /// All indices must be in range.
    pub(super) fn new(mesh: &RefinedMesh, triangles: &[[u32; 3]], source_count: usize) -> Self {
        let corners = mesh.interpolate(triangles, |[a, b, c], weights| {
            let [u, v, w] = weights.to_array().map(f64::from);
            [(a as usize, u), (b as usize, v), (c as usize, w)]
        });
        Self {
            corners,
            source_count,
        }
    }

    /// How many vertices the source has.
    pub(super) fn source_count(&self) -> usize {
        self.source_count
    }

    /// For each vertex, the source vertices whose weight is not 0.
    pub(super) fn vertices(&self) -> impl Iterator<Item = Corners> {
        self.corners.iter().map(|&corners| Corners(corners))
    }

    /// One attribute of the refined mesh.
    pub(super) fn apply(&self, source: &AccessorData, rule: Rule) -> AccessorData {
        let mut values = Vec::with_capacity(self.corners.len() * source.kind.width());
        for corners in self.vertices() {
            let start = values.len();
            match corners.agreed(source) {
                Some(element) => values.extend_from_slice(element),
                None => corners.blend(source, rule, &mut values),
            }
            debug_assert_eq!(values.len() - start, source.kind.width());
        }
        AccessorData {
            kind: source.kind,
            values,
        }
    }
}

/// What makes up one vertex.
#[derive(Clone, Copy)]
pub(super) struct Corners([(usize, f64); 3]);

impl Corners {
    /// Source vertices and their weights, none of them 0.
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, f64)> {
        self.0.iter().copied().filter(|&(_, weight)| weight != 0.0)
    }

    /// The source vertex, if there is only one.
    pub(super) fn single(&self) -> Option<usize> {
        let mut corners = self.iter();
        let (first, _) = corners.next()?;
        corners.next().is_none().then_some(first)
    }

    /// The value that all corners have in common, so that it goes through bit by bit.
    fn agreed<'a>(&self, source: &'a AccessorData) -> Option<&'a [f64]> {
        let mut elements = self.iter().map(|(vertex, _)| source.element(vertex));
        let first = elements.next()?;
        (self.single().is_some() || elements.all(|element| element == first)).then_some(first)
    }

    fn blend(&self, source: &AccessorData, rule: Rule, values: &mut Vec<f64>) {
        let width = source.kind.width();
        if rule == Rule::Nearest {
            values.extend_from_slice(self.heaviest(source));
            return;
        }
        let start = values.len();
        // Of a vertex on an edge one weight is 0 and two terms remain. Their sum has the same bits
        // in either order, so the triangles on both sides of the edge agree.
        values.extend((0..width).map(|number| {
            self.iter()
                .map(|(vertex, weight)| weight * source.element(vertex)[number])
                .sum::<f64>()
        }));
        if rule == Rule::Direction {
            self.make_direction(source, &mut values[start..]);
        }
    }

    fn make_direction(&self, source: &AccessorData, value: &mut [f64]) {
        let heaviest = self.heaviest(source);
        let axes = value.len().min(3);
        let length = value[..axes].iter().map(|v| v * v).sum::<f64>().sqrt();
        if length > 1e-12 && length.is_finite() {
            value[..axes].iter_mut().for_each(|v| *v /= length);
        } else {
            // Opposite directions cancelled out.
            value[..axes].copy_from_slice(&heaviest[..axes]);
        }
        value[axes..].copy_from_slice(&heaviest[axes..]);
    }

    /// The value of the corner with the largest weight. Of equal weights the larger value counts,
    /// whatever the order of the corners.
    fn heaviest<'a>(&self, source: &'a AccessorData) -> &'a [f64] {
        let element = |vertex| source.element(vertex);
        let larger = |a: usize, b: usize| {
            let pairs = element(a).iter().rev().zip(element(b).iter().rev());
            pairs
                .map(|(a, b)| a.total_cmp(b))
                .find(|order| order.is_ne())
                .unwrap_or(std::cmp::Ordering::Equal)
        };
        self.iter()
            .max_by(|a, b| a.1.total_cmp(&b.1).then_with(|| larger(a.0, b.0)))
            .map_or(&[], |(vertex, _)| element(vertex))
    }
}
