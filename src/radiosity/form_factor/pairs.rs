use glam::Vec3;

use crate::radiosity::element::ElementId;
use crate::radiosity::observer::{Observer, Stage};
use crate::radiosity::occlusion::OFFSET;
use crate::radiosity::parallel::{Cancelled, map_ranges};
use crate::radiosity::report::FormFactorReport;
use crate::radiosity::sampling::{hash, sobol};

use super::View;
use super::matrix::{KeptRow, Matrix, Row};
use super::polygon::kernel;
use super::traced::Traced;

/// A way to find form factors of one pair of elements after the other.
pub(super) trait Pairwise: Sync {
    fn view(&self) -> &View<'_>;

    /// What two elements exchange, `A_i F_ij = A_j F_ji` of their whole areas, for `i <= j`, and
    /// how many shadow rays that took.
    fn exchange(&self, i: usize, j: usize) -> (f64, u32);
}

/// The form factor from element `i` to element `j`.
pub(super) fn form_factor(method: &impl Pairwise, i: usize, j: usize) -> f64 {
    let (exchange, _) = method.exchange(i.min(j), i.max(j));
    exchange * weight(method.view(), i, j)
}

/// The row of one element as [`matrix`] finds it.
pub(super) fn row(method: &impl Pairwise, e: usize) -> Row {
    let view = method.view();
    let mut weights: Vec<f32> = (0..view.elements.len())
        .map(|j| form_factor(method, e, j) as f32)
        .collect();
    scale(&mut weights);
    let entries = weights.iter().enumerate().filter(|(_, w)| **w != 0.0);
    Row {
        entries: entries.map(|(j, &w)| (j as u32, w)).collect(),
        sky: sky(view, e),
    }
}

/// What makes an exchange the form factor from `i` to `j`: the area of `i`, and the share of `j`
/// that is there.
fn weight(view: &View, i: usize, j: usize) -> f64 {
    let whole = whole_area(view, i);
    if whole > 0.0 {
        f64::from(view.elements.coverage[j]) / whole
    } else {
        0.0
    }
}

/// The area of an element with the part that lets light pass; 0 if all of it does.
pub(super) fn whole_area(view: &View, e: usize) -> f64 {
    let coverage = f64::from(view.elements.coverage[e]);
    if coverage > 0.0 {
        f64::from(view.elements.area[e]) / coverage
    } else {
        0.0
    }
}

/// Rows a thread takes at a time.
const CHUNK: usize = 4;

/// All form factors: each pair once, the other way by reciprocity.
///
/// A row that sums to more than 1 would let light grow. It is scaled to 1, which costs it
/// reciprocity, and counted.
pub(super) fn matrix(
    method: &impl Pairwise,
    observer: &dyn Observer,
) -> Result<(Traced, u64), Cancelled> {
    let view = method.view();
    let count = view.elements.len();
    // Row i from the diagonal on.
    let halves = map_ranges(count, CHUNK, Stage::FormFactors, observer, |range| {
        let first = range.start;
        let mut rays = 0;
        let pairs = range.clone().flat_map(|i| (i..count).map(move |j| (i, j)));
        let exchanges = pairs.map(|(i, j)| {
            let (exchange, traced) = method.exchange(i, j);
            rays += u64::from(traced);
            exchange as f32
        });
        let exchanges: Vec<f32> = exchanges.collect();
        let sky: Vec<f32> = range.map(|e| sky(view, e)).collect();
        (first, exchanges, sky, rays)
    })?;
    let mut weights = vec![vec![0.0; count]; count];
    let (mut traced_rays, mut skies) = (0, Vec::with_capacity(count));
    for (first, exchanges, sky, rays) in halves {
        let pairs = (first..first + sky.len()).flat_map(|i| (i..count).map(move |j| (i, j)));
        for ((i, j), exchange) in pairs.zip(exchanges) {
            for (i, j) in [(i, j), (j, i)] {
                weights[i][j] = (f64::from(exchange) * weight(view, i, j)) as f32;
            }
        }
        skies.extend(sky);
        traced_rays += rays;
    }
    let mut report = FormFactorReport::default();
    let mut excess = Vec::with_capacity(count);
    for row in &mut weights {
        let sum = scale(row);
        excess.push((sum - 1.0).max(0.0) as f32);
        report.largest_row_sum = report.largest_row_sum.max(sum);
        report.scaled_rows += u64::from(sum > 1.0 + ROUNDING);
    }
    let rows = Matrix::Rows(weights.into_iter().map(KeptRow::dense).collect());
    let traced = Traced {
        excess,
        ..Traced::of_matrix(rows, skies, report)
    };
    Ok((traced, traced_rays))
}

/// By how much the weights of a row, rounded to `f32`, may sum to more than they did.
const ROUNDING: f64 = 1e-6;

/// Scales a row that sums to more than 1. Returns the sum it had.
fn scale(row: &mut [f32]) -> f64 {
    let sum = row.iter().map(|&w| f64::from(w)).sum::<f64>();
    if sum > 1.0 {
        row.iter_mut()
            .for_each(|w| *w = (f64::from(*w) / sum) as f32);
    }
    sum
}

