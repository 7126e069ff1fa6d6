use glam::{DVec3, Vec3};

use crate::radiosity::validate::ValidScene;

/// Where a picture is taken from.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// World position in metres.
    pub position: DVec3,
    /// Where it looks; any length but 0.
    pub forward: Vec3,
    /// What is up in the picture, roughly; not along `forward`.
    pub up: Vec3,
    /// How it maps the scene to the picture.
    pub projection: Projection,
}

/// How a [`Camera`] maps the scene to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Far things are small. The vertical angle of view, in radians.
    Perspective {
        /// Above 0 and below π.
        vertical_angle: f32,
    },
    /// All things keep their size. The height shown, in metres.
    Orthographic {
        /// Above 0.
        height: f32,
    },
}

impl Camera {
    /// A camera with a perspective view towards a point.
    pub fn looking_at(position: DVec3, target: DVec3, vertical_angle: f32) -> Self {
        let forward = (target - position).normalize_or(DVec3::NEG_Z).as_vec3();
        let up = if forward.y.abs() > 0.999 {
            Vec3::NEG_Z
        } else {
            Vec3::Y
        };
        Self {
            position,
            forward,
            up,
            projection: Projection::Perspective { vertical_angle },
        }
    }
}

/// A camera in internal units, with the picture's size.
pub(super) struct Lens {
    pub(super) width: f32,
    pub(super) height: f32,
    origin: Vec3,
    forward: Vec3,
    /// From the middle of the picture to its right and upper edges; of a perspective at distance 1.
    right: Vec3,
    up: Vec3,
    perspective: bool,
}

impl Lens {
    pub(super) fn new(scene: &ValidScene, camera: &Camera, width: u32, height: u32) -> Self {
        let forward = camera.forward.normalize_or(Vec3::NEG_Z);
        let right = forward
            .cross(camera.up)
            .try_normalize()
            .unwrap_or_else(|| forward.any_orthonormal_vector());
        let up = right.cross(forward);
        let (half, perspective) = match camera.projection {
            Projection::Perspective { vertical_angle } => ((0.5 * vertical_angle).tan(), true),
            Projection::Orthographic { height } => (0.5 * height / scene.scale, false),
        };
        let (width, height) = (width as f32, height as f32);
        Self {
            width,
            height,
            origin: ((camera.position - scene.center) / f64::from(scene.scale)).as_vec3(),
            forward,
            right: right * (half * width / height),
            up: up * half,
            perspective,
        }
    }

    /// Origin and unit direction of the ray through a point of the picture, in pixels from the
    /// upper left corner.
    pub(super) fn ray(&self, x: f32, y: f32) -> (Vec3, Vec3) {
        let across = self.right * (2.0 * x / self.width - 1.0);
        let offset = across + self.up * (1.0 - 2.0 * y / self.height);
        if self.perspective {
            (self.origin, (self.forward + offset).normalize())
        } else {
            (self.origin + offset, self.forward)
        }
    }

    /// Where a point lies in the picture, −1..1 to the right and up if it is inside.
    pub(super) fn project(&self, point: Vec3) -> Option<[f32; 2]> {
        let to = point - self.origin;
        let depth = to.dot(self.forward);
        if depth <= 0.0 {
            return None;
        }
        let scale = if self.perspective { 1.0 / depth } else { 1.0 };
        Some([self.right, self.up].map(|axis| to.dot(axis) * scale / axis.length_squared()))
    }

    /// Height of a pixel at a distance.
    pub(super) fn pixel_size(&self, distance: f32) -> f32 {
        let at_one = 2.0 * self.up.length() / self.height;
        if self.perspective {
            at_one * distance
        } else {
            at_one
        }
    }

    pub(super) fn origin(&self) -> Vec3 {
        self.origin
    }
}
