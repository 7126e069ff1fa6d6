//! A picture of a bake, to judge it by.
//!
//! ```text
//!   camera rays ─► base colour × baked light + emission ─► exposure ─► tone map ─► sRGB
//! ```
//!
//! What an engine would draw from the same vertices, but for reflections: light is interpolated
//! between the vertices that carry it, backs of one-sided surfaces are see-through, and metals
//! show their base colour as if they were diffuse.

mod camera;
mod framing;
mod light_lookup;
mod tone;

use glam::Vec3;

pub use camera::{Camera, Projection};

use self::camera::Lens;
use self::light_lookup::LightLookup;
use self::tone::{Tone, auto_exposure, encode};
use super::bake::BakeError;
use super::baked::Bake;
use super::bvh::BvhQuality;
use super::observer::{Observer, Stage};
use super::occlusion::{Hierarchy, Hit, Holds, Occluders};
use super::parallel::map_ranges;
use super::sampling::{hash, sobol, unit_float};
use super::surface::{Pyramids, Surfaces};
use super::triangle::area;
use super::validate::ValidScene;

/// An 8-bit sRGB image.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Rows from the top, `width × height` pixels.
    pub pixels: Vec<[u8; 3]>,
}

/// What a [`preview`] shows.
#[derive(Clone, Debug, PartialEq)]
pub struct PreviewSettings {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Where to look from; `None` finds a view that shows much of what is lit.
    pub camera: Option<Camera>,
    /// Factor from cd/m² to the 0..1 of the picture; `None` lets the picture decide.
    pub exposure: Option<f32>,
}

impl Default for PreviewSettings {
    /// 960 × 720, camera and exposure found.
    fn default() -> Self {
        Self {
            width: 960,
            height: 720,
            camera: None,
            exposure: None,
        }
    }
}

/// Rays a pixel.
const SAMPLES: u32 = 16;

/// Draws a bake.
///
/// The picture depends on its arguments alone: the same bytes for any number of threads.
///
/// # Errors
///
/// [`BakeError::Cancelled`] if the observer said so.
///
/// # Panics
///
/// If `bake` is not of `scene`.
pub fn preview(
    scene: &ValidScene,
    bake: &Bake,
    settings: &PreviewSettings,
    observer: &dyn Observer,
) -> Result<Picture, BakeError> {
    assert_eq!(scene.objects.len(), bake.objects.len(), "another scene");
    let pyramids = Pyramids::new(scene, None);
    let surfaces = Surfaces::new(scene, &pyramids);
    let hierarchy = Hierarchy::new(scene, &surfaces, Holds::All, BvhQuality::Best);
    let view = View {
        scene,
        occluders: Occluders::new(&hierarchy, &surfaces),
        surfaces: &surfaces,
        light: LightLookup::new(scene, bake),
        culled: (scene.triangles.iter())
            .map(|&t| !scene.material(t).double_sided)
            .collect(),
    };
    let (width, height) = (settings.width, settings.height);
    let camera = settings.camera.clone();
    let camera = camera.unwrap_or_else(|| framing::find(&view, width as f32 / height as f32));
    let lens = Lens::new(scene, &camera, width, height);
    let exposure = settings
        .exposure
        .unwrap_or_else(|| auto_exposure(&view.probe(&lens)));
    let tone = Tone { exposure };
    let rows = map_ranges(height as usize, 4, Stage::Preview, observer, |rows| {
        rows.flat_map(|y| (0..width).map(move |x| (x, y as u32)))
            .map(|(x, y)| encode(view.pixel(&lens, tone, x, y), x, y))
            .collect::<Vec<_>>()
    })?;
    Ok(Picture {
        width,
        height,
        pixels: rows.concat(),
    })
}

/// What a ray shows.
#[derive(Clone, Copy, Debug)]
enum Seen {
    /// A lit surface: light it reflects, and light it emits.
    Surface { reflected: Vec3, emitted: Vec3 },
    /// The sky.
    Sky(Vec3),
    /// A colour that no exposure changes: an unlit material, or nothing.
    Plain(Vec3),
}

/// A scene with its light, ready to be looked at.
struct View<'a> {
    scene: &'a ValidScene,
    occluders: Occluders<'a>,
    surfaces: &'a Surfaces<'a>,
    light: LightLookup<'a>,
    /// Which live triangles do not show their back.
    culled: Vec<bool>,
}

impl View<'_> {
    /// Mean of the tone-mapped samples of a pixel: mapped first, so that the edge of a lamp far
    /// brighter than white is as smooth as any other.
    fn pixel(&self, lens: &Lens, tone: Tone, x: u32, y: u32) -> Vec3 {
        let seed = hash(x, hash(y, 0x91C7));
        let mut sum = Vec3::ZERO;
        for i in 0..SAMPLES {
            let [u, v, ..] = sobol(i, 0, seed);
            // Stratified over the pixel: half-transparent surfaces show without much noise.
            let threshold = (i as f32 + unit_float(seed)) / SAMPLES as f32;
            sum += match self.look(lens, x as f32 + u, y as f32 + v, threshold) {
                Seen::Surface { reflected, emitted } => tone.map(reflected + emitted),
                Seen::Sky(radiance) => tone.map(radiance),
                Seen::Plain(color) => color,
            };
        }
        sum / SAMPLES as f32
    }

    /// Reflected light on a coarse grid over the picture.
    fn probe(&self, lens: &Lens) -> Vec<Vec3> {
        const GRID: u32 = 128;
        let cells = (0..GRID).flat_map(|y| (0..GRID).map(move |x| (x, y)));
        let seen = cells.filter_map(|(x, y)| {
            let [u, v, ..] = sobol(0, 0, hash(x, hash(y, 0x960B)));
            let at =
                |cell: u32, jitter: f32, size: f32| (cell as f32 + jitter) * size / GRID as f32;
            let (x, y) = (at(x, u, lens.width), at(y, v, lens.height));
            match self.look(lens, x, y, 0.5) {
                Seen::Surface { reflected, .. } => Some(reflected),
                Seen::Sky(_) | Seen::Plain(_) => None,
            }
        });
        seen.collect()
    }

    fn look(&self, lens: &Lens, x: f32, y: f32, threshold: f32) -> Seen {
        let (origin, direction) = lens.ray(x, y);
        let Some(hit) = self
            .occluders
            .shown(origin, direction, &self.culled, threshold)
        else {
            return if self.scene.sky == Vec3::ZERO {
                Seen::Plain(tone::backdrop(y / lens.height))
            } else {
                Seen::Sky(self.scene.sky)
            };
        };
        let share = self.footprint(lens, direction, &hit);
        let (base, emitted) = self.surfaces.look(hit.triangle, hit.uv, share);
        let key = self.scene.triangles[hit.triangle as usize];
        if self.scene.material(key).unlit {
            return Seen::Plain(base);
        }
        Seen::Surface {
            reflected: base * self.light.at(key, hit.uv),
            emitted,
        }
    }

    /// Share of the triangle's area that one sample stands for.
    fn footprint(&self, lens: &Lens, direction: Vec3, hit: &Hit) -> f32 {
        let corners @ [a, b, c] = self
            .scene
            .corners(self.scene.triangles[hit.triangle as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        // Seen at a grazing angle a texture would be blurred along both axes: stop early.
        let cosine = normal.dot(direction).abs().max(0.25);
        // Neighbouring samples overlap by half: four of them side by side make a pixel.
        let across = 0.5 * lens.pixel_size(hit.distance);
        across * across / (cosine * area(corners))
    }
}
