//! Refined meshes are the surfaces they refine: nothing torn, nothing moved.

use std::collections::HashMap;

use bevy_fresco::mesh::{RefinedMesh, SurfacePoint};
use bevy_fresco::radiosity::{
    Bake, BakeSettings, Light, LightKind, Object, ObjectLight, Scene, bake,
};
use glam::{DVec3, Vec2, Vec3, vec3};

use crate::common::{grey, quad, scene};
use crate::known::layout::Layout;
use crate::known::polygon::Polygon;
use crate::known::scenes::{court, lit_scenes, two_rooms};

/// Spacings of `f32` at the extent of a scene that a vertex may be off.
const ULPS: f32 = 4.0;

/// Light of one place is one light within this share of the brightest.
const SAME_LIGHT: f32 = 1e-6;

/// Normals that agree, by their cosine: a degree.
const SAME_NORMAL: f32 = 0.999_85;

/// A line along which faces touch: light may differ on its two sides.
type Contact = [Vec3; 2];

/// A place to the bit, whatever the sign of zero.
type Place = [u32; 3];

fn place(p: Vec3) -> Place {
    (p + Vec3::ZERO).to_array().map(f32::to_bits)
}

fn edge(a: Vec3, b: Vec3) -> [Place; 2] {
    let mut ends = [place(a), place(b)];
    ends.sort_unstable();
    ends
}

/// An object and the mesh its light is shown on.
struct Shown<'a> {
    object: &'a Object,
    positions: Vec<Vec3>,
    /// Corners, source triangle, and weights of each corner on it.
    faces: Vec<([u32; 3], usize, [Vec3; 3])>,
    light: &'a [Vec3],
}

impl<'a> Shown<'a> {
    fn new(object: &'a Object, light: &'a ObjectLight) -> Self {
        let given = &object.triangles;
        let (positions, faces) = match &light.mesh {
            None => {
                let face = |(t, &c): (usize, &[u32; 3])| (c, t, Vec3::AXES);
                (
                    object.positions.clone(),
                    given.iter().enumerate().map(face).collect(),
                )
            }
            Some(mesh) => {
                let face = |(&corners, &source): (&[u32; 3], &u32)| {
                    let weights = corners.map(|v| {
                        let on = mesh.vertices[v as usize].barycentrics_on(source, given);
                        on.expect("corners lie on the source of their face")
                    });
                    (corners, source as usize, weights)
                };
                let faces = mesh.triangles.iter().zip(&mesh.sources).map(face);
                (mesh.positions(&object.positions, given), faces.collect())
            }
        };
        assert_eq!(positions.len(), light.light.len());
        Self {
            object,
            positions,
            faces,
            light: &light.light,
        }
    }

    fn corners(&self, source: usize) -> [Vec3; 3] {
        self.object.triangles[source].map(|v| self.object.positions[v as usize])
    }

    /// Twice the area vector, as good as `f64` has it.
    fn across(&self, source: usize) -> DVec3 {
        let [a, b, c] = self.corners(source).map(Vec3::as_dvec3);
        (b - a).cross(c - a)
    }

    fn at(&self, vertex: u32) -> Vec3 {
        self.positions[vertex as usize]
    }
}

/// Which edge of the source an edge between two of its points lies on: by the corner that both have
/// weight 0 of.
fn along(weights: &[Vec3; 3], i: usize, source: [Vec3; 3]) -> Option<[Place; 2]> {
    let (a, b) = (weights[i], weights[(i + 1) % 3]);
    let opposite = (0..3).find(|&k| a[k] == 0.0 && b[k] == 0.0)?;
    Some(edge(source[(opposite + 1) % 3], source[(opposite + 2) % 3]))
}

