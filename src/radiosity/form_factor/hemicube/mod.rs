//! Form factors by hemicube (Cohen and Greenberg 1985, "The Hemi-Cube: A Radiosity Solution for
//! Complex Environments").
//!
//! The share of a point's view that a surface fills is its form factor from the point. By Nusselt's
//! analogy, what covers it in any picture has the same: so the scene is drawn with a z-buffer onto
//! the five faces of half a cube around the point, and the weights of the pixels that show the
//! surface are added.
//!
//! ```text
//!          ┌───────────┐        F_ej = Σ ΔF_p over pixels p that show j
//!         ╱  │ top    ╱│
//!        ╱   n       ╱ │        R × R pixels on the top, R × R/2 on each side
//!       ┌────┼──────┐ ─ ─
//!       │    ·      │ ╱   horizon
//!  ─────└───────────┘──── element
//! ```
//!
//! What is drawn are the input triangles, whatever the number of elements on them; which element a
//! pixel shows follows from where its ray meets the triangle. So a row costs five pictures of the
//! scene: less than rays for a few hundred triangles, more for thousands.
//!
//! Back faces are drawn. A surface of one side is black from behind, and stops light: without its
//! back, floor under a block that stands on it would look out through the block.
//!
//! What to expect of it:
//! - Pixels are a regular pattern, so errors are aliasing and not noise: what is smaller than a
//!   pixel is found or missed as a whole. Each hemicube is turned by an angle of its own, so that at
//!   least neighbours do not err alike.
//! - It looks from one point, the centre, where form factors are means over the element. What is
//!   nearer than the size of the element is found in closed form (see `near`); what is half hidden
//!   from the element is hidden or not. Large elements that touch others' edges are its weakness,
//!   and smaller elements the cure.
//!
//! | file | |
//! |---|---|
//! | `delta` | the weights of pixels |
//! | `faces` | the five faces and their axes |
//! | `eye` | where a hemicube stands, and triangles as seen from there |
//! | `raster` | z-buffer and item buffer |
//! | `places` | which point of a triangle a pixel shows |
//! | `shares` | from pixels to elements |
//! | `near` | what is too near to be judged from one point |

mod delta;
mod eye;
mod faces;
mod near;
mod places;
mod raster;
mod shares;
#[cfg(test)]
mod tests;

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use crate::radiosity::element::ElementId;
use crate::radiosity::observer::{Observer, Stage};
use crate::radiosity::parallel::{Cancelled, map_ranges};
use crate::radiosity::report::FormFactorReport;
use crate::radiosity::sampling::hash;

use super::View;
use super::matrix::{Matrix, Row};
use super::traced::Traced;
use delta::DeltaFormFactors;
use eye::{Eye, Facet, Seen};
use faces::{FACES, Face};
use near::{Mended, NearPairs};
use places::Places;
use raster::Picture;
use shares::Shares;

/// Draws the scene from elements.
pub(crate) struct Hemicube<'a> {
    view: View<'a>,
    resolution: usize,
    deltas: DeltaFormFactors,
    /// Triangles that stop light, those first that win where several are at one place.
    facets: Vec<Facet>,
    near: NearPairs<'a>,
    /// Buffers that no thread uses.
    spare: Mutex<Vec<Buffers>>,
    /// Leaves out back faces: to show why not to.
    #[cfg(test)]
    culled: bool,
}

/// What a thread draws on.
struct Buffers {
    /// Triangles above the horizon.
    seen: Vec<Seen>,
    picture: Picture,
    shares: Shares,
}

impl<'a> Hemicube<'a> {
    /// `resolution` is the number of pixels along an edge of the top, even.
    pub(super) fn new(view: View<'a>, resolution: u32) -> Self {
        let casting = |&t: &u32| view.scene.casts(view.scene.triangles[t as usize]);
        let mut order: Vec<u32> = (0..view.scene.triangles.len() as u32)
            .filter(casting)
            .collect();
        order.sort_unstable_by_key(|&t| (view.occluders.name(t), t));
        Self {
            view,
            resolution: resolution as usize,
            deltas: DeltaFormFactors::new(resolution as usize),
            facets: order.iter().map(|&t| Facet::new(&view, t)).collect(),
            near: NearPairs::new(view),
            spare: Mutex::default(),
            #[cfg(test)]
            culled: false,
        }
    }

