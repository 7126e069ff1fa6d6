use std::ops::Range;

use glam::Vec3;

use super::bounds::{Bounds, Disturbed};
use super::element::Elements;
use super::form_factor::GONE;
use super::identity::{light_identities, matches, object_identities};
use super::scene::{AlphaMode, Material, Object};
use super::validate::ValidScene;

/// What differs between the scene baked last and the one to bake, as rays see it.
pub(crate) struct Change {
    /// For each element, the number it had; `None` if it is new.
    pub(crate) element_before: Vec<Option<u32>>,
    /// For each old element, the number it has now, or [`GONE`].
    element_now: Vec<u32>,
    /// All elements are as they were, and have the numbers they had.
    pub(crate) same_elements: bool,
    /// For each old live triangle, the number it has now, or [`GONE`].
    pub(crate) triangle_now: Vec<u32>,
    /// All live triangles have the numbers they had.
    pub(crate) same_triangles: bool,
    /// For each light, which it was, if nothing but its power changed.
    pub(crate) light_before: Vec<Option<usize>>,
    /// For each object, which it was, if its receiving mesh is still the same.
    pub(crate) mesh_before: Vec<Option<usize>>,
    /// For each object, which it was.
    pub(crate) object_before: Vec<Option<usize>>,
    pub(crate) disturbed: Disturbed,
    /// Surfaces emit that did not, or the other way round, or emitters came, went or moved.
    pub(crate) new_emitters: bool,
    /// Reflectance or emission of any element is another.
    pub(crate) new_looks: bool,
}

/// A scene and its elements.
pub(crate) type Side<'a> = (&'a ValidScene, &'a Elements);

impl Change {
    pub(crate) fn between(old: Side, new: Side) -> Self {
        let objects = matches(&object_identities(old.0), &object_identities(new.0));
        let (old_live, new_live) = (LiveRanges::new(old.0), LiveRanges::new(new.0));
        let mut change = Self {
            element_before: vec![None; new.1.len()],
            element_now: vec![GONE; old.1.len()],
            same_elements: true,
            triangle_now: vec![GONE; old.0.triangles.len()],
            same_triangles: old.0.triangles.len() == new.0.triangles.len(),
            light_before: lights(old.0, new.0),
            mesh_before: vec![None; new.0.objects.len()],
            object_before: objects.clone(),
            disturbed: Disturbed::default(),
            new_emitters: false,
            new_looks: false,
        };
        let mut stays = vec![false; old.0.objects.len()];
        let mut boxes = Vec::new();
        for (o, before) in objects.into_iter().enumerate() {
            let kept = before.filter(|&p| {
                let same_live = old_live.of(old.0, p).eq(new_live.of(new.0, o));
                if same_live && same_mesh(&old.0.objects[p], &new.0.objects[o]) {
                    change.mesh_before[o] = Some(p);
                }
                same_live && same_surface(old, p, new, o)
            });
            if let Some(p) = kept {
                stays[p] = true;
                change.keep_elements(old.1.of_object(p), new.1.of_object(o));
                change.keep_triangles(&old_live.0[p], &new_live.0[o]);
            } else {
                boxes.extend(casting_bounds(&new.0.objects[o]));
            }
        }
        for (object, _) in old
            .0
            .objects
            .iter()
            .zip(&stays)
            .filter(|(_, stays)| !**stays)
        {
            boxes.extend(casting_bounds(object));
        }
        change.disturbed = Disturbed::new(boxes);
        change.compare_looks(old.1, new.1);
        change
    }

    fn keep_elements(&mut self, old: Range<usize>, new: Range<usize>) {
        self.same_elements &= old == new;
        for (p, e) in old.zip(new) {
            self.element_before[e] = Some(p as u32);
            self.element_now[p] = e as u32;
        }
    }

    fn keep_triangles(&mut self, old: &Range<usize>, new: &Range<usize>) {
        self.same_triangles &= old == new;
        for (p, t) in old.clone().zip(new.clone()) {
            self.triangle_now[p] = t as u32;
        }
    }

