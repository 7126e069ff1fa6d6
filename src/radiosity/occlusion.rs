use glam::Vec3;

use super::bvh::{Bvh, BvhQuality, Crossing, Ray};
use super::identity::object_seeds;
use super::sampling::{hash, unit_float};
use super::surface::Surfaces;
use super::triangle::area;
use super::validate::{HALF_EXTENT, TriangleKey, ValidScene};

/// How far off its surface a ray starts, in internal units: 16 times the spacing of `f32` at the
/// far end of the scene, the rounding a hit point can carry (Wächter and Binder 2019, "A Fast and
/// Robust Method for Avoiding Self-Intersection", use the same order).
pub(crate) const OFFSET: f32 = 16.0 * HALF_EXTENT * f32::EPSILON;

/// Surfaces met within this distance of the nearest are at one place: which of them is seen must
/// not be left to rounding. See [`Occluders::foremost`].
pub(crate) const TIE: f32 = 2.0 * OFFSET;

/// No triangle to leave out.
pub(crate) const NO_TRIANGLE: u32 = u32::MAX;

/// Where a ray met the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    /// Index into [`ValidScene::triangles`].
    pub(crate) triangle: u32,
    /// Distance in internal units.
    pub(crate) distance: f32,
    /// Weights of the second and third corner.
    pub(crate) uv: [f32; 2],
    /// The side that the winding does not face was hit.
    pub(crate) back: bool,
}

impl From<Crossing> for Hit {
    fn from(found: Crossing) -> Self {
        Self {
            triangle: found.triangle,
            distance: found.distance,
            uv: found.uv,
            back: found.back,
        }
    }
}

/// The ray-tracing hierarchy and what it needs to know of its triangles.
pub(crate) struct Hierarchy {
    bvh: Bvh,
    /// Whether light can pass a live triangle.
    transmits: Vec<bool>,
    /// A number for each live triangle that stays its own when others come and go: it decides
    /// what passes it by chance, and which of two triangles at one place is met.
    names: Vec<u32>,
    /// Area of the object that a live triangle is part of.
    sizes: Vec<f32>,
}

/// Which live triangles a hierarchy holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Holds {
    /// Those that stop light.
    Casting,
    /// All, as a camera sees them.
    All,
}

impl Hierarchy {
    pub(crate) fn new(
        scene: &ValidScene,
        surfaces: &Surfaces,
        holds: Holds,
        quality: BvhQuality,
    ) -> Self {
        let held = |&t: &u32| holds == Holds::All || scene.casts(scene.triangles[t as usize]);
        let ids: Vec<u32> = (0..scene.triangles.len() as u32).filter(held).collect();
        let corner = |&t: &u32| scene.corners(scene.triangles[t as usize]);
        let corners: Vec<[Vec3; 3]> = ids.iter().map(corner).collect();
        let seeds = object_seeds(scene);
        let name = |key: &TriangleKey| hash(key.triangle, seeds[key.object as usize]);
        Self {
            bvh: Bvh::new(&corners, &ids, quality),
            transmits: (0..scene.triangles.len() as u32)
                .map(|t| surfaces.transmits(t))
                .collect(),
            names: scene.triangles.iter().map(name).collect(),
            sizes: sizes(scene),
        }
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.bvh.bytes() + 9 * self.transmits.len() as u64
    }
}

/// For each live triangle, the area of its object's live triangles.
fn sizes(scene: &ValidScene) -> Vec<f32> {
    let mut areas = vec![0.0_f64; scene.objects.len()];
    for &key in &scene.triangles {
        areas[key.object as usize] += f64::from(area(scene.corners(key)));
    }
    let size = |key: &TriangleKey| areas[key.object as usize] as f32;
    scene.triangles.iter().map(size).collect()
}

/// The input triangles as what stops light.
///
/// What a ray meets does not depend on how the hierarchy was built, down to the bit.
#[derive(Clone, Copy)]
pub(crate) struct Occluders<'a> {
    hierarchy: &'a Hierarchy,
    surfaces: &'a Surfaces<'a>,
}

impl<'a> Occluders<'a> {
    pub(crate) fn new(hierarchy: &'a Hierarchy, surfaces: &'a Surfaces<'a>) -> Self {
        Self {
            hierarchy,
            surfaces,
        }
    }

