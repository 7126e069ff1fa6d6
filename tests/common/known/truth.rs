use bevy_fresco::radiosity::{BakeError, BakeSettings, MaterialId, Object, Scene, bake};
use glam::{DVec3, Vec3};

use super::direct::Direct;
use super::layout::{Corners, Layout, Part, Source};
use super::polygon::Polygon;
use super::shown::{Lit, Shown, lit};

/// Faces nearer to each other than this cut each other, in metres: light changes along the outline
/// of what hovers as well.
const NEAR: f64 = 0.12;

/// Cells in a spacing where a face lies nearer than that to another. Narrower gaps than a cell is
/// high are dark.
const CELLS_IN_GAPS: f64 = 4.0;

/// How far before its lamp a panel shines, in metres.
const BEFORE_LAMP: f32 = 1e-4;

/// How carefully bounced light is found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Care {
    /// Between vertices, in metres at most.
    pub(crate) spacing: f32,
    pub(crate) elements: u32,
    /// Bakes that are averaged.
    pub(crate) seeds: u32,
}

/// The light of a layout.
///
/// Direct light is exact. Light that bounces, and that of the sky, is smooth but along the lines
/// where faces touch: it comes from uniform bakes, averaged, of the layout cut along these lines,
/// each piece an object of its own, the direct light of all sources left out.
pub(crate) struct Truth {
    direct: Direct,
    polygons: Vec<Polygon>,
    /// By face of the layout.
    pieces: Vec<Vec<Piece>>,
}

struct Piece {
    outline: Polygon,
    /// The light that bounces, of the even bakes and of the odd ones; none if it is never seen.
    shown: Option<[Shown; 2]>,
}

impl Truth {
    pub(crate) fn find(layout: &Layout, care: Care) -> Result<Self, BakeError> {
        let (direct, polygons) = (Direct::new(layout), layout.polygons());
        let outlines: Vec<Vec<Polygon>> = (polygons.iter())
            .map(|face| pieces(face, &polygons, &direct, care))
            .collect();
        let hidden = |p: &Polygon| direct.buried(p.middle(), p.normal);
        let scene = bounces(layout, &outlines, hidden);
        let objects = scene.objects.clone();
        let halves = average(scene, care)?;
        let mut next = objects.iter().zip(halves);
        let mut piece = |outline: Polygon| {
            let (object, halves) = next.next()?;
            let shown = object.receives.then(|| halves.map(Shown::new));
            Some(Piece { outline, shown })
        };
        Ok(Self {
            pieces: (outlines.into_iter())
                .map(|face| face.into_iter().filter_map(&mut piece).collect())
                .collect(),
            direct,
            polygons,
        })
    }

    /// Irradiance / π at a point of a face; `None` where nothing is seen, inside a block or under
    /// one.
    pub(crate) fn at(&self, face: usize, point: DVec3) -> Option<DVec3> {
        let [a, b] = self.bounced(face, point)?;
        Some(self.direct.at(point, self.polygons[face].normal) + (a + b) * 0.5)
    }

    /// The light that bounces, told by two halves of the bakes.
    pub(crate) fn bounced(&self, face: usize, point: DVec3) -> Option<[DVec3; 2]> {
        let depth = |p: &&Piece| p.outline.depth(point);
        let of = self.pieces[face].iter();
        let piece = of.max_by(|a, b| depth(a).total_cmp(&depth(b)))?;
        let [a, b] = piece.shown.as_ref()?;
        Some([a.at(point)?, b.at(point)?])
    }

    pub(crate) fn normal(&self, face: usize) -> DVec3 {
        self.polygons[face].normal
    }
}

