use glam::{DVec3, Vec3};

use super::camera::{Camera, Lens};
use super::tone::brightness;
use super::{Seen, View};
use crate::radiosity::color::luminance;
use crate::radiosity::sampling::{hash, sobol, triangle as triangle_point, unit_float};
use crate::radiosity::triangle::area;

/// Points of the scene's surfaces that a view is judged by, half of them spread by area and half
/// by triangle: a vase has few square metres, and is what people look at.
const POINTS: u32 = 768;

/// Vertical angle of view outside and inside, in radians.
const OUTSIDE_ANGLE: f32 = 0.70;
const INSIDE_ANGLE: f32 = 1.10;

/// Shorter than this share of the distance to the middle, a free line of sight is called blocked.
const CLOSE: f32 = 0.3;

/// What the back of a double-sided surface is worth: it shows the light of its front, so the
/// outside of a room of such walls looks lit and is not.
const BEHIND: f32 = 0.3;

/// What a view from inside is worth beside one from outside, which shows how things hang together.
const INSIDE: f32 = 0.8;

/// A point that is worth seeing.
struct Sight {
    position: Vec3,
    /// Unit, of its front.
    normal: Vec3,
    two_sided: bool,
    triangle: u32,
    /// How much it is worth: lit surfaces more than dark ones.
    weight: f32,
}

/// The camera among many that shows most of what is lit.
///
/// Candidates stand around the scene, and inside it for rooms that are closed. Ties go to the first:
/// the front, seen from +Z.
pub(super) fn find(view: &View, aspect: f32) -> Camera {
    let sights = sights(view);
    let (middle, radius) = extent(&sights);
    let mut best = (0.0, None);
    for candidate in candidates(&sights, middle, radius, aspect) {
        let score = candidate.weight * score(view, &candidate, &sights, middle, aspect);
        // A little better is not worth leaving the front for.
        if score > 1.02 * best.0 {
            best = (score, Some(candidate));
        }
    }
    let candidate = best.1.unwrap_or(Candidate {
        position: middle + Vec3::Z * (3.0 * radius),
        target: middle,
        angle: OUTSIDE_ANGLE,
        weight: 1.0,
    });
    candidate.camera(view)
}

/// A place to look from, in internal units.
#[derive(Clone)]
struct Candidate {
    position: Vec3,
    target: Vec3,
    angle: f32,
    /// How such views are liked.
    weight: f32,
}

impl Candidate {
    fn camera(&self, view: &View) -> Camera {
        let scale = f64::from(view.scene.scale);
        let world = |p: Vec3| -> DVec3 { view.scene.center + p.as_dvec3() * scale };
        Camera::looking_at(world(self.position), world(self.target), self.angle)
    }
}

fn sights(view: &View) -> Vec<Sight> {
    let scene = view.scene;
    let mut sum = 0.0;
    let by_area: Vec<f64> = (scene.triangles.iter())
        .map(|&t| {
            sum += f64::from(area(scene.corners(t)));
            sum
        })
        .collect();
    let count = scene.triangles.len();
    let mut points: Vec<(u32, Vec3)> = Vec::new();
    for i in 0..POINTS {
        let [u, v, w, _] = sobol(i, 0, 0xF4A3);
        let triangle = if i % 2 == 0 {
            by_area.partition_point(|&a| a <= f64::from(w) * sum)
        } else {
            (unit_float(hash(i, 0xF4A4)) * count as f32) as usize
        };
        points.push((triangle.min(count - 1) as u32, triangle_point(u, v)));
    }
    let light = |&(t, b): &(u32, Vec3)| view.light.at(scene.triangles[t as usize], [b.y, b.z]);
    let mean = points
        .iter()
        .map(|p| f64::from(luminance(light(p))))
        .sum::<f64>()
        / f64::from(POINTS);
    points
        .iter()
        .map(|point| {
            let &(triangle, barycentrics) = point;
            let [a, b, c] = scene.corners(scene.triangles[triangle as usize]);
            Sight {
                position: a * barycentrics.x + b * barycentrics.y + c * barycentrics.z,
                normal: (b - a).cross(c - a).normalize_or_zero(),
                two_sided: !view.culled[triangle as usize],
                triangle,
                weight: 0.1 + brightness(light(point), mean) as f32,
            }
        })
        .collect()
}

