use bevy_fresco::radiosity::point_to_polygon;
use glam::{DVec3, Vec3};

use super::layout::{Corners, Layout, Source};
use super::polygon::Polygon;

/// Points of a panel along each side that are tested to be seen.
const PANEL_POINTS: u32 = 24;

/// Farther off than anything.
const FAR: f64 = 1e4;

/// How far before its face a point is tested, in metres: more than rounding to `f32` moves it.
const LIFT: f64 = 2e-6;

/// Light that arrives without a bounce, but for the sky's: in closed form, what is seen by tests
/// against every face.
pub(crate) struct Direct {
    faces: Vec<Polygon>,
    sources: Vec<Source>,
}

impl Direct {
    pub(crate) fn new(layout: &Layout) -> Self {
        let lamps = layout.parts.iter().filter(|p| p.emission != Vec3::ZERO);
        let panels = lamps.flat_map(|lamp| {
            let panel = |&corners: &Corners| Source::Panel {
                corners,
                radiance: lamp.emission,
            };
            lamp.faces.iter().map(panel)
        });
        Self {
            faces: layout.polygons(),
            sources: layout.sources.iter().copied().chain(panels).collect(),
        }
    }

    /// Irradiance / π at a point of a surface that faces `normal`.
    pub(crate) fn at(&self, point: DVec3, normal: DVec3) -> DVec3 {
        let from = point + normal * LIFT;
        let brings = |source: &Source| match *source {
            Source::Sun { direction, light } => {
                let way = -direction.as_dvec3().normalize();
                let cosine = normal.dot(way);
                let lit = cosine > 0.0 && self.sees(from, from + way * FAR);
                light.as_dvec3() * if lit { cosine } else { 0.0 }
            }
            Source::Bulb { position, light } => {
                let to = position.as_dvec3() - point;
                let cosine = normal.dot(to.normalize());
                let lit = cosine > 0.0 && self.sees(from, position.as_dvec3());
                light.as_dvec3()
                    * if lit {
                        cosine / to.length_squared()
                    } else {
                        0.0
                    }
            }
            Source::Panel { corners, radiance } => {
                radiance.as_dvec3() * self.panel(from, normal, corners.map(Vec3::as_dvec3))
            }
        };
        self.sources.iter().map(brings).sum()
    }

    /// The form factor to a parallelogram times the share that is seen, by what it brings.
    fn panel(&self, from: DVec3, normal: DVec3, corners: [DVec3; 4]) -> f64 {
        let factor = point_to_polygon(from, normal, &corners);
        if factor == 0.0 {
            return 0.0;
        }
        let [a, b, _, d] = corners;
        let (u, v) = (b - a, d - a);
        let facing = u.cross(v).normalize();
        let (mut seen, mut whole) = (0.0, 0.0);
        let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(PANEL_POINTS);
        for i in 0..PANEL_POINTS * PANEL_POINTS {
            let at = a + u * middle(i % PANEL_POINTS) + v * middle(i / PANEL_POINTS);
            let to = at - from;
            let brings = normal.dot(to).max(0.0) * -facing.dot(to) / to.length_squared().powi(2);
            whole += brings;
            if brings > 0.0 && self.sees(from, at) {
                seen += brings;
            }
        }
        if whole > 0.0 {
            factor * seen / whole
        } else {
            0.0
        }
    }

    /// Whether nothing stands between two points. A face that one of them lies on does not.
    fn sees(&self, from: DVec3, to: DVec3) -> bool {
        let between = |face: &Polygon| face.met(from, to).is_some_and(|t| t < 1.0 - 1e-9);
        !self.faces.iter().any(between)
    }

    /// How far it is from a point, straight on, to the next face.
    pub(crate) fn clearance(&self, point: DVec3, normal: DVec3) -> f64 {
        let from = point + normal * LIFT;
        let met = self
            .faces
            .iter()
            .filter_map(|f| f.met(from, from + normal * FAR));
        met.fold(1.0, f64::min) * FAR
    }

    /// Whether a point lies inside a block or under it: what it sees first is a back.
    pub(crate) fn buried(&self, point: DVec3, normal: DVec3) -> bool {
        let from = point + normal * LIFT;
        // Not along the edges of anything.
        let way = normal + DVec3::new(0.0137, 0.0071, 0.0093);
        let met = self.faces.iter().filter_map(|face| {
            let t = face.met(from, from + way * FAR)?;
            Some((t, face.normal.dot(way) > 0.0))
        });
        met.min_by(|a, b| a.0.total_cmp(&b.0)).is_some_and(|m| m.1)
    }
}