    /// The nearest surface along a ray of unit direction, leaving out triangle `skip`.
    ///
    /// `seed` decides, together with the triangle, whether the ray passes a surface that lets
    /// part of the light through.
    pub(crate) fn closest(
        &self,
        origin: Vec3,
        direction: Vec3,
        skip: u32,
        seed: u32,
    ) -> Option<Hit> {
        let ray = Ray::new(origin, direction);
        let (mut nearest, mut tied) = (None, false);
        let mut distance = f32::INFINITY;
        self.hierarchy.bvh.traverse(&ray, distance, |found| {
            if found.triangle != skip && !self.passes(found.triangle, found.uv, seed) {
                tied |= (found.distance - distance).abs() <= TIE;
                if found.distance < distance {
                    distance = found.distance;
                    nearest = Some(Hit::from(found));
                }
            }
            (distance + TIE).next_up()
        });
        if tied {
            return self.foremost(&ray, distance + TIE, skip, seed);
        }
        nearest
    }

    /// Of surfaces at one place the one that is meant to be seen: a front before a back, so that two
    /// one-sided faces back to back do not show their black sides; then the smaller object, so that
    /// a lamp in the plane of its ceiling and a carpet in that of its floor are not lost; then the
    /// nearer one.
    fn foremost(&self, ray: &Ray, up_to: f32, skip: u32, seed: u32) -> Option<Hit> {
        let hierarchy = self.hierarchy;
        let key = |hit: &Hit| {
            let t = hit.triangle as usize;
            let (size, name) = (hierarchy.sizes[t], hierarchy.names[t]);
            (hit.back, size, hit.distance, name, hit.triangle)
        };
        let mut best: Option<Hit> = None;
        hierarchy.bvh.traverse(ray, up_to.next_up(), |found| {
            let hit = Hit::from(found);
            if found.triangle != skip
                && !self.passes(found.triangle, found.uv, seed)
                && best.is_none_or(|b| key(&hit) < key(&b))
            {
                best = Some(hit);
            }
            up_to.next_up()
        });
        best
    }

    /// The share of light that gets from `origin` to the point at `distance` along `direction`:
    /// 0 if anything opaque stands between, else the product of what each surface lets through.
    ///
    /// It is the mean of what [`Self::closest`] decides by chance, without its noise.
    pub(crate) fn transmittance(
        &self,
        origin: Vec3,
        direction: Vec3,
        distance: f32,
        skip: [u32; 2],
    ) -> f32 {
        let mut passing = 1.0;
        self.hierarchy
            .bvh
            .traverse(&Ray::new(origin, direction), distance, |found| {
                if skip.contains(&found.triangle) {
                    return distance;
                }
                passing *= if self.hierarchy.transmits[found.triangle as usize] {
                    1.0 - self.surfaces.alpha(found.triangle, found.uv)
                } else {
                    0.0
                };
                if passing > 0.0 { distance } else { 0.0 }
            });
        passing
    }

    /// The number by which triangles at one place are chosen among, the lower first.
    pub(crate) fn name(&self, triangle: u32) -> u32 {
        self.hierarchy.names[triangle as usize]
    }

    /// Whether light can pass a live triangle in part.
    pub(crate) fn transmits(&self, triangle: u32) -> bool {
        self.hierarchy.transmits[triangle as usize]
    }

    /// The nearest surface that a camera shows along a ray: `culled` ones are see-through from
    /// behind. Surfaces there in part are passed where their alpha is below `threshold` (0..1),
    /// shifted by triangle so that layers do not hide each other.
    pub(crate) fn shown(
        &self,
        origin: Vec3,
        direction: Vec3,
        culled: &[bool],
        threshold: f32,
    ) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let mut limit = f32::INFINITY;
        self.hierarchy
            .bvh
            .traverse(&Ray::new(origin, direction), limit, |found| {
                let t = found.triangle;
                let see_through = (found.back && culled[t as usize])
                    || (self.hierarchy.transmits[t as usize]
                        && self.surfaces.alpha(t, found.uv)
                            <= (threshold
                                + unit_float(hash(0xA1FA, self.hierarchy.names[t as usize])))
                            .fract());
                if !see_through {
                    limit = found.distance;
                    best = Some(Hit::from(found));
                }
                limit
            });
        best
    }

    /// Whether a ray goes through a surface that is there only in part.
    pub(crate) fn passes(&self, triangle: u32, uv: [f32; 2], seed: u32) -> bool {
        self.hierarchy.transmits[triangle as usize]
            && self.surfaces.alpha(triangle, uv)
                <= unit_float(hash(seed, self.hierarchy.names[triangle as usize]))
    }
}
