/// Values of which the largest is wanted again and again, while a few change in between.
///
/// They stand in blocks of about √n, and each block knows its largest: finding the largest of all
/// is √n steps over the blocks, a value that grows changes one number more, and a block is only
/// looked through again when its largest shrinks. For shooting, where a hundred values grow for
/// each that falls, that takes a third of the time of looking at all 8,000, and half of a heap's.
pub(super) struct Largest {
    values: Vec<f32>,
    block: usize,
    of_block: Vec<f32>,
}

impl Largest {
    pub(super) fn new(values: Vec<f32>) -> Self {
        let block = values.len().isqrt().max(1);
        let of_block = values.chunks(block).map(most).collect();
        Self {
            values,
            block,
            of_block,
        }
    }

    pub(super) fn set(&mut self, i: usize, value: f32) {
        let b = i / self.block;
        let old = std::mem::replace(&mut self.values[i], value);
        if value >= self.of_block[b] {
            self.of_block[b] = value;
        } else if old == self.of_block[b] {
            let start = b * self.block;
            let end = (start + self.block).min(self.values.len());
            self.of_block[b] = most(&self.values[start..end]);
        }
    }

    /// The first of the largest, if it is above 0.
    pub(super) fn index(&self) -> Option<usize> {
        let top = most(&self.of_block);
        let b = self.of_block.iter().position(|&m| m == top && m > 0.0)?;
        let start = b * self.block;
        let within = self.values[start..].iter().position(|&v| v == top)?;
        Some(start + within)
    }
}

fn most(values: &[f32]) -> f32 {
    values.iter().copied().fold(0.0, f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiosity::sampling::{hash, unit_float};

    #[test]
    fn the_largest_is_that_of_a_full_look() {
        for n in [1_u32, 2, 10, 300] {
            let mut values: Vec<f32> = (0..n).map(|i| unit_float(hash(i, n))).collect();
            let mut largest = Largest::new(values.clone());
            for step in 0..2000 {
                let top = largest.index().unwrap();
                assert_eq!(values[top], most(&values), "n {n}, step {step}");
                // The largest falls, others move either way.
                for (i, seed) in [
                    (top as u32, 1),
                    (hash(step, 2) % n, 3),
                    (hash(step, 4) % n, 5),
                ] {
                    let value = unit_float(hash(step, seed)) * values[i as usize].max(0.1);
                    values[i as usize] = value;
                    largest.set(i as usize, value);
                }
            }
        }
        assert_eq!(Largest::new(vec![0.0; 5]).index(), None);
        assert_eq!(Largest::new(Vec::new()).index(), None);
    }
}