/// Every edge inside a source triangle has two faces of it, and every edge on a source edge as many
/// as there are source triangles there.
fn nothing_is_torn(shown: &Shown) {
    let proper = |t: usize| shown.across(t).length_squared() > 0.0;
    let mut given: HashMap<[Place; 2], u32> = HashMap::new();
    for t in (0..shown.object.triangles.len()).filter(|&t| proper(t)) {
        let corners = shown.corners(t);
        for k in 0..3 {
            *given
                .entry(edge(corners[k], corners[(k + 1) % 3]))
                .or_default() += 1;
        }
    }
    let mut inside: HashMap<(usize, [Place; 2]), u32> = HashMap::new();
    let mut rim: HashMap<([Place; 2], [Place; 2]), u32> = HashMap::new();
    for (corners, source, weights) in shown.faces.iter().filter(|f| proper(f.1)) {
        for k in 0..3 {
            let own = edge(shown.at(corners[k]), shown.at(corners[(k + 1) % 3]));
            match along(weights, k, shown.corners(*source)) {
                Some(on) => *rim.entry((on, own)).or_default() += 1,
                None => *inside.entry((*source, own)).or_default() += 1,
            }
        }
    }
    let name = &shown.object.name;
    for ((source, own), faces) in inside {
        assert_eq!(faces, 2, "{name}: an edge inside {source}: {own:?}");
    }
    for ((on, own), faces) in rim {
        assert_eq!(faces, given[&on], "{name}: an edge {own:?} on {on:?}");
    }
}

/// Weights are weights, vertices lie on their triangles, faces turn their way and fill them.
fn nothing_has_moved(shown: &Shown, tolerance: f32) {
    let name = &shown.object.name;
    let mut filled = vec![DVec3::ZERO; shown.object.triangles.len()];
    for (corners, source, weights) in &shown.faces {
        for (&vertex, w) in corners.iter().zip(weights) {
            assert!(
                w.cmpge(Vec3::ZERO).all() && w.cmple(Vec3::ONE).all(),
                "{name}: {w}"
            );
            assert!((w.element_sum() - 1.0).abs() < 1e-6, "{name}: {w}");
            let [a, b, c] = shown.corners(*source).map(Vec3::as_dvec3);
            let w = w.as_dvec3();
            let on = a * w.x + b * w.y + c * w.z;
            let off = shown.at(vertex).as_dvec3().distance(on);
            assert!(off <= f64::from(tolerance), "{name}: {off} off its source");
        }
        let [a, b, c] = corners.map(|v| shown.at(v).as_dvec3());
        filled[*source] += (b - a).cross(c - a);
    }
    for (source, filled) in filled.into_iter().enumerate() {
        let whole = shown.across(source);
        // Each edge is as far off as its ends are.
        let size = shown.corners(source).map(|c| c.abs().max_element());
        let slack = f64::from(tolerance * size.into_iter().fold(1.0, f32::max)) * 10.0;
        assert!(
            (filled - whole).length() <= slack + 1e-5 * whole.length(),
            "{name}: {filled} of {whole}"
        );
    }
}

/// The vertices of an object along each of its source edges.
fn rims(shown: &Shown) -> HashMap<[Place; 2], Vec<Vec3>> {
    let mut rims: HashMap<[Place; 2], Vec<Vec3>> = HashMap::new();
    for (corners, source, weights) in &shown.faces {
        for k in 0..3 {
            if let Some(on) = along(weights, k, shown.corners(*source)) {
                let ends = [corners[k], corners[(k + 1) % 3]].map(|v| shown.at(v));
                rims.entry(on).or_default().extend(ends);
            }
        }
    }
    for (on, points) in &mut rims {
        let start = Vec3::from_array(on[0].map(f32::from_bits));
        points.sort_by(|a, b| a.distance(start).total_cmp(&b.distance(start)));
        points.dedup_by_key(|p| place(*p));
    }
    rims
}

/// Objects that share an edge have the same vertices on it.
fn objects_hold_together(all: &[Shown], tolerance: f32) -> usize {
    let mut first: HashMap<[Place; 2], Vec<Vec3>> = HashMap::new();
    let mut shared = 0;
    for shown in all {
        for (on, points) in rims(shown) {
            let Some(known) = first.get(&on) else {
                first.insert(on, points);
                continue;
            };
            let name = &shown.object.name;
            assert_eq!(known.len(), points.len(), "{name}: vertices on {on:?}");
            for (a, b) in known.iter().zip(&points) {
                assert!(a.distance(*b) <= tolerance, "{name}: {a} and {b}");
            }
            shared += 1;
        }
    }
    shared
}

