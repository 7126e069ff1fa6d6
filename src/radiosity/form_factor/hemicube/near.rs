use crate::radiosity::bounds::Bounds;
use crate::radiosity::element::{ElementId, Elements};
use crate::radiosity::form_factor::View;
use crate::radiosity::form_factor::analytic::Analytic;
use crate::radiosity::form_factor::matrix::Row;
use crate::radiosity::occlusion::{OFFSET, TIE};
use crate::radiosity::validate::ValidScene;
use glam::Vec3;

/// Shadow rays between two near elements.
const VISIBILITY_RAYS: u32 = 16;

/// Elements that a hemicube must not judge: those nearer to an element than its own size.
///
/// A hemicube looks from one point, so it takes what other points of the element see for the same.
/// That holds for what is far beside the size of the element, and fails for what is near: seen from
/// the middle of a unit square, another a tenth above it fills 0.968 of the view, and from all of it
/// 0.827. Such pairs are found in closed form (Baum, Rushmeier and Winget 1989, "Improving Radiosity
/// Solutions Through the Use of Analytically Determined Form-Factors"). As the whole view is 1, what
/// is left for the others is known too:
///
/// ```text
///   ┌────────────────────────────────────────────────────────────────┐
///   │  F_far ← F_far (1 − Σ F_near) / Σ F_far      sky and black too  │
///   └────────────────────────────────────────────────────────────────┘
/// ```
pub(super) struct NearPairs<'a> {
    view: View<'a>,
    analytic: Analytic<'a>,
    bounds: Vec<Bounds>,
    tree: Tree,
}

/// What became of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Mended {
    /// Form factors found in closed form.
    pub(crate) near_pairs: u64,
    /// Near elements had more than the whole view, by the noise of their shadow rays.
    pub(crate) scaled: bool,
}

impl<'a> NearPairs<'a> {
    pub(super) fn new(view: View<'a>) -> Self {
        let ids = (0..view.elements.len() as u32).map(ElementId);
        let of = |e| Bounds::of(view.elements.shape(view.scene, e).flat_map(|s| s.1));
        let bounds: Vec<Bounds> = ids.map(of).collect();
        Self {
            view,
            analytic: Analytic::new(view, VISIBILITY_RAYS),
            tree: Tree::new(&bounds),
            bounds,
        }
    }

    /// Puts the closed form of near pairs in place of what the hemicube found.
    pub(super) fn mend(&self, e: usize, row: &mut Row) -> Mended {
        let mut near = Vec::new();
        let View { elements, .. } = self.view;
        // The edge of a square of the element's whole area.
        let size = (elements.area[e] / elements.coverage[e].max(f32::MIN_POSITIVE)).sqrt();
        self.tree
            .within(&self.bounds[e], size, &self.bounds, &mut near);
        near.retain(|&j| self.face_each_other(e as u32, j));
        if near.is_empty() {
            return Mended::default();
        }
        near.sort_unstable();
        let exact = |&j: &u32| {
            let hidden = self.is_covered(j);
            (
                j,
                if hidden {
                    0.0
                } else {
                    self.analytic.form_factor(e, j as usize)
                },
            )
        };
        let exact: Vec<(u32, f64)> = near.iter().map(exact).collect();
        Mended {
            near_pairs: near.len() as u64,
            scaled: close(row, &exact),
        }
    }

    /// Whether another surface at the same place is met in place of an element. Shadow rays end at
    /// both, and would let both have all the light.
    fn is_covered(&self, j: u32) -> bool {
        let View {
            scene,
            elements,
            occluders,
            ..
        } = &self.view;
        let point = elements.point(scene, ElementId(j), 0.5, 0.5);
        let from = point.position + point.normal * TIE;
        let other = occluders.closest(from, -point.normal, point.triangle, 0);
        other.is_some_and(|hit| {
            let name = |t: u32| (occluders.name(t), t);
            hit.distance < 2.0 * TIE
                && elements.at(&hit).is_some()
                && name(hit.triangle) < name(point.triangle)
        })
    }

    /// Whether each of two elements has a part above the plane of a part of the other.
    fn face_each_other(&self, i: u32, j: u32) -> bool {
        let (scene, elements) = (self.view.scene, self.view.elements);
        i != j && above(scene, elements, i, j) && above(scene, elements, j, i)
    }
}

/// Whether some corner of element `i` is above the plane of some piece of `j`.
fn above(scene: &ValidScene, elements: &Elements, i: u32, j: u32) -> bool {
    elements
        .shape(scene, ElementId(j))
        .any(|(_, plane, normal)| {
            let high = |p: Vec3| normal.dot(p - plane[0]) > 2.0 * OFFSET;
            let mut corners = elements.shape(scene, ElementId(i)).flat_map(|s| s.1);
            corners.any(high)
        })
}

