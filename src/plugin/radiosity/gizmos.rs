use bevy::asset::RenderAssetUsages;
use bevy::mesh::PrimitiveTopology;
use bevy::prelude::*;

use super::drive::Bakery;
use super::status::RadiosityStatus;
use crate::radiosity::{ElementLight, ElementTriangle};

/// Lines that show how light was found, over everything static.
///
/// They are those of the last bake, and follow the next one.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct RadiosityGizmos {
    /// Outlines of the elements that light is solved on, in grey.
    pub elements: bool,
    /// Where faces were cut because others touch or cross them, in blue.
    pub contacts: bool,
    /// Of the element that this ray meets first: lines to all elements that it sees, the brighter the more of its
    /// light they send, and the whole of that.
    pub form_factors: Option<Ray3d>,
    /// Around that element a hemicube, in green.
    pub hemicube: bool,
}

/// On the entities of lines.
#[derive(Component)]
pub(super) struct Line;

/// How far lines are lifted off their surface, beside the size of an element or their own length: lines can have no
/// depth bias.
const LIFT: f32 = 0.02;

/// Draws lines anew when they are asked for or light is another.
pub(super) fn draw(
    mut commands: Commands,
    gizmos: Res<RadiosityGizmos>,
    status: Res<RadiosityStatus>,
    bakery: Res<Bakery>,
    drawn: Query<Entity, With<Line>>,
    assets: (
        Option<ResMut<Assets<Mesh>>>,
        Option<ResMut<Assets<StandardMaterial>>>,
    ),
    mut last: Local<Option<(RadiosityGizmos, u64)>>,
) {
    let wanted = (*gizmos, status.finished);
    // A bake that runs has the elements with it.
    if *last == Some(wanted) || !status.is_up_to_date() {
        return;
    }
    let (Some(mut meshes), Some(mut materials)) = assets else {
        return;
    };
    *last = Some(wanted);
    for entity in &drawn {
        commands.entity(entity).despawn();
    }
    if *gizmos == RadiosityGizmos::default() {
        return;
    }
    let Some(baker) = bakery.baker() else {
        return;
    };
    let mut lines = Lines::default();
    if gizmos.contacts {
        let blue = LinearRgba::rgb(0.05, 0.3, 1.0);
        for line in baker.contacts() {
            let lift = line.normal * (LIFT * line.ends[0].distance(line.ends[1]));
            lines.push(line.ends.map(|end| end + lift), blue);
        }
    }
    if let Some(elements) = baker.elements() {
        if gizmos.elements {
            lines.outline(&elements);
        }
        let met = gizmos
            .form_factors
            .and_then(|ray| first_met(&elements, ray));
        if let Some(element) = met {
            lines.form_factors(&elements, element);
            if gizmos.hemicube {
                lines.hemicube(&elements, element);
            }
        }
    }
    if lines.ends.is_empty() {
        return;
    }
    let material = StandardMaterial {
        unlit: true,
        ..default()
    };
    commands.spawn((
        Line,
        Mesh3d(meshes.add(lines.build())),
        MeshMaterial3d(materials.add(material)),
        bevy::light::NotShadowCaster,
        bevy::light::NotShadowReceiver,
    ));
}

/// Takes lines away with the settings that asked for them.
pub(super) fn clear(mut commands: Commands, drawn: Query<Entity, With<Line>>) {
    for entity in &drawn {
        commands.entity(entity).despawn();
    }
}

#[derive(Default)]
struct Lines {
    ends: Vec<Vec3>,
    colors: Vec<[f32; 4]>,
}

impl Lines {
    fn push(&mut self, ends: [Vec3; 2], color: LinearRgba) {
        self.ends.extend(ends);
        self.colors.extend([color.to_f32_array(); 2]);
    }

    /// Of a triangle.
    fn sides(&mut self, corners: [Vec3; 3], color: LinearRgba) {
        for k in 0..3 {
            self.push([corners[k], corners[(k + 1) % 3]], color);
        }
    }

    fn outline(&mut self, elements: &ElementLight) {
        let grey = LinearRgba::gray(0.35);
        for triangle in elements.triangles().iter().filter(|t| !t.back) {
            let element = &elements.elements[triangle.element as usize];
            let lift = triangle.normal * (LIFT * element.area.sqrt());
            self.sides(triangle.corners.map(|corner| corner + lift), grey);
        }
    }

