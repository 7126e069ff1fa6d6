use glam::{Vec2, Vec3, vec3};

/// Vertices and triangles of one primitive, triangles counter-clockwise seen from the front.
#[derive(Clone, Default)]
pub(super) struct Shape {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    /// In metres along a quad's sides; see [`Shape::with_uv_scale`].
    pub uvs: Vec<Vec2>,
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// Two shapes in one.
    pub(super) fn and(mut self, other: Self) -> Self {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.uvs.extend(other.uvs);
        let moved = other.triangles.iter().map(|t| t.map(|v| v + first));
        self.triangles.extend(moved);
        self
    }

    /// Texture coordinates that repeat every `metres`.
    pub(super) fn with_uv_scale(mut self, metres: f32) -> Self {
        for uv in &mut self.uvs {
            *uv /= metres;
        }
        self
    }

    /// The same surface seen from the other side.
    pub(super) fn inside_out(mut self) -> Self {
        for normal in &mut self.normals {
            *normal = -*normal;
        }
        for triangle in &mut self.triangles {
            triangle.swap(1, 2);
        }
        self
    }
}

/// A plane quad of `cells` by `cells`, its corners counter-clockwise seen from the front.
///
/// Rows run from `corners[0]` to `corners[1]`. Quads that share two corners and the number of
/// cells between them share the points between to the bit, whichever way round they are told.
pub(super) fn quad(corners: [Vec3; 4], cells: [u32; 2]) -> Shape {
    let [a, b, c, d] = corners;
    let [nu, nv] = cells;
    // Not a + t (b - a): this way round swapping the ends gives the same bits.
    let between = |p: Vec3, q: Vec3, i: u32, n: u32| {
        p * ((n - i) as f32 / n as f32) + q * (i as f32 / n as f32)
    };
    let normal = round((b - a).cross(d - a).normalize());
    let size = Vec2::new(a.distance(b), a.distance(d));
    let mut shape = Shape::default();
    for j in 0..=nv {
        for i in 0..=nu {
            let point = between(between(a, b, i, nu), between(d, c, i, nu), j, nv);
            shape.positions.push(point);
            shape.normals.push(normal);
            let uv = size * Vec2::new(i as f32 / nu as f32, j as f32 / nv as f32);
            shape.uvs.push(uv);
        }
    }
    for j in 0..nv {
        for i in 0..nu {
            let low = j * (nu + 1) + i;
            let high = low + nu + 1;
            shape.triangles.push([low, low + 1, high + 1]);
            shape.triangles.push([low, high + 1, high]);
        }
    }
    shape
}

/// A face of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Face {
    West,
    East,
    Bottom,
    Top,
    North,
    South,
}

impl Face {
    pub(super) const ALL: [Self; 6] = [
        Self::West,
        Self::East,
        Self::Bottom,
        Self::Top,
        Self::North,
        Self::South,
    ];
}

/// One face of the box between two corners, seen from outside; north is -z, west -x.
///
/// `cells` counts along x, y and z.
pub(super) fn box_face(low: Vec3, high: Vec3, cells: [u32; 3], face: Face) -> Shape {
    let at = |x: u32, y: u32, z: u32| {
        let pick = |side: u32, l: f32, h: f32| if side == 0 { l } else { h };
        vec3(
            pick(x, low.x, high.x),
            pick(y, low.y, high.y),
            pick(z, low.z, high.z),
        )
    };
    let [nx, ny, nz] = cells;
    match face {
        Face::West => quad(
            [at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0)],
            [nz, ny],
        ),
        Face::East => quad(
            [at(1, 0, 1), at(1, 0, 0), at(1, 1, 0), at(1, 1, 1)],
            [nz, ny],
        ),
        Face::Bottom => quad(
            [at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)],
            [nx, nz],
        ),
        Face::Top => quad(
            [at(0, 1, 1), at(1, 1, 1), at(1, 1, 0), at(0, 1, 0)],
            [nx, nz],
        ),
        Face::North => quad(
            [at(1, 0, 0), at(0, 0, 0), at(0, 1, 0), at(1, 1, 0)],
            [nx, ny],
        ),
        Face::South => quad(
            [at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)],
            [nx, ny],
        ),
    }
}

/// The box between two corners without the `open` faces, seen from outside.
pub(super) fn cuboid(low: Vec3, high: Vec3, cells: [u32; 3], open: &[Face]) -> Shape {
    Face::ALL
        .into_iter()
        .filter(|face| !open.contains(face))
        .map(|face| box_face(low, high, cells, face))
        .fold(Shape::default(), Shape::and)
}

/// The mantle of an upright column around the origin, smooth, open at both ends.
pub(super) fn column(radius: f32, height: f32, sides: u32, rings: u32) -> Shape {
    let mut shape = Shape::default();
    for ring in 0..=rings {
        for side in 0..=sides {
            let turn = (side % sides) as f32 / sides as f32;
            let angle = std::f32::consts::TAU * turn;
            let out = round(vec3(angle.sin(), 0.0, angle.cos()));
            let up = height * (ring as f32 / rings as f32);
            shape.positions.push(round(out * radius) + Vec3::Y * up);
            shape.normals.push(out);
            let along = side as f32 / sides as f32 * std::f32::consts::TAU * radius;
            shape.uvs.push(Vec2::new(along, up));
        }
    }
    for ring in 0..rings {
        for side in 0..sides {
            let low = ring * (sides + 1) + side;
            let high = low + sides + 1;
            shape.triangles.push([low, low + 1, high + 1]);
            shape.triangles.push([low, high + 1, high]);
        }
    }
    shape
}

/// Rounds off where machines may differ in the last bit of a sine.
fn round(v: Vec3) -> Vec3 {
    (v * 16_384.0).round() / 16_384.0 + Vec3::ZERO
}