    /// The form factors from one element.
    pub(super) fn one(&self, e: usize) -> Row {
        let mut rows = self.rows(e..e + 1);
        rows.pop().map(|r| r.0).unwrap_or_default()
    }

    /// The form factors from some elements, and what became of them.
    fn rows(&self, elements: Range<usize>) -> Vec<(Row, Mended)> {
        let spare = || self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        let taken = spare().pop();
        let mut buffers = taken.unwrap_or_else(|| self.buffers());
        let rows = elements.map(|e| self.row(e, &mut buffers)).collect();
        spare().push(buffers);
        rows
    }

    fn buffers(&self) -> Buffers {
        Buffers {
            seen: Vec::new(),
            picture: Picture::new(self.resolution),
            shares: Shares::new(self.view.elements.len(), self.resolution),
        }
    }

    /// The form factors from element `e`.
    fn row(&self, e: usize, buffers: &mut Buffers) -> (Row, Mended) {
        let mut row = self.point_row(e, buffers);
        let mended = self.near.mend(e, &mut row);
        (row, mended)
    }

    /// The form factors from a point of element `e`.
    fn point_row(&self, e: usize, buffers: &mut Buffers) -> Row {
        self.look(e, buffers);
        for (index, face) in FACES.iter().enumerate() {
            buffers.picture.clear();
            self.draw(e, index, face, buffers);
            buffers.shares.add(
                face,
                &buffers.picture,
                &buffers.seen,
                &self.deltas,
                self.view.elements,
            );
        }
        buffers.shares.take()
    }

    /// Finds the triangles above the horizon of element `e`.
    fn look(&self, e: usize, buffers: &mut Buffers) {
        let eye = Eye::new(&self.view, ElementId(e as u32));
        buffers.seen.clear();
        let seen = self.facets.iter().filter_map(|facet| eye.see(facet));
        buffers.seen.extend(seen);
        #[cfg(test)]
        buffers.seen.retain(|s| !(self.culled && s.back));
    }

    fn draw(&self, e: usize, index: usize, face: &Face, buffers: &mut Buffers) {
        let seed = self
            .view
            .elements
            .seed(ElementId(e as u32), self.view.settings.seed);
        let Buffers { seen, picture, .. } = buffers;
        for (seen, item) in seen.iter().zip(0..) {
            if !seen.transmits {
                picture.draw(face, seen, item);
                continue;
            }
            // A ray through each pixel passes or not, as rays do.
            let edges = Places::edges(seen, face, self.resolution);
            picture.draw_in_part(face, seen, item, |row, column| {
                let pixel = (index * self.resolution + row) * self.resolution + column;
                let uv = Places::new(seen, &edges, row).uv(column);
                let ray = hash(seed, pixel as u32);
                !self.view.occluders.passes(seen.triangle, uv, ray)
            });
        }
    }
}

/// Elements a thread takes at a time: a few milliseconds' work.
const CHUNK: usize = 32;

/// The form factors of all elements.
pub(crate) fn rows(
    view: &View,
    resolution: u32,
    observer: &dyn Observer,
) -> Result<Traced, Cancelled> {
    let hemicube = Hemicube::new(*view, resolution);
    let count = view.elements.len();
    let chunks = map_ranges(count, CHUNK, Stage::FormFactors, observer, |range| {
        let rows = hemicube.rows(range).into_iter();
        let kept = rows.map(|(row, mended)| (row.sky, row.packed(count), mended));
        kept.collect::<Vec<_>>()
    })?;
    let mut report = FormFactorReport::default();
    let (mut rows, mut skies) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for (sky, row, mended) in chunks.into_iter().flatten() {
        report.largest_row_sum = report.largest_row_sum.max(row.sum());
        report.near_pairs += mended.near_pairs;
        report.scaled_rows += u64::from(mended.scaled);
        rows.push(row);
        skies.push(sky);
    }
    Ok(Traced::of_matrix(Matrix::Rows(rows), skies, report))
}