/// Sets form factors, given in rising order, and scales the others and the sky so that the whole is
/// 1 as it was. Returns whether those set exceeded 1 by themselves and were scaled down to it.
fn close(row: &mut Row, exact: &[(u32, f64)]) -> bool {
    let is_near = |id: u32| exact.binary_search_by_key(&id, |e| e.0).is_ok();
    let near: f64 = exact.iter().map(|e| e.1).sum();
    let found = row.entries.iter().filter(|e| is_near(e.0));
    let far = 1.0 - found.map(|e| f64::from(e.1)).sum::<f64>();
    // Where nothing else was seen, what is left went a way that is not known, and is lost.
    let far_scale = if far > 1e-6 {
        ((1.0 - near).max(0.0) / far) as f32
    } else {
        0.0
    };
    row.entries.retain(|e| !is_near(e.0));
    for entry in &mut row.entries {
        entry.1 *= far_scale;
    }
    row.sky *= far_scale;
    let near_scale = 1.0 / near.max(1.0);
    let exact = exact.iter().filter(|e| e.1 > 0.0);
    row.entries
        .extend(exact.map(|&(id, f)| (id, (f * near_scale) as f32)));
    row.entries.sort_unstable_by_key(|e| e.0);
    near > 1.0
}

/// Boxes of elements, halved again and again along their longest side.
struct Tree {
    nodes: Vec<Node>,
    ids: Vec<u32>,
}

struct Node {
    bounds: Bounds,
    /// The second child, the first being next; `None` for a leaf.
    second: Option<u32>,
    first_id: u32,
    count: u32,
}

/// Elements in a leaf, at most.
const LEAF: usize = 8;

impl Tree {
    fn new(bounds: &[Bounds]) -> Self {
        let mut tree = Self {
            nodes: Vec::new(),
            ids: (0..bounds.len() as u32).collect(),
        };
        tree.build(0, bounds.len(), bounds);
        tree
    }

    fn build(&mut self, first: usize, end: usize, bounds: &[Bounds]) {
        let ids = &mut self.ids[first..end];
        let all = ids.iter().map(|&id| bounds[id as usize]);
        let around = Bounds::of(all.flat_map(|b| [b.low, b.high]));
        let node = self.nodes.len();
        self.nodes.push(Node {
            bounds: around,
            second: None,
            first_id: first as u32,
            count: ids.len() as u32,
        });
        if ids.len() <= LEAF {
            return;
        }
        let axis = (around.high - around.low).max_position();
        let place = |id: u32| bounds[id as usize].low[axis] + bounds[id as usize].high[axis];
        let half = ids.len() / 2;
        ids.select_nth_unstable_by(half, |&a, &b| place(a).total_cmp(&place(b)).then(a.cmp(&b)));
        self.build(first, first + half, bounds);
        self.nodes[node].second = Some(self.nodes.len() as u32);
        self.build(first + half, end, bounds);
    }

    /// Elements whose boxes are less than `reach` from a box.
    fn within(&self, of: &Bounds, reach: f32, bounds: &[Bounds], found: &mut Vec<u32>) {
        let mut todo = vec![0];
        while let Some(index) = todo.pop() {
            let node = &self.nodes[index];
            if apart(&node.bounds, of) >= reach {
                continue;
            }
            if let Some(second) = node.second {
                todo.extend([index + 1, second as usize]);
                continue;
            }
            let ids = &self.ids[node.first_id as usize..(node.first_id + node.count) as usize];
            let near = ids
                .iter()
                .filter(|&&id| apart(&bounds[id as usize], of) < reach);
            found.extend(near);
        }
    }
}

/// How far apart two boxes are.
fn apart(a: &Bounds, b: &Bounds) -> f32 {
    (a.low - b.high)
        .max(b.low - a.high)
        .max(Vec3::ZERO)
        .length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiosity::sampling::sobol;

    #[test]
    fn near_boxes_are_all_found() {
        let bounds: Vec<Bounds> = (0..500)
            .map(|i| {
                let [x, y, z, size] = sobol(i, 0, 9);
                let low = Vec3::new(x, y, z);
                Bounds {
                    low,
                    high: low + size * size * size,
                }
            })
            .collect();
        let tree = Tree::new(&bounds);
        for of in &bounds {
            let mut found = Vec::new();
            tree.within(of, 0.2, &bounds, &mut found);
            found.sort_unstable();
            let near = (0..500).filter(|&i| apart(&bounds[i as usize], of) < 0.2);
            assert!(near.eq(found));
        }
    }

    #[test]
    fn a_row_stays_whole() {
        let row = Row {
            entries: vec![(1, 0.3), (4, 0.2), (7, 0.1)],
            sky: 0.1,
        };
        // 0.3 of the view is black; 0.4 of it near.
        let mut mended = row.clone();
        assert!(!close(&mut mended, &[(2, 0.1), (4, 0.0), (7, 0.3)]));
        let scale = 0.6 / 0.7;
        let expected = [(1, 0.3 * scale), (2, 0.1), (7, 0.3)];
        for (entry, expected) in mended.entries.iter().zip(expected) {
            assert_eq!(entry.0, expected.0);
            assert!((entry.1 - expected.1).abs() < 1e-6, "{mended:?}");
        }
        assert_eq!(mended.entries.len(), 3);
        assert!((mended.sky - 0.1 * scale).abs() < 1e-6);

        let mut too_much = row;
        assert!(close(&mut too_much, &[(4, 0.8), (9, 0.4)]));
        assert!((too_much.sum() - 1.0).abs() < 1e-6);
        assert_eq!(too_much.sky, 0.0);
    }
}
