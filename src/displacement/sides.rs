use super::surface::{Sheet, Surface};

/// A side of a triangle: the places at its ends, the part, the vertices there, the lower place first; then which
/// triangle, and which of its sides.
pub(super) type Side = ([u32; 2], u32, [u32; 2], u32, u8);

/// Sides of all triangles, those at one edge beside each other, those with the same vertices within.
pub(super) fn sides(surface: &Surface) -> Vec<Side> {
    let mut sides = Vec::new();
    for (part, sheet) in (0..).zip(&surface.sheets) {
        for (triangle, corners) in sheet.triangles.iter().enumerate() {
            for side in 0..3 {
                let mut ends = [corners[side], corners[(side + 1) % 3]];
                if !goes_up(sheet, triangle, side) {
                    ends.swap(0, 1);
                }
                let places = ends.map(|v| sheet.places[v as usize]);
                sides.push((places, part, ends, triangle as u32, side as u8));
            }
        }
    }
    sides.sort_unstable();
    sides
}

/// Whether a side goes from the lower place to the higher.
pub(super) fn goes_up(sheet: &Sheet, triangle: usize, side: usize) -> bool {
    let corners = sheet.triangles[triangle];
    let [a, b] = [corners[side], corners[(side + 1) % 3]];
    let [p, q] = [a, b].map(|v| sheet.places[v as usize]);
    (p, a) <= (q, b)
}

/// Which sides of the triangles of each part are seams: others at the same edge have vertices of their own.
pub(super) fn seams(surface: &Surface) -> Vec<Vec<[bool; 3]>> {
    let mut seams: Vec<Vec<[bool; 3]>> = (surface.sheets.iter())
        .map(|sheet| vec![[false; 3]; sheet.triangles.len()])
        .collect();
    let sides = sides(surface);
    for edge in sides.chunk_by(|a, b| a.0 == b.0) {
        let (first, last) = (edge[0], edge[edge.len() - 1]);
        let seam = (first.1, first.2) != (last.1, last.2);
        for &(_, part, _, triangle, side) in edge {
            seams[part as usize][triangle as usize][usize::from(side)] = seam;
        }
    }
    seams
}