/// The share of an element's view that is sky, by cosine-distributed rays.
fn sky(view: &View, e: usize) -> f32 {
    if view.scene.sky == Vec3::ZERO {
        return 0.0;
    }
    let misses = (0..view.settings.element_rays).filter(|&i| view.cast(e, i).hit.is_none());
    misses.count() as f32 / view.settings.element_rays as f32
}

/// Two points, one on each element.
pub(super) struct Connection {
    /// `cos cos / π r²`.
    pub(super) kernel: f64,
    from: Vec3,
    to: Vec3,
    triangles: [u32; 2],
}

impl View<'_> {
    /// Pairs of points on elements `i` and `j`, both spread evenly.
    pub(super) fn connections(&self, i: usize, j: usize) -> impl Iterator<Item = Connection> {
        let ids = [i, j].map(|e| ElementId(e as u32));
        let [seed, seed_there] = ids.map(|e| self.elements.seed(e, self.settings.seed));
        let seed = hash(seed, seed_there);
        // The first four dimensions: of higher ones, few points fill no square of two evenly.
        (0..).map(move |s| {
            let [u, v, u_there, v_there] = sobol(s, 0, seed);
            let a = self.elements.point(self.scene, ids[0], u, v);
            let b = self.elements.point(self.scene, ids[1], u_there, v_there);
            let ray = b.position.as_dvec3() - a.position.as_dvec3();
            Connection {
                kernel: kernel(ray, a.normal.as_dvec3(), b.normal.as_dvec3()),
                from: a.position + a.normal * OFFSET,
                to: b.position + b.normal * OFFSET,
                triangles: [a.triangle, b.triangle],
            }
        })
    }

    /// How much light gets from one point to the other.
    pub(super) fn passing(&self, connection: &Connection) -> f64 {
        let ray = connection.to - connection.from;
        let distance = ray.length();
        let direction = ray / distance.max(f32::MIN_POSITIVE);
        let passing = self.occluders.transmittance(
            connection.from,
            direction,
            distance,
            connection.triangles,
        );
        passing.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiosity::bvh::BvhQuality;
    use crate::radiosity::element::Elements;
    use crate::radiosity::emitter::Emitters;
    use crate::radiosity::emitter_tree::EmitterTree;
    use crate::radiosity::form_factor::analytic::Analytic;
    use crate::radiosity::form_factor::area_sampling::AreaSampling;
    use crate::radiosity::layout::Layout;
    use crate::radiosity::occlusion::{Hierarchy, Holds, Occluders};
    use crate::radiosity::scene::{Material, Object, Scene};
    use crate::radiosity::settings::BakeSettings;
    use crate::radiosity::surface::{Pyramids, Surfaces};

    /// Three walls of a corner under a sky, seen by elements.
    fn look(ask: impl Fn(View)) {
        let corner = Object {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1]],
            ..Object::default()
        };
        let scene = Scene {
            objects: vec![corner],
            materials: vec![Material::default()],
            sky: Vec3::ONE,
            ..Scene::default()
        };
        let scene = scene.validate().expect("a scene to bake");
        let settings = BakeSettings {
            elements: 60,
            refine: false,
            ..BakeSettings::DRAFT
        };
        let pyramids = Pyramids::new(&scene, None);
        let surfaces = Surfaces::new(&scene, &pyramids);
        let elements = Elements::new(&scene, &surfaces, &Layout::even(&scene, &settings), 0.9);
        let hierarchy = Hierarchy::new(&scene, &surfaces, Holds::Casting, BvhQuality::Quick);
        let occluders = Occluders::new(&hierarchy, &surfaces);
        let tree = EmitterTree::new(&scene, &elements, &occluders, &settings, &());
        let tree = tree.expect("nobody cancels");
        ask(View {
            scene: &scene,
            occluders,
            elements: &elements,
            emitters: Emitters::at_elements(&tree, &settings),
            marks: &vec![false; elements.len()],
            settings: &settings,
            remember: false,
        });
    }

    fn assert_rows_are_the_matrix(method: &impl Pairwise) {
        let (traced, rays) = matrix(method, &()).expect("nobody cancels");
        assert!(rays > 0);
        for e in 0..traced.rows.len() {
            let alone = row(method, e);
            assert_eq!(alone.sky, traced.sky[e]);
            assert!(alone.sky > 0.0 && alone.sum() > 0.0);
            let mut found = Vec::new();
            traced.rows.each(e, |j, weight| found.push((j, weight)));
            assert_eq!(found.len(), alone.entries.len());
            for ((i, weight), (j, weight_alone)) in found.into_iter().zip(alone.entries) {
                assert!(i == j && (weight - weight_alone).abs() <= 1e-6 * weight);
            }
        }
    }

    #[test]
    fn a_row_alone_is_that_of_the_matrix() {
        look(|view| {
            assert_rows_are_the_matrix(&Analytic::new(view, 2));
            assert_rows_are_the_matrix(&AreaSampling::new(view, 2));
        });
    }
}