/// On an edge of two faces whose normals agree there is one light, but for edges at which something
/// stands. Faces of two objects are asked as well if all objects come together.
fn light_is_one(all: &[Shown], contacts: &[Contact]) {
    let brightest = all.iter().flat_map(|s| s.light).map(|l| l.max_element());
    let limit = SAME_LIGHT * brightest.fold(0.0, f32::max);
    let mut known: HashMap<[Place; 2], Vec<(Vec3, [Vec3; 2])>> = HashMap::new();
    for shown in all {
        for (corners, source, _) in &shown.faces {
            let normal = shown.across(*source).normalize_or_zero().as_vec3();
            for k in 0..3 {
                let mut ends = [corners[k], corners[(k + 1) % 3]];
                ends.sort_by_key(|&v| place(shown.at(v)));
                let [a, b] = ends.map(|v| shown.at(v));
                let light = ends.map(|v| shown.light[v as usize]);
                if contacts.iter().any(|c| touches(*c, a, b, TOUCHING as f32)) {
                    continue;
                }
                let sides = known.entry(edge(a, b)).or_default();
                for (_, other) in sides.iter().filter(|s| s.0.dot(normal) > SAME_NORMAL) {
                    for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
                        let [x, y] = [other, &light].map(|l| l[0].lerp(l[1], share));
                        let name = &shown.object.name;
                        assert!(x.abs_diff_eq(y, limit), "{name}, {a} to {b}: {x} and {y}");
                    }
                }
                sides.push((normal, light));
            }
        }
    }
}