/// Middle of the sights, and the distance from it within which nine of ten lie.
fn extent(sights: &[Sight]) -> (Vec3, f32) {
    let (low, high) = bounds(sights, 0.05);
    let middle = 0.5 * (low + high);
    let mut distances: Vec<f32> = (sights.iter())
        .map(|s| s.position.distance(middle))
        .collect();
    distances.sort_by(f32::total_cmp);
    (middle, distances[distances.len() * 9 / 10])
}

/// Bounds of the sights, leaving out a share of them at each end of each axis.
fn bounds(sights: &[Sight], left_out: f32) -> (Vec3, Vec3) {
    let skip = (sights.len() as f32 * left_out) as usize;
    let ends: [[f32; 2]; 3] = std::array::from_fn(|axis| {
        let mut values: Vec<f32> = sights.iter().map(|s| s.position[axis]).collect();
        values.sort_by(f32::total_cmp);
        [values[skip], values[values.len() - 1 - skip]]
    });
    (
        Vec3::from_array(ends.map(|e| e[0])),
        Vec3::from_array(ends.map(|e| e[1])),
    )
}

fn candidates(sights: &[Sight], middle: Vec3, radius: f32, aspect: f32) -> Vec<Candidate> {
    let mut found = Vec::new();
    // Far enough for the scene to fit the shorter side of the picture.
    let half = (0.5 * OUTSIDE_ANGLE).tan() * aspect.min(1.0);
    let distance = 1.05 * radius / half.atan().sin();
    for tilt in [0.06_f32, 0.3, 0.6] {
        for turn in 0..16_u8 {
            let turn = f32::from(turn) * std::f32::consts::TAU / 16.0;
            let direction = Vec3::new(turn.sin() * tilt.cos(), tilt.sin(), turn.cos() * tilt.cos());
            found.push(Candidate {
                position: middle + direction * distance,
                target: middle,
                angle: OUTSIDE_ANGLE,
                weight: 1.0,
            });
        }
    }
    let (low, high) = bounds(sights, 0.0);
    let size = high - low;
    for y in [0.4, 0.6, 0.8] {
        for z in [0.92, 0.75, 0.25, 0.08] {
            for x in [0.08, 0.25, 0.5, 0.75, 0.92] {
                let position = low + size * Vec3::new(x, y, z);
                // Across the middle, a little down: people look at floors more than at ceilings.
                found.push(Candidate {
                    position,
                    target: middle - Vec3::Y * (0.1 * size.y),
                    angle: INSIDE_ANGLE,
                    weight: INSIDE,
                });
            }
        }
    }
    found
}

/// How much of the sights a camera shows, how well, and how much of its picture they fill.
fn score(view: &View, candidate: &Candidate, sights: &[Sight], middle: Vec3, aspect: f32) -> f32 {
    let height = 512.0;
    let lens = Lens::new(
        view.scene,
        &candidate.camera(view),
        (height * aspect) as u32,
        height as u32,
    );
    let total: f32 = sights.iter().map(|s| s.weight).sum();
    let seen: f32 = sights.iter().map(|s| worth(view, &lens, s)).sum();
    if seen < 0.1 * total {
        // Not worth the rays of a closer look.
        return 0.1 * seen / total;
    }
    let free = CLOSE * candidate.position.distance(middle);
    let (filled, blocked) = coverage(view, &lens, free);
    seen / total * (0.4 + 0.6 * filled) * (1.0 - blocked).powi(2)
}

fn worth(view: &View, lens: &Lens, sight: &Sight) -> f32 {
    let inside = |p: [f32; 2]| p[0].abs() < 0.98 && p[1].abs() < 0.98;
    if !lens.project(sight.position).is_some_and(inside) {
        return 0.0;
    }
    let to = sight.position - lens.origin();
    let distance = to.length();
    let direction = to / distance;
    let cosine = -direction.dot(sight.normal);
    if cosine <= 0.0 && !sight.two_sided {
        return 0.0;
    }
    let hit = view
        .occluders
        .shown(lens.origin(), direction, &view.culled, 0.5);
    let visible = hit.is_some_and(|h| {
        h.triangle == sight.triangle || (h.distance - distance).abs() < 1e-3 * distance
    });
    if visible {
        let side = if cosine > 0.0 { 1.0 } else { BEHIND };
        sight.weight * side * cosine.abs().sqrt()
    } else {
        0.0
    }
}

