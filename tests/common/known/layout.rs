use std::f32::consts::PI;

use bevy_fresco::radiosity::{DirectLight, Light, LightKind, Material, MaterialId, Object, Scene};
use glam::Vec3;

use super::polygon::Polygon;

/// A flat convex face, its corners anticlockwise seen from the front.
pub(crate) type Corners = [Vec3; 4];

/// Faces that look alike: one object.
#[derive(Clone)]
pub(crate) struct Part {
    pub(crate) name: String,
    pub(crate) reflectance: Vec3,
    pub(crate) emission: Vec3,
    pub(crate) faces: Vec<Corners>,
}

/// A light without a surface.
#[derive(Clone, Copy)]
pub(crate) enum Source {
    /// Parallel light; `light` is irradiance / π of a surface that faces it.
    Sun { direction: Vec3, light: Vec3 },
    /// A point that gives a surface at 1 m that faces it the irradiance / π `light`.
    Bulb { position: Vec3, light: Vec3 },
    /// A rectangle that shines to its front.
    Panel { corners: Corners, radiance: Vec3 },
}

/// A scene told by its faces: bare ones, with no vertices but their corners.
#[derive(Clone, Default)]
pub(crate) struct Layout {
    pub(crate) name: &'static str,
    pub(crate) parts: Vec<Part>,
    pub(crate) sources: Vec<Source>,
    pub(crate) sky: Vec3,
}

impl Layout {
    pub(crate) fn new(name: &'static str) -> Self {
        Self {
            name,
            ..Self::default()
        }
    }

    pub(crate) fn with(mut self, name: &str, reflectance: Vec3, faces: &[Corners]) -> Self {
        self.parts.push(Part {
            name: name.into(),
            reflectance,
            emission: Vec3::ZERO,
            faces: faces.to_vec(),
        });
        self
    }

    pub(crate) fn with_lamp(mut self, face: Corners, reflectance: Vec3, emission: Vec3) -> Self {
        self.parts.push(Part {
            name: "lamp".into(),
            reflectance,
            emission,
            faces: vec![face],
        });
        self
    }

    pub(crate) fn lit_by(mut self, source: Source) -> Self {
        self.sources.push(source);
        self
    }

    /// All parts as one object, which must look alike.
    pub(crate) fn into_one(mut self, name: &'static str) -> Self {
        let rest = self.parts.split_off(1);
        self.parts[0]
            .faces
            .extend(rest.into_iter().flat_map(|p| p.faces));
        Self { name, ..self }
    }

    /// Part and corners of all faces, in the order of all tables by face.
    pub(crate) fn faces(&self) -> impl Iterator<Item = (usize, Corners)> + '_ {
        let parts = self.parts.iter().enumerate();
        parts.flat_map(|(p, part)| part.faces.iter().map(move |&corners| (p, corners)))
    }

    /// The number of a part's first face.
    pub(crate) fn first_face(&self, part: usize) -> usize {
        self.parts[..part].iter().map(|p| p.faces.len()).sum()
    }

    pub(crate) fn polygons(&self) -> Vec<Polygon> {
        let polygon = |(_, c): (usize, Corners)| Polygon::new(c.map(Vec3::as_dvec3).to_vec());
        self.faces().map(polygon).collect()
    }

    /// The largest coordinate.
    pub(crate) fn extent(&self) -> f32 {
        let corners = self.faces().flat_map(|(_, c)| c);
        corners.fold(0.0, |e, c| e.max(c.abs().max_element()))
    }

    /// What is baked: triangles `2 k` and `2 k + 1` of an object are its face `k`.
    pub(crate) fn scene(&self) -> Scene {
        let object = |(p, part): (usize, &Part)| {
            let fan = |k: u32| [[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]];
            Object {
                name: part.name.clone(),
                positions: part.faces.iter().flatten().copied().collect(),
                triangles: (0..part.faces.len() as u32).flat_map(fan).collect(),
                material: MaterialId(p as u32),
                ..Object::default()
            }
        };
        Scene {
            objects: self.parts.iter().enumerate().map(object).collect(),
            materials: self.parts.iter().map(Part::material).collect(),
            lights: self.sources.iter().map(Source::light).collect(),
            sky: self.sky,
            ..Scene::default()
        }
    }
}

impl Part {
    pub(crate) fn material(&self) -> Material {
        Material {
            name: self.name.clone(),
            base_color: self.reflectance.extend(1.0),
            emissive: self.emission,
            ..Material::default()
        }
    }
}

impl Source {
    /// The light in the units of a bake.
    pub(crate) fn light(&self) -> Light {
        let (power, kind) = match *self {
            Self::Sun { direction, light } => (light * PI, LightKind::Directional { direction }),
            Self::Bulb { position, light } => {
                let range = f32::INFINITY;
                (
                    light * (4.0 * PI * PI),
                    LightKind::Point { position, range },
                )
            }
            Self::Panel { corners, radiance } => panel(corners, radiance),
        };
        Light {
            power,
            kind,
            ..Light::default()
        }
    }

    /// The same, its direct light left out of the result.
    pub(crate) fn bounced(&self) -> Light {
        Light {
            direct: DirectLight::Realtime,
            ..self.light()
        }
    }
}

fn panel([a, b, c, d]: Corners, radiance: Vec3) -> (Vec3, LightKind) {
    let (right, up) = (b - a, d - a);
    let kind = LightKind::Rect {
        position: (a + c) * 0.5,
        direction: right.cross(up),
        right,
        width: right.length(),
        height: up.length(),
        range: f32::INFINITY,
    };
    (radiance * (PI * right.length() * up.length()), kind)
}

/// A horizontal rectangle between two corners, seen from above.
pub(crate) fn ground(low: Vec3, high: Vec3) -> Corners {
    let [_, bottom, ..] = inside(low, high);
    bottom
}

/// The faces of a box between two corners, seen from outside: top, bottom, then at low x, high x,
/// low z and high z. Faces share corners to the bit.
pub(crate) fn solid(low: Vec3, high: Vec3) -> [Corners; 6] {
    inside(low, high).map(|[a, b, c, d]| [a, d, c, b])
}

/// The same without its bottom, which lies on the floor.
pub(crate) fn block(low: Vec3, high: Vec3) -> [Corners; 5] {
    let [top, _, rest @ ..] = solid(low, high);
    let [a, b, c, d] = rest;
    [top, a, b, c, d]
}

/// The faces of a box seen from inside: ceiling, floor, then at low x, high x, low z and high z.
pub(crate) fn inside(low: Vec3, high: Vec3) -> [Corners; 6] {
    let at = |x: u8, y: u8, z: u8| {
        let pick = |k: u8, low: f32, high: f32| if k == 0 { low } else { high };
        Vec3::new(
            pick(x, low.x, high.x),
            pick(y, low.y, high.y),
            pick(z, low.z, high.z),
        )
    };
    [
        [at(0, 1, 0), at(1, 1, 0), at(1, 1, 1), at(0, 1, 1)],
        [at(0, 0, 0), at(0, 0, 1), at(1, 0, 1), at(1, 0, 0)],
        [at(0, 0, 0), at(0, 1, 0), at(0, 1, 1), at(0, 0, 1)],
        [at(1, 0, 0), at(1, 0, 1), at(1, 1, 1), at(1, 1, 0)],
        [at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0)],
        [at(0, 0, 1), at(0, 1, 1), at(1, 1, 1), at(1, 0, 1)],
    ]
}
