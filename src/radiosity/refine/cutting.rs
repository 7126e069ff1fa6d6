use std::collections::BTreeSet;

use super::face::FaceLight;
use super::step::Step;
use super::work::Work;
use crate::mesh::{Bisected, Bisection, Limits};

/// Each round cuts faces that have this share of the error together.
const BULK: f64 = 0.6;

/// A vertex is at the end of a step if it is nearer than this share of the step's width.
const AT_VERTEX: f32 = 0.5;

impl Work<'_> {
    /// Bisects a face and hands its samples on.
    fn bisect(&mut self, face: u32, limits: &Limits) -> Bisected {
        let told = &mut hand_on(&mut self.faces, &mut self.stale);
        self.conforming.bisect(face, limits, told)
    }

    /// Cuts a face along a step of light: at either end of it, the one far from the lone corner first, so
    /// that no new edge crosses the step.
    ///
    /// ```text
    ///         /\                 /\                 /\
    ///        /  \               /  \               /__\    two rows of vertices,
    ///    ---/----\--- step     /    \             /_/__\   the step between them
    ///      /      \           /______\           /______\
    ///     /        \         /   __.-'\         /   __.-'\
    ///    /__________\       /_.-'______\       /_.-'______\
    /// ```
    ///
    /// An end that a vertex is at already is not cut.
    fn follow(&mut self, mut face: u32, step: Step, limits: &Limits) -> Bisected {
        let mut outcome = Bisected::Refused;
        // What is left of the two edges, beside all of them.
        let mut left = [1.0_f32; 2];
        for (end, edge) in [(1, 0), (1, 1), (0, 0), (0, 1)] {
            let [low, high] = step.ends[edge];
            let at = step.ends[edge][end];
            if at.min(left[edge] - at) < AT_VERTEX * (high - low) {
                continue;
            }
            let share = at / left[edge];
            let lone = step.lone;
            let mut cut_off = face;
            let told = &mut hand_on(&mut self.faces, &mut self.stale);
            let told = &mut |cut: Bisection| {
                told(cut);
                // An edge that ends at the lone corner leaves it to the other piece.
                if cut.face == face && edge == 1 {
                    cut_off = cut.half;
                }
            };
            let cut = match edge {
                0 => (self.conforming).cut_edge((face, lone), share, limits, told),
                _ => (self.conforming).cut_edge((face, (lone + 2) % 3), 1.0 - share, limits, told),
            };
            match cut {
                Bisected::Done => (outcome, left[edge], face) = (Bisected::Done, at, cut_off),
                Bisected::Refused => {}
                Bisected::Full => return Bisected::Full,
            }
        }
        outcome
    }

    /// Cuts what is longer than the longest edge allowed. Whether there was room.
    pub(super) fn cut_long_edges(&mut self, limits: &Limits) -> bool {
        let mut face = 0;
        while face < self.conforming.faces() {
            let [a, b, c] = self.conforming.corners(face);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            if longest > self.refiner.max_edge {
                match self.bisect(face, limits) {
                    Bisected::Done => continue,
                    Bisected::Full => return false,
                    Bisected::Refused => {}
                }
            }
            face += 1;
        }
        true
    }

    /// Cuts the worst faces. Whether there was room.
    pub(super) fn cut_worst(&mut self, limits: &Limits) -> bool {
        let mut worst: Vec<(u32, f64)> = (0..)
            .zip(self.errors.iter().copied())
            .filter(|(_, error)| *error > 0.0)
            .collect();
        worst.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let all: f64 = worst.iter().map(|(_, error)| error).sum();
        let mut cut = 0.0;
        for (face, error) in worst {
            if cut >= BULK * all {
                break;
            }
            if self.stale.contains(&face) {
                cut += error;
                continue;
            }
            let followed = match self.faces[face as usize].step {
                Some(step) => self.follow(face, step, limits),
                None => Bisected::Refused,
            };
            let bisected = match followed {
                Bisected::Refused => self.bisect(face, limits),
                done => done,
            };
            match bisected {
                Bisected::Done => cut += error,
                Bisected::Refused => {}
                Bisected::Full => return false,
            }
        }
        true
    }
}

/// Hands the samples of faces that are cut on to their pieces, and tells which are others now.
fn hand_on(faces: &mut Vec<FaceLight>, changed: &mut BTreeSet<u32>) -> impl FnMut(Bisection) {
    |cut| {
        let half = faces[cut.face as usize].split(&cut);
        faces.push(half);
        changed.extend([cut.face, cut.half]);
    }
}