/// The share of the picture that shows lit surfaces, and the share that something close covers.
fn coverage(view: &View, lens: &Lens, free: f32) -> (f32, f32) {
    const GRID: u32 = 12;
    let (mut filled, mut blocked) = (0, 0);
    for i in 0..GRID * GRID {
        let at = |cell: u32, size: f32| (cell as f32 + 0.5) * size / GRID as f32;
        let (x, y) = (at(i % GRID, lens.width), at(i / GRID, lens.height));
        if let Seen::Surface { .. } = view.look(lens, x, y, 0.5) {
            filled += 1;
        }
        let (origin, direction) = lens.ray(x, y);
        let hit = view.occluders.shown(origin, direction, &view.culled, 0.5);
        blocked += u32::from(hit.is_some_and(|h| h.distance < free));
    }
    let all = (GRID * GRID) as f32;
    (filled as f32 / all, blocked as f32 / all)
}

#[cfg(test)]
mod tests {
    use super::super::{PreviewSettings, preview};
    use crate::radiosity::{BakeSettings, Material, MaterialId, Object, Scene, bake};
    use glam::Vec3;

    /// A closed box of inward walls, half a metre to each side of (5, 0, 0), all emitting.
    fn room(double_sided: bool) -> Scene {
        let corner = |i: u32| {
            let bit = |k: u32| if i >> k & 1 == 1 { 0.5 } else { -0.5 };
            Vec3::new(5.0 + bit(0), bit(1), bit(2))
        };
        let quads = [
            [0, 1, 3, 2],
            [4, 6, 7, 5],
            [0, 4, 5, 1],
            [2, 3, 7, 6],
            [0, 2, 6, 4],
            [1, 5, 7, 3],
        ];
        Scene {
            objects: vec![Object {
                positions: (0..8).map(corner).collect(),
                triangles: (quads.iter())
                    .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
                    .collect(),
                material: MaterialId(0),
                ..Object::default()
            }],
            materials: vec![Material {
                emissive: Vec3::ONE,
                double_sided,
                base_color: glam::Vec4::new(0.5, 0.5, 0.5, 1.0),
                ..Material::default()
            }],
            ..Scene::default()
        }
    }

    #[test]
    fn closed_rooms_are_seen_from_within_or_through_their_walls() {
        for double_sided in [false, true] {
            let scene = room(double_sided).validate().unwrap();
            let bake = bake(
                &scene,
                &BakeSettings {
                    refine: false,
                    ..BakeSettings::DRAFT
                },
                &(),
            )
            .unwrap();
            let settings = PreviewSettings {
                width: 40,
                height: 30,
                ..PreviewSettings::default()
            };
            let picture = preview(&scene, &bake, &settings, &()).unwrap();
            let lit = picture.pixels.iter().filter(|p| p[0] > 100).count();
            assert!(lit > 500, "{lit} of 1200 pixels are lit");
        }
    }

    #[test]
    fn closed_rooms_of_double_sided_walls_are_seen_from_within() {
        let scene = room(true).validate().unwrap();
        let bake = bake(
            &scene,
            &BakeSettings {
                refine: false,
                ..BakeSettings::DRAFT
            },
            &(),
        )
        .unwrap();
        let pyramids = super::super::Pyramids::new(&scene, None);
        let surfaces = super::super::Surfaces::new(&scene, &pyramids);
        let hierarchy = super::super::Hierarchy::new(
            &scene,
            &surfaces,
            super::super::Holds::All,
            super::super::BvhQuality::Best,
        );
        let view = super::View {
            scene: &scene,
            occluders: super::super::Occluders::new(&hierarchy, &surfaces),
            surfaces: &surfaces,
            light: super::super::LightLookup::new(&scene, &bake),
            culled: vec![false; scene.triangles.len()],
        };
        let camera = super::find(&view, 4.0 / 3.0);
        let inside = (camera.position - glam::DVec3::X * 5.0).abs().max_element() < 0.5;
        assert!(inside, "{camera:?}");
    }
}