    /// From the middle of an element to those of others, by their share of its light.
    fn form_factors(&mut self, elements: &ElementLight, element: usize) {
        let row = elements.row(element);
        let level = |e: usize| elements.elements[e].radiosity.element_sum();
        let most = (row.iter().enumerate())
            .map(|(e, factor)| *factor as f32 * level(e))
            .fold(f32::MIN_POSITIVE, f32::max);
        let from = elements.elements[element].center;
        for (e, factor) in row.iter().enumerate().filter(|(_, factor)| **factor > 0.0) {
            // Faint ones are still seen.
            let share = (*factor as f32 * level(e) / most).sqrt().max(0.08);
            let color = LinearRgba::rgb(share, 0.7 * share, 0.1 * share);
            self.push([from, elements.elements[e].center], color);
        }
        for triangle in elements.triangles() {
            if triangle.element as usize == element {
                self.sides(triangle.corners, LinearRgba::rgb(1.0, 0.05, 0.05));
            }
        }
    }

    /// The upper half of a cube around the middle of an element.
    fn hemicube(&mut self, elements: &ElementLight, element: usize) {
        let element = &elements.elements[element];
        let half = 2.0 * element.area.sqrt();
        let (across, along) = element.normal.any_orthonormal_pair();
        let corner = |x: f32, y: f32, z: f32| {
            element.center + half * (across * x + along * y + element.normal * z)
        };
        let green = LinearRgba::rgb(0.1, 0.8, 0.1);
        let around = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        for (i, &(x, y)) in around.iter().enumerate() {
            let (u, v) = around[(i + 1) % 4];
            self.push([corner(x, y, 0.0), corner(u, v, 0.0)], green);
            self.push([corner(x, y, 1.0), corner(u, v, 1.0)], green);
            self.push([corner(x, y, 0.0), corner(x, y, 1.0)], green);
        }
    }

    fn build(self) -> Mesh {
        Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, self.ends)
            .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, self.colors)
    }
}

/// The element that a ray meets first, on the side it comes from.
fn first_met(elements: &ElementLight, ray: Ray3d) -> Option<usize> {
    let met = |t: &ElementTriangle| Some((distance(t, ray)?, t.element as usize));
    let facing = (elements.triangles().iter()).filter(|t| t.normal.dot(*ray.direction) < 0.0);
    let first = facing.filter_map(met).min_by(|a, b| a.0.total_cmp(&b.0));
    first.map(|(_, element)| element)
}

/// How far a ray goes to a triangle (Möller and Trumbore 1997).
fn distance(triangle: &ElementTriangle, ray: Ray3d) -> Option<f32> {
    let [a, b, c] = triangle.corners;
    let (u, v, from) = (b - a, c - a, ray.origin - a);
    let across = ray.direction.cross(v);
    let determinant = u.dot(across);
    if determinant == 0.0 {
        return None;
    }
    let x = from.dot(across) / determinant;
    let along = from.cross(u);
    let y = ray.direction.dot(along) / determinant;
    let t = v.dot(along) / determinant;
    (x >= 0.0 && y >= 0.0 && x + y <= 1.0 && t > 0.0).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_meet_what_is_in_their_way() {
        let triangle = ElementTriangle {
            element: 0,
            corners: [Vec3::ZERO, Vec3::X, Vec3::Y],
            normal: Vec3::Z,
            back: false,
        };
        let ray = |x: f32, y: f32, down: f32| Ray3d {
            origin: Vec3::new(x, y, 2.0),
            direction: Dir3::new(Vec3::new(0.0, 0.0, -down)).unwrap(),
        };
        assert_eq!(distance(&triangle, ray(0.2, 0.3, 1.0)), Some(2.0));
        assert_eq!(distance(&triangle, ray(0.7, 0.7, 1.0)), None);
        assert_eq!(distance(&triangle, ray(-0.1, 0.3, 1.0)), None);
        assert_eq!(distance(&triangle, ray(0.2, 0.3, -1.0)), None);
        let beside = Ray3d {
            origin: Vec3::new(0.2, 0.3, 2.0),
            direction: Dir3::X,
        };
        assert_eq!(distance(&triangle, beside), None);
    }
}
