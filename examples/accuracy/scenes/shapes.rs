use bevy_fresco::radiosity::{Material, MaterialId, Object, Scene};
use glam::{Vec3, Vec4};

/// A scene in the making: every shape gets a material of its own choice.
#[derive(Default)]
pub(super) struct Builder {
    scene: Scene,
}

/// What a surface reflects and emits.
#[derive(Clone, Copy)]
pub(super) struct Look {
    pub(super) reflectance: Vec3,
    pub(super) emission: Vec3,
    pub(super) double_sided: bool,
}

/// A surface that reflects the same of all colours.
pub(super) fn grey(reflectance: f32) -> Look {
    Look {
        reflectance: Vec3::splat(reflectance),
        emission: Vec3::ZERO,
        double_sided: false,
    }
}

/// A white lamp that reflects nothing.
pub(super) fn lamp(radiance: f32) -> Look {
    Look {
        emission: Vec3::splat(radiance),
        ..grey(0.0)
    }
}

/// Vertices and triangles.
#[derive(Clone, Default)]
pub(super) struct Shape {
    pub(super) positions: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Shape {
    pub(super) fn and(mut self, other: &Self) -> Self {
        let first = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        let moved = other.triangles.iter().map(|t| t.map(|v| v + first));
        self.triangles.extend(moved);
        self
    }
}

impl Builder {
    pub(super) fn with(mut self, name: &str, shape: Shape, look: Look) -> Self {
        let material = MaterialId(self.scene.materials.len() as u32);
        self.scene.materials.push(Material {
            name: name.into(),
            base_color: Vec4::from((look.reflectance, 1.0)),
            emissive: look.emission,
            double_sided: look.double_sided,
            ..Material::default()
        });
        self.scene.objects.push(Object {
            name: name.into(),
            positions: shape.positions,
            triangles: shape.triangles,
            material,
            ..Object::default()
        });
        self
    }

    pub(super) fn finish(self) -> Scene {
        self.scene
    }
}

/// Two triangles; corners counter-clockwise seen from the front.
pub(super) fn quad(corners: [Vec3; 4]) -> Shape {
    Shape {
        positions: corners.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// The parallelogram at `a` with the sides `u` and `v`, facing `u × v`.
pub(super) fn rect(a: Vec3, u: Vec3, v: Vec3) -> Shape {
    quad([a, a + u, a + u + v, a + v])
}

/// The floor, the ceiling and the walls at low x, high x, low z and high z of a room, facing inwards.
pub(super) fn room(low: Vec3, high: Vec3) -> [Shape; 6] {
    let size = high - low;
    let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    [
        rect(low, z, x),
        rect(low + y, x, z),
        rect(low, y, z),
        rect(low + x, z, y),
        rect(low, x, y),
        rect(low + z, y, x),
    ]
}

/// All six sides of a room as one shape.
pub(super) fn whole_room(low: Vec3, high: Vec3) -> Shape {
    join(room(low, high))
}

/// The four upright sides of a column, facing outwards.
pub(super) fn column(low: Vec3, high: Vec3) -> Shape {
    let mut sides = join(room(low, high).into_iter().skip(2));
    for triangle in &mut sides.triangles {
        triangle.swap(1, 2);
    }
    sides
}

/// A square below a ceiling, facing down.
pub(super) fn square_lamp(center: Vec3, side: f32) -> Shape {
    let corner = center - (Vec3::X + Vec3::Z) * (side / 2.0);
    rect(corner, Vec3::X * side, Vec3::Z * side)
}

pub(super) fn join(shapes: impl IntoIterator<Item = Shape>) -> Shape {
    shapes
        .into_iter()
        .fold(Shape::default(), |all, shape| all.and(&shape))
}

/// The unit sphere seen from outside: an icosahedron's faces cut into `cuts²`, moved onto the
/// sphere. Triangles of one face follow each other.
pub(super) fn geodesic_sphere(cuts: u32) -> Shape {
    let golden = (1.0 + 5.0_f32.sqrt()) / 2.0;
    let around = |a: f32, b: f32| {
        [
            Vec3::new(0.0, a, b),
            Vec3::new(b, 0.0, a),
            Vec3::new(a, b, 0.0),
        ]
    };
    let corners: Vec<Vec3> = [
        (1.0, golden),
        (1.0, -golden),
        (-1.0, golden),
        (-1.0, -golden),
    ]
    .into_iter()
    .flat_map(|(a, b)| around(a, b))
    .collect();
    let mut sphere = Shape::default();
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in &corners[j + 1..] {
                // An icosahedron's edges are 2 long, all other distances longer.
                let edge = |p: Vec3, q: Vec3| p.distance(q) < 2.1;
                if edge(a, b) && edge(b, c) && edge(c, a) {
                    let outward = (b - a).cross(c - a).dot(a) > 0.0;
                    let face = if outward { [a, b, c] } else { [a, c, b] };
                    sphere = sphere.and(&cut_onto_sphere(face, cuts));
                }
            }
        }
    }
    sphere
}

fn cut_onto_sphere([a, b, c]: [Vec3; 3], cuts: u32) -> Shape {
    let mut face = Shape::default();
    let index = |i: u32, j: u32| i * (2 * cuts + 3 - i) / 2 + j;
    for i in 0..=cuts {
        for j in 0..=cuts - i {
            let (u, v) = (i as f32 / cuts as f32, j as f32 / cuts as f32);
            face.positions
                .push((a * (1.0 - u - v) + b * u + c * v).normalize());
            if i + j < cuts {
                face.triangles
                    .push([index(i, j), index(i + 1, j), index(i, j + 1)]);
            }
            if i + j + 1 < cuts {
                face.triangles
                    .push([index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)]);
            }
        }
    }
    face
}

/// A sphere with bumps.
pub(super) fn bumpy_sphere(center: Vec3, radius: f32, cuts: u32) -> Shape {
    let mut ball = geodesic_sphere(cuts);
    for p in &mut ball.positions {
        let bumps = (p.x * 9.0).sin() * (p.y * 11.0).sin() * (p.z * 8.0).sin();
        *p = center + *p * radius * (1.0 + 0.12 * bumps);
    }
    ball
}

/// A ring around `axis` in `around × across` quads.
pub(super) fn torus(
    center: Vec3,
    axis: Vec3,
    radii: [f32; 2],
    [around, across]: [u32; 2],
) -> Shape {
    let (u, v) = axis.any_orthonormal_pair();
    let mut ring = Shape::default();
    for i in 0..around {
        let (sin, cos) = (i as f32 / around as f32 * std::f32::consts::TAU).sin_cos();
        let out = u * cos + v * sin;
        for j in 0..across {
            let (sin, cos) = (j as f32 / across as f32 * std::f32::consts::TAU).sin_cos();
            let p = center + out * (radii[0] + radii[1] * cos) + axis * (radii[1] * sin);
            ring.positions.push(p);
            let at = |i: u32, j: u32| (i % around) * across + j % across;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            ring.triangles.push([a, b, c]);
            ring.triangles.push([a, c, d]);
        }
    }
    ring
}
