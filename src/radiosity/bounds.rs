use glam::{Vec2, Vec2Swizzles, Vec3};

/// What directions lose by being packed, and more: a box is grown by this before rays are held
/// against it, in internal units (the scene is 2048 across).
const SLACK: f32 = 0.5;

/// A box with sides along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) low: Vec3,
    pub(crate) high: Vec3,
}

impl Bounds {
    /// The least box around points; inside out if there are none.
    pub(crate) fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        let empty = Self {
            low: Vec3::INFINITY,
            high: Vec3::NEG_INFINITY,
        };
        points.into_iter().fold(empty, |b, p| Self {
            low: b.low.min(p),
            high: b.high.max(p),
        })
    }

    fn joined(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// A sphere around it.
    pub(crate) fn sphere(&self) -> Sphere {
        let center = 0.5 * (self.low + self.high);
        Sphere {
            center,
            radius: center.distance(self.high),
        }
    }

    /// Distance from a point; 0 inside.
    fn distance(&self, p: Vec3) -> f32 {
        (self.low - p).max(p - self.high).max(Vec3::ZERO).length()
    }

    /// Whether the box, grown by `margin`, meets the segment from `origin` along `direction`.
    fn meets(&self, origin: Vec3, direction: Vec3, length: f32, margin: f32) -> bool {
        let inverse = direction.map(|d| 1.0 / if d.abs() < 1e-20 { 1e-20 } else { d });
        let a = (self.low - margin - origin) * inverse;
        let b = (self.high + margin - origin) * inverse;
        let near = a.min(b).max_element().max(0.0);
        let far = a.max(b).min_element().min(length);
        near <= far
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Sphere {
    pub(crate) center: Vec3,
    pub(crate) radius: f32,
}

/// Above this many boxes one around all of them is as good.
const MANY: usize = 32;

/// Where geometry came, went or let light through differently: rays elsewhere find what they found.
#[derive(Clone, Debug, Default)]
pub(crate) struct Disturbed {
    boxes: Vec<Bounds>,
}

impl Disturbed {
    pub(crate) fn new(boxes: Vec<Bounds>) -> Self {
        match boxes.iter().copied().reduce(Bounds::joined) {
            Some(all) if boxes.len() > MANY => Self { boxes: vec![all] },
            _ => Self { boxes },
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.boxes.is_empty()
    }

    /// Prepares the test of rays that start within a sphere.
    pub(crate) fn from(&self, start: Sphere) -> DisturbedFrom<'_> {
        let margin = start.radius + SLACK;
        let away = self.boxes.iter().map(|b| b.distance(start.center) - margin);
        DisturbedFrom {
            boxes: &self.boxes,
            start,
            nearest: away.fold(f32::INFINITY, f32::min),
        }
    }

    /// Whether light on its way between any two points of two spheres may be disturbed.
    pub(crate) fn between(&self, a: Sphere, b: Sphere) -> bool {
        // Every such path stays this close to the line between the centres.
        let margin = a.radius.max(b.radius) + SLACK;
        let way = b.center - a.center;
        let length = way.length();
        let direction = way.try_normalize().unwrap_or(Vec3::X);
        self.boxes
            .iter()
            .any(|x| x.meets(a.center, direction, length, margin))
    }

    /// Whether light from far away, travelling along `-direction`, may be disturbed before it
    /// reaches a sphere.
    pub(crate) fn towards(&self, direction: Vec3, to: Sphere) -> bool {
        let margin = to.radius + SLACK;
        self.boxes
            .iter()
            .any(|x| x.meets(to.center, direction, f32::INFINITY, margin))
    }
}

/// See [`Disturbed::from`].
pub(crate) struct DisturbedFrom<'a> {
    boxes: &'a [Bounds],
    start: Sphere,
    /// No box is nearer.
    nearest: f32,
}

impl DisturbedFrom<'_> {
    /// Whether what a ray met may have changed. May say so where it did not, never the reverse.
    #[inline]
    pub(crate) fn ray(&self, reach: Reach) -> bool {
        if reach.distance < self.nearest {
            return false;
        }
        let direction = unpack(reach.direction);
        let margin = self.start.radius + SLACK;
        self.boxes
            .iter()
            .any(|b| b.meets(self.start.center, direction, reach.distance, margin))
    }
}

/// How far a ray went, and which way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reach {
    /// Infinite if it met nothing.
    pub(crate) distance: f32,
    direction: u32,
}

impl Reach {
    pub(crate) fn new(direction: Vec3, distance: f32) -> Self {
        Self {
            distance,
            direction: pack(direction),
        }
    }
}

/// A unit vector in two times 16 bits: the octahedron folded flat (Cigolle et al. 2014, "A Survey
/// of Efficient Representations for Independent Unit Vectors"); errors stay below 10⁻⁴.
fn pack(v: Vec3) -> u32 {
    let p = v.truncate() / (v.x.abs() + v.y.abs() + v.z.abs());
    let p = if v.z < 0.0 { fold(p) } else { p };
    let [x, y] = (p.clamp(Vec2::NEG_ONE, Vec2::ONE) * 32767.0)
        .round()
        .to_array();
    u32::from((x as i16) as u16) << 16 | u32::from((y as i16) as u16)
}

#[inline]
fn unpack(packed: u32) -> Vec3 {
    let half = |bits: u32| f32::from(bits as u16 as i16) / 32767.0;
    let p = Vec2::new(half(packed >> 16), half(packed));
    let z = 1.0 - p.x.abs() - p.y.abs();
    let p = if z < 0.0 { fold(p) } else { p };
    p.extend(z).normalize()
}

fn fold(p: Vec2) -> Vec2 {
    (Vec2::ONE - p.yx().abs()) * Vec2::new(1.0_f32.copysign(p.x), 1.0_f32.copysign(p.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiosity::sampling::sobol;

    #[test]
    fn packed_directions_are_within_the_slack() {
        for i in 0..20_000 {
            let [x, y, z, _] = sobol(i, 0, 4);
            let v = Vec3::new(x - 0.5, y - 0.5, z - 0.5).normalize();
            assert!((unpack(pack(v)) - v).length() < 1e-4, "{v}");
        }
    }

    #[test]
    fn rays_through_a_box_are_never_missed() {
        let b = Bounds {
            low: Vec3::new(10.0, -5.0, 3.0),
            high: Vec3::new(30.0, 8.0, 9.0),
        };
        let disturbed = Disturbed::new(vec![b]);
        for i in 0..20_000 {
            let [x, y, z, r] = sobol(i, 0, 4);
            let [u, v, w, _] = sobol(i, 1, 4);
            let start = Vec3::new(x - 0.5, y - 0.5, z - 0.5) * 2000.0;
            let inside = b.low + (b.high - b.low) * Vec3::new(u, v, w);
            let way = inside - start;
            let center = start + Vec3::new(w - 0.5, u - 0.5, v - 0.5) * r;
            let from = disturbed.from(Sphere { center, radius: r });
            assert!(from.ray(Reach::new(way.normalize(), way.length())));
            let beyond = inside + way.normalize() * 50.0;
            let at = |center, radius| Sphere { center, radius };
            assert!(disturbed.between(at(center, r), at(beyond, 0.0)));
            assert!(disturbed.towards(way.normalize(), at(center, r)));
        }
    }
}