/// A face cut along all planes of faces that are near, and into cells where it lies in a gap.
fn pieces(face: &Polygon, all: &[Polygon], direct: &Direct, care: Care) -> Vec<Polygon> {
    let spacing = f64::from(care.spacing);
    let near = all.iter().filter(|other| other.near(face, NEAR));
    let pieces = near.fold(vec![face.clone()], |pieces, other| {
        let cut = |piece: Polygon| match other.near(&piece, NEAR) {
            true => piece.cut(other),
            false => vec![piece],
        };
        pieces.into_iter().flat_map(cut).collect()
    });
    let cells = |piece: Polygon| {
        let (middle, cell) = (piece.middle(), spacing / CELLS_IN_GAPS);
        let in_gap = (cell..spacing).contains(&direct.clearance(middle, piece.normal));
        match in_gap && !direct.buried(middle, piece.normal) {
            true => piece.cells(cell),
            false => vec![piece],
        }
    };
    pieces.into_iter().flat_map(cells).collect()
}

/// The scene in pieces, without the direct light of sources: lamps are panels before dark faces.
fn bounces(layout: &Layout, faces: &[Vec<Polygon>], hidden: impl Fn(&Polygon) -> bool) -> Scene {
    let dark = |part: &Part| Part {
        emission: Vec3::ZERO,
        ..part.clone()
    };
    let object = |(part, piece): (usize, &Polygon)| Object {
        name: layout.parts[part].name.clone(),
        positions: piece.corners.iter().map(|c| c.as_vec3()).collect(),
        triangles: (2..piece.corners.len() as u32)
            .map(|i| [0, i - 1, i])
            .collect(),
        material: MaterialId(part as u32),
        receives: !hidden(piece),
        ..Object::default()
    };
    let parts = layout.faces().map(|(part, _)| part).zip(faces);
    let all = parts.flat_map(|(part, pieces)| pieces.iter().map(move |piece| (part, piece)));
    let lamps = layout.parts.iter().filter(|p| p.emission != Vec3::ZERO);
    let panels = lamps.flat_map(|lamp| lamp.faces.iter().map(|&face| before(face, lamp.emission)));
    Scene {
        objects: all.map(object).collect(),
        materials: layout.parts.iter().map(|p| dark(p).material()).collect(),
        lights: (layout.sources.iter().copied())
            .chain(panels)
            .map(|s| s.bounced())
            .collect(),
        sky: layout.sky,
        ..Scene::default()
    }
}

fn before([a, b, c, d]: Corners, radiance: Vec3) -> Source {
    let lift = (b - a).cross(d - a).normalize() * BEFORE_LAMP;
    Source::Panel {
        corners: [a, b, c, d].map(|corner| corner + lift),
        radiance,
    }
}

/// The light of each object, the mean of the even and of the odd bakes.
fn average(scene: Scene, care: Care) -> Result<Vec<[Vec<Lit>; 2]>, BakeError> {
    let objects = scene.objects.clone();
    let scene = scene.validate()?;
    let mut sums: Vec<[Vec<Lit>; 2]> = vec![Default::default(); objects.len()];
    for seed in 0..2 * care.seeds.div_ceil(2) {
        let baked = bake(&scene, &care.settings(seed), &())?;
        for ((sum, object), light) in sums.iter_mut().zip(&objects).zip(&baked.objects) {
            if object.receives {
                add(&mut sum[(seed % 2) as usize], lit(object, light));
            }
        }
    }
    let share = 1.0 / f64::from(care.seeds.div_ceil(2));
    for triangle in sums.iter_mut().flatten().flatten() {
        triangle.light = triangle.light.map(|l| l * share);
    }
    Ok(sums)
}

fn add(sum: &mut Vec<Lit>, light: Vec<Lit>) {
    if sum.is_empty() {
        *sum = light;
        return;
    }
    for (sum, light) in sum.iter_mut().zip(light) {
        (sum.light.iter_mut().zip(light.light)).for_each(|(s, l)| *s += l);
    }
}

impl Care {
    fn settings(self, seed: u32) -> BakeSettings {
        BakeSettings {
            max_edge: Some(self.spacing),
            refine: false,
            elements: self.elements,
            element_rays: 128,
            gather_rays: 64,
            samples_per_vertex: 16.0,
            emitter_rays: 24,
            solver_tolerance: 1e-4,
            seed: 7000 + seed,
            ..BakeSettings::FINAL
        }
    }
}
