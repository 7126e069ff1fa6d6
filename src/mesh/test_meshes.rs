use glam::Vec3;

pub(super) type Mesh = (Vec<Vec3>, Vec<[u32; 3]>);

/// A plane of `x` by `y` unit cells, two triangles a cell.
pub(super) fn grid(x: u32, y: u32) -> Mesh {
    let positions = (0..(x + 1) * (y + 1))
        .map(|i| Vec3::new((i % (x + 1)) as f32, (i / (x + 1)) as f32, 0.0))
        .collect();
    let triangles = (0..x * y)
        .flat_map(|i| {
            let corner = i % x + i / x * (x + 1);
            let above = corner + x + 1;
            [[corner, corner + 1, above + 1], [corner, above + 1, above]]
        })
        .collect();
    (positions, triangles)
}

/// The unit cube with eight vertices, two triangles a face, seen from outside.
pub(super) fn cube() -> Mesh {
    let positions = (0..8)
        .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32))
        .collect();
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = quads
        .into_iter()
        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    (positions, triangles)
}

/// The same triangles with no vertex shared, as hard edges and texture seams make them.
pub(super) fn unshared((positions, triangles): &Mesh) -> Mesh {
    let positions: Vec<Vec3> = triangles
        .as_flattened()
        .iter()
        .map(|&vertex| positions[vertex as usize])
        .collect();
    let triangles = (0..positions.len() as u32 / 3)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    (positions, triangles)
}

/// Random numbers in `0..1`, the same on every run.
pub(crate) fn random(seed: u32) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    }
}

/// Different triangles between random points, many of them sharing edges, two, three and more at a time.
pub(super) fn soup(points: u32, triangle_count: usize, seed: u32) -> Mesh {
    let possible = points * (points - 1) * (points - 2) / 6;
    assert!(triangle_count < possible as usize, "too few points");
    let mut random = random(seed);
    let positions = (0..points)
        .map(|_| Vec3::new(random(), random(), random()) * 3.0 - 1.0)
        .collect();
    let mut seen = std::collections::HashSet::new();
    let mut triangles = Vec::new();
    while triangles.len() < triangle_count {
        let corners = [0; 3].map(|_| (random() * points as f32) as u32 % points);
        let mut sorted = corners;
        sorted.sort_unstable();
        let is_proper = sorted[0] < sorted[1] && sorted[1] < sorted[2];
        if is_proper && seen.insert(sorted) {
            triangles.push(corners);
        }
    }
    (positions, triangles)
}
