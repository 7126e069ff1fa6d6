use std::collections::HashMap;

use glam::{IVec3, Vec3};

/// Moments of what the elements around a place send, by cells of a grid and by which way they face.
///
/// Elements of any mesh have neighbours here, across edges and objects, and each costs the same,
/// however many there are.
pub(super) struct Surroundings {
    size: f32,
    cells: HashMap<(IVec3, u8), Moments>,
}

/// Sums over elements, weighted by area.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moments {
    area: f64,
    light: f64,
    squares: f64,
    noise: f64,
}

impl Surroundings {
    /// Surroundings of about three times the length `size`.
    pub(super) fn new(size: f32) -> Self {
        Self {
            size,
            cells: HashMap::new(),
        }
    }

    /// Adds an element at a place, that sends `light`, known but for the variance `noise`.
    pub(super) fn add(&mut self, at: (Vec3, Vec3), area: f64, light: f64, noise: f64) {
        let sums = self
            .cells
            .entry((self.cell(at.0), facing(at.1)))
            .or_default();
        sums.area += area;
        sums.light += area * light;
        sums.squares += area * light * light;
        sums.noise += area * noise;
    }

    /// What is known of the elements around a place that face the same way.
    pub(super) fn around(&self, at: (Vec3, Vec3)) -> Moments {
        let (center, facing) = (self.cell(at.0), facing(at.1));
        let mut all = Moments::default();
        for i in 0..27 {
            let step = IVec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
            if let Some(sums) = self.cells.get(&(center + step, facing)) {
                all.area += sums.area;
                all.light += sums.light;
                all.squares += sums.squares;
                all.noise += sums.noise;
            }
        }
        all
    }

    fn cell(&self, at: Vec3) -> IVec3 {
        (at / self.size).floor().as_ivec3()
    }
}

impl Moments {
    /// Variance that chance makes of one element.
    pub(super) fn noise(&self) -> f64 {
        self.noise / self.area.max(f64::MIN_POSITIVE)
    }

    /// By how much light differs around here, beyond what is chance: its standard deviation.
    pub(super) fn difference(&self) -> f64 {
        let area = self.area.max(f64::MIN_POSITIVE);
        let variance = self.squares / area - (self.light / area).powi(2);
        (variance - self.noise()).max(0.0).sqrt()
    }
}

/// Which of six directions a normal is nearest to.
fn facing(normal: Vec3) -> u8 {
    let axis = normal.abs().max_position();
    2 * axis as u8 + u8::from(normal[axis] < 0.0)
}
