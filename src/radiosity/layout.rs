use std::sync::Arc;

use super::settings::BakeSettings;
use super::triangle::area;
use super::validate::ValidScene;

/// Elements along an edge of a patch that nothing is known of: a quarter of the elements are enough
/// for a first look.
pub(super) const USUAL: u8 = 2;

/// A first look takes one of so many rays.
const FIRST_RAYS: u32 = 2;

/// How surfaces are cut into elements, and how many rays each of these casts.
///
/// The surface is cut evenly into patches, and each patch into elements as its light needs it. A bake
/// keeps its layout for the next one, so that elements stay what they are where nothing changed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    /// Area of a patch, in squared internal units.
    pub(crate) patch: f32,
    /// Elements, so many times what the settings say.
    pub(crate) more: f32,
    /// Whether elements differ in size: then small pieces between bumps are merged with others.
    pub(crate) adapted: bool,
    /// The cut of a patch that nothing is known of.
    pub(crate) otherwise: Cut,
    /// The cuts of the patches of each object.
    pub(crate) of_object: Vec<Arc<[Cut]>>,
}

/// How a patch is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cut {
    /// Elements along an edge.
    pub(crate) m: u8,
    /// Rays of each element.
    pub(crate) rays: u16,
}

impl Layout {
    /// Elements of one size, about as many as the settings ask for.
    pub(crate) fn even(scene: &ValidScene, settings: &BakeSettings) -> Self {
        let rays = settings.element_rays as u16;
        Self {
            patch: Self::wanted(scene, settings),
            more: 1.0,
            adapted: false,
            otherwise: Cut { m: 1, rays },
            of_object: Vec::new(),
        }
    }

    /// Patches for a first look, larger than elements will be, and not cut before it.
    pub(crate) fn first_look(scene: &ValidScene, settings: &BakeSettings) -> Self {
        let even = Self::even(scene, settings);
        let rays = (settings.element_rays / FIRST_RAYS).max(2) as u16;
        Self {
            patch: even.patch * f32::from(USUAL).powi(2),
            adapted: true,
            otherwise: Cut { m: 1, rays },
            ..even
        }
    }

    /// The layout after a first look.
    pub(crate) fn looked_at(&self, of_object: Vec<Arc<[Cut]>>, settings: &BakeSettings) -> Self {
        Self {
            patch: self.patch,
            more: self.more,
            adapted: true,
            otherwise: Cut {
                m: USUAL,
                rays: settings.element_rays as u16,
            },
            of_object,
        }
    }

    /// Area of an element for about as many as the settings ask for, in squared internal units.
    fn wanted(scene: &ValidScene, settings: &BakeSettings) -> f32 {
        let casting = scene.triangles.iter().filter(|&&t| scene.casts(t));
        let total: f64 = casting.map(|&t| f64::from(area(scene.corners(t)))).sum();
        (total / f64::from(settings.elements.max(1))) as f32
    }

    /// How much larger or smaller elements would be that fit the scene.
    pub(crate) fn outgrown(&self, scene: &ValidScene, settings: &BakeSettings) -> f32 {
        let wanted = Self::wanted(scene, settings) / self.more;
        wanted * f32::from(self.otherwise.m).powi(2) / self.patch
    }

    pub(crate) fn cut(&self, object: usize, patch: usize) -> Cut {
        let cuts = self.of_object.get(object);
        *cuts
            .and_then(|cuts| cuts.get(patch))
            .unwrap_or(&self.otherwise)
    }

    /// The layout of another scene, each of whose objects keeps the cuts of the one it was.
    pub(crate) fn renumbered(&self, before: &[Option<usize>]) -> Self {
        let cuts = |p: &Option<usize>| p.and_then(|p| self.of_object.get(p)).cloned();
        Self {
            of_object: before.iter().map(|p| cuts(p).unwrap_or_default()).collect(),
            ..self.clone()
        }
    }

    pub(crate) fn bytes(&self) -> u64 {
        let cuts = self.of_object.iter().map(|cuts| size_of_val(&**cuts));
        cuts.sum::<usize>() as u64
    }
}