/// Whether both or either end of an edge lies on a contact: a vertex on one may have the light of
/// its own side.
fn touches([from, to]: Contact, a: Vec3, b: Vec3, tolerance: f32) -> bool {
    let way = to - from;
    let on = |p: Vec3| {
        let t = ((p - from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
        p.distance(from + way * t) <= tolerance
    };
    on(a) || on(b)
}

/// Surfaces this near touch: a block that hovers 1 mm over the floor does.
const TOUCHING: f64 = 2e-3;

/// The lines along which faces of a layout meet others that do not continue them.
fn contacts(layout: &Layout) -> Vec<Contact> {
    let polygons = layout.polygons();
    let mut found = Vec::new();
    for (i, a) in polygons.iter().enumerate() {
        for b in &polygons[i + 1..] {
            if a.near(b, TOUCHING) && a.normal.dot(b.normal).abs() < f64::from(SAME_NORMAL) {
                found.extend(meeting(a, b));
            } else if a.near(b, TOUCHING) && a.normal.dot(b.normal) < 0.0 {
                // Back to back: all around both.
                for p in [a, b] {
                    let ends = p.corners.iter().zip(p.corners.iter().cycle().skip(1));
                    found.extend(ends.map(|(a, b)| [a.as_vec3(), b.as_vec3()]));
                }
            }
        }
    }
    found
}

/// The line that two polygons of different planes have in common.
fn meeting(a: &Polygon, b: &Polygon) -> Option<Contact> {
    let ends = |of: &Polygon, plane: &Polygon| -> Vec<DVec3> {
        let next = of.corners.iter().cycle().skip(1);
        let crossed = of.corners.iter().zip(next).filter_map(|(&p, &q)| {
            let (h, g) = (plane.height(p), plane.height(q));
            if h.abs() < TOUCHING {
                return Some(p);
            }
            (g.abs() > TOUCHING && h * g < 0.0).then(|| p.lerp(q, h / (h - g)))
        });
        crossed.collect()
    };
    let mut points: Vec<DVec3> = ends(a, b)
        .into_iter()
        .filter(|&p| b.depth(p) > -TOUCHING)
        .collect();
    points.extend(ends(b, a).into_iter().filter(|&p| a.depth(p) > -TOUCHING));
    let way = a.normal.cross(b.normal);
    points.sort_by(|p, q| way.dot(*p).total_cmp(&way.dot(*q)));
    let (first, last) = (*points.first()?, *points.last()?);
    (first.distance(last) > 1e-6).then(|| [first.as_vec3(), last.as_vec3()])
}

/// How far a vertex may be off.
fn tolerance(scene: &Scene) -> f32 {
    let positions = scene.objects.iter().flat_map(|o| &o.positions);
    let extent = positions.fold(0.0_f32, |e, p| e.max(p.abs().max_element()));
    ULPS * extent * f32::EPSILON
}

fn shown<'a>(scene: &'a Scene, baked: &'a Bake) -> Vec<Shown<'a>> {
    let objects = scene.objects.iter().zip(&baked.objects);
    objects.map(|(o, l)| Shown::new(o, l)).collect()
}

/// All checks but that of light across objects; the number of edges that objects share.
fn check(scene: &Scene, baked: &Bake, contacts: &[Contact]) -> usize {
    let (all, tolerance) = (shown(scene, baked), tolerance(scene));
    for one in &all {
        nothing_is_torn(one);
        nothing_has_moved(one, tolerance);
        light_is_one(std::slice::from_ref(one), contacts);
    }
    objects_hold_together(&all, tolerance)
}

fn run(scene: &Scene, settings: &BakeSettings) -> Bake {
    bake(&scene.clone().validate().unwrap(), settings, &()).unwrap()
}

/// Edges split evenly, and by the light.
fn ways() -> [BakeSettings; 2] {
    [
        BakeSettings {
            max_edge: Some(0.5),
            ..BakeSettings::DRAFT
        },
        BakeSettings {
            refine: true,
            max_vertices: 10_000,
            ..BakeSettings::DRAFT
        },
    ]
}

#[test]
fn all_scenes_stay_whole() {
    let mut layouts = lit_scenes().to_vec();
    for thickness in [0.0, 0.01, 0.1] {
        layouts.push(two_rooms(thickness));
        layouts.push(two_rooms(thickness).into_one("two rooms, one object"));
    }
    for layout in layouts {
        let (scene, contacts) = (layout.scene(), contacts(&layout));
        for settings in ways() {
            check(&scene, &run(&scene, &settings), &contacts);
        }
    }
}

/// The lit floor of other tests, under a sun, with a board over it that makes an edge of light.
fn under_a_board(objects: Vec<Object>) -> Scene {
    let mut s = scene(objects, vec![grey(0.5, 0.0)]);
    let board = quad(
        "board",
        vec3(0.3, 1.0, 0.2),
        Vec3::Z * 0.9,
        Vec3::X * 0.8,
        1,
        0,
    );
    s.objects.push(board);
    s.lights.push(Light {
        power: Vec3::splat(10.0),
        kind: LightKind::Directional {
            direction: vec3(0.3, -1.0, 0.2),
        },
        ..Light::default()
    });
    s
}

fn floor(n: u32) -> Object {
    quad("floor", Vec3::ZERO, Vec3::Z * 2.0, Vec3::X * 2.0, n, 0)
}

/// No vertex shared: every corner has its own normal and texture coordinates.
fn unshared(mut object: Object) -> Object {
    let corners = object.triangles.as_flattened().to_vec();
    object.positions = corners
        .iter()
        .map(|&v| object.positions[v as usize])
        .collect();
    object.normals = corners
        .iter()
        .map(|&v| object.normals[v as usize])
        .collect();
    object.uvs = vec![(0..corners.len()).map(|i| Vec2::splat(i as f32)).collect()];
    object.triangles = (0..corners.len() as u32 / 3)
        .map(|t| [0, 1, 2].map(|k| 3 * t + k))
        .collect();
    object
}

/// A floor of two objects that share an edge of two pieces.
fn two_halves() -> Vec<Object> {
    let (mut left, mut right) = (floor(2), floor(2));
    for (p, q) in left.positions.iter_mut().zip(&mut right.positions) {
        p.x *= 0.5;
        q.x = 1.0 + 0.5 * q.x;
    }
    vec![left, unshared(right)]
}

#[test]
fn seams_stay_closed() {
    for (objects, shared) in [(vec![unshared(floor(3))], 0), (two_halves(), 2)] {
        let s = under_a_board(objects);
        for settings in ways() {
            assert_eq!(check(&s, &run(&s, &settings), &[]), shared);
        }
    }
}

/// A hinge: three sheets on one edge, and a roof ridge with a hard edge.
#[test]
fn non_manifold_edges_keep_their_faces() {
    let mut hinge = quad("hinge", Vec3::ZERO, Vec3::Z * 2.0, Vec3::X, 1, 0);
    for (u, v) in [
        (Vec3::Z * 2.0, vec3(-1.0, 0.4, 0.0)),
        (vec3(0.1, 0.8, 0.0), Vec3::Z * 2.0),
    ] {
        let sheet = quad("sheet", Vec3::ZERO, u, v, 1, 0);
        let first = hinge.positions.len() as u32;
        hinge.positions.extend(sheet.positions);
        hinge.normals.extend(sheet.normals);
        let moved = sheet.triangles.iter().map(|t| t.map(|v| v + first));
        hinge.triangles.extend(moved);
    }
    let along = [[Vec3::ZERO, Vec3::Z * 2.0]];
    let s = under_a_board(vec![hinge]);
    for settings in ways() {
        check(&s, &run(&s, &settings), &along);
    }
}

/// Triangles without area among the others, and slivers of 1 : 1000.
#[test]
fn degenerate_triangles_tear_nothing() {
    let mut object = floor(4);
    for p in object.positions.iter_mut().filter(|p| p.x == 0.5) {
        p.x = 1e-3;
    }
    // 0, 1 and 2 lie on a line, and so do 0, 6 and 12 but for the strip.
    object.triangles.extend([[3, 3, 8], [0, 1, 2], [7, 7, 7]]);
    let s = under_a_board(vec![object]);
    for settings in ways() {
        check(&s, &run(&s, &settings), &[]);
    }
}

/// Light across the edge of two objects of one floor, where a shadow crosses it.
#[test]
fn light_goes_on_in_the_next_object() {
    let court = court();
    let s = court.scene();
    let baked = run(&s, &ways()[1]);
    light_is_one(&shown(&s, &baked), &contacts(&court));

    let s = under_a_board(two_halves());
    let baked = run(&s, &ways()[1]);
    light_is_one(&shown(&s, &baked), &[]);
}

/// The checks see what they are there for: a vertex that moved, a face that is missing, a vertex
/// on an edge that the neighbour has none on, light that differs.
#[test]
fn checks_can_fail() {
    type Spoil = fn(&mut RefinedMesh, &mut Vec<Vec3>);
    let s = court().scene();
    let whole = run(&s, &ways()[0]);
    check(&s, &whole, &contacts(&court()));
    let fails = |with: &str, spoil: Spoil| {
        let mut spoiled = whole.clone();
        let ground = &mut spoiled.objects[0];
        let mut mesh = ground.mesh.as_deref().unwrap().clone();
        spoil(&mut mesh, &mut ground.light);
        ground.mesh = Some(mesh.into());
        let found = std::panic::catch_unwind(|| check(&s, &spoiled, &contacts(&court())));
        let message = *found.unwrap_err().downcast::<String>().unwrap();
        assert!(message.contains(with), "{message}");
    };
    fails("west: [", |mesh, _| {
        let moved = mesh.triangles[20][0] as usize;
        mesh.vertices[moved].barycentrics = vec3(1.5, -0.5, 0.0);
    });
    fails("an edge", |mesh, _| {
        mesh.triangles.pop();
        mesh.sources.pop();
    });
    fails("an edge", |mesh, light| {
        // A face in two, its neighbours whole.
        let ([a, b, c], source) = (mesh.triangles[20], mesh.sources[20]);
        let corner =
            |v: u32| mesh.vertices[v as usize].barycentrics_on(source, &[[0, 1, 2], [0, 2, 3]]);
        let middle = mesh.vertices.len() as u32;
        let barycentrics = (corner(a).unwrap() + corner(b).unwrap()) * 0.5;
        mesh.vertices.push(SurfacePoint {
            triangle: source,
            barycentrics,
        });
        light.push(light[a as usize].lerp(light[b as usize], 0.5));
        mesh.triangles[20] = [a, middle, c];
        mesh.triangles.push([middle, b, c]);
        mesh.sources.push(source);
    });
    fails(" and [", |mesh, light| {
        // A face has its own copy of a vertex, with other light.
        let own = mesh.vertices.len() as u32;
        let vertex = mesh.triangles[20][0];
        mesh.vertices.push(mesh.vertices[vertex as usize]);
        light.push(light[vertex as usize] * 1.5 + 1.0);
        mesh.triangles[20][0] = own;
    });
}