    fn compare_looks(&mut self, old: &Elements, new: &Elements) {
        let gone = self.element_now.contains(&GONE);
        self.same_elements &= !gone && self.element_before.iter().all(Option::is_some);
        self.new_looks = !self.same_elements;
        let shines = |elements: &Elements, e: usize| elements.emission[e] != Vec3::ZERO;
        for (e, before) in self.element_before.iter().enumerate() {
            let Some(p) = before.map(|p| p as usize) else {
                self.new_emitters |= shines(new, e);
                continue;
            };
            self.new_emitters |= shines(new, e) != shines(old, p);
            self.new_looks |=
                new.reflectance[e] != old.reflectance[p] || new.emission[e] != old.emission[p];
        }
        // What an even emitter sends is known of one of its elements, on behalf of all.
        for (t, &now) in self.triangle_now.iter().enumerate() {
            let kept = now != GONE;
            self.new_emitters |= kept && old.shines_evenly(t as u32) != new.shines_evenly(now);
        }
        let mut went = (self.element_now.iter().enumerate()).filter(|(_, now)| **now == GONE);
        self.new_emitters |= went.any(|(p, _)| shines(old, p));
    }

    /// The number an element has now, given the one it had; other marks stay as they are.
    #[inline]
    pub(crate) fn translate(&self, id: u32) -> u32 {
        self.element_now.get(id as usize).copied().unwrap_or(id)
    }

    pub(crate) fn elements_now(&self) -> &[u32] {
        &self.element_now
    }
}

/// The live triangles of each object, which follow each other.
struct LiveRanges(Vec<Range<usize>>);

impl LiveRanges {
    fn new(scene: &ValidScene) -> Self {
        let mut end = 0;
        let ranges = (0..scene.objects.len()).map(|o| {
            let rest = &scene.triangles[end..];
            let start = end;
            end += rest.iter().take_while(|t| t.object as usize == o).count();
            start..end
        });
        Self(ranges.collect())
    }

    fn of<'a>(&'a self, scene: &'a ValidScene, object: usize) -> impl Iterator<Item = u32> + 'a {
        let range = self.0[object].clone();
        scene.triangles[range].iter().map(|t| t.triangle)
    }
}

/// Whether light leaves the object's mesh as it is, to receive on.
fn same_mesh(a: &Object, b: &Object) -> bool {
    a.receives == b.receives
        && a.casts == b.casts
        && a.positions == b.positions
        && a.normals == b.normals
        && a.triangles == b.triangles
}

/// Whether rays meet, pass and leave the object as they did.
fn same_surface((old, was): Side, p: usize, (new, is): Side, o: usize) -> bool {
    let (a, b) = (&old.objects[p], &new.objects[o]);
    let sides = |scene: &ValidScene, object: &Object| material(scene, object).double_sided;
    a.casts == b.casts
        && a.positions == b.positions
        && a.triangles == b.triangles
        && sides(old, a) == sides(new, b)
        && same_alpha(old, a, new, b)
        && is.same_shapes(o, was, p)
}

fn material<'a>(scene: &'a ValidScene, object: &Object) -> &'a Material {
    &scene.materials[object.material.0 as usize]
}

/// Whether what passes a surface in part is the same.
fn same_alpha(old: &ValidScene, a: &Object, new: &ValidScene, b: &Object) -> bool {
    let (m, n) = (material(old, a), material(new, b));
    if m.alpha != n.alpha {
        return false;
    }
    if m.alpha == AlphaMode::Opaque {
        return true;
    }
    let image = |scene: &ValidScene, m: &Material| {
        let slot = m.base_color_texture?;
        Some((
            slot.uv_set,
            slot.transform,
            scene.textures[slot.texture.0 as usize].clone(),
        ))
    };
    m.base_color.w == n.base_color.w
        && a.colors == b.colors
        && a.uvs == b.uvs
        && image(old, m) == image(new, n)
}

fn casting_bounds(object: &Object) -> Option<Bounds> {
    let used = object.triangles.iter().flatten();
    let bounds = Bounds::of(used.map(|&v| object.positions[v as usize]));
    (object.casts && !object.triangles.is_empty()).then_some(bounds)
}

/// For each new light, the old one it was, if it reaches what that reached.
fn lights(old: &ValidScene, new: &ValidScene) -> Vec<Option<usize>> {
    let places = matches(&light_identities(old), &light_identities(new));
    (new.lights.iter().zip(places))
        .map(|(light, place)| place.filter(|&p| old.lights[p].kind == light.kind))
        .collect()
}
