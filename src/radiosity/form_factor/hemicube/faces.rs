use std::ops::{Add, Mul, Neg};

/// A face of the hemicube: a picture of a quarter turn to each side, taken from its centre.
///
/// A face's own axes are some of the hemicube's, of which 2 is the normal of the element; which way
/// `right` points does not matter, as the faces are symmetric.
pub(super) struct Face {
    right: usize,
    up: usize,
    forward: usize,
    /// Forward is against the axis.
    against: bool,
}

const fn side(right: usize, forward: usize, against: bool) -> Face {
    Face {
        right,
        up: 2,
        forward,
        against,
    }
}

/// The top, whole, and four sides, from the horizon up.
pub(super) const FACES: [Face; 5] = [
    Face {
        right: 0,
        up: 1,
        forward: 2,
        against: false,
    },
    side(1, 0, false),
    side(1, 0, true),
    side(0, 1, false),
    side(0, 1, true),
];

/// A function of the place in a face, `column · x + row · y + base` at pixel (x, y).
#[derive(Clone, Copy)]
pub(super) struct Linear<T> {
    pub(super) column: T,
    pub(super) row: T,
    pub(super) base: T,
}

impl<T: Copy + Add<Output = T> + Mul<f32, Output = T>> Linear<T> {
    /// Its value at column 0 of a row.
    pub(super) fn at_row(&self, row: usize) -> T {
        self.base + self.row * row as f32
    }
}

impl Face {
    pub(super) fn is_top(&self) -> bool {
        self.forward == 2
    }

    /// Rows of pixels.
    pub(super) fn rows(&self, resolution: usize) -> usize {
        if self.is_top() {
            resolution
        } else {
            resolution / 2
        }
    }

    /// Components along right, up and forward of what has them along the hemicube's axes.
    pub(super) fn turned<T: Copy + Neg<Output = T>>(&self, axes: &[T; 3]) -> [T; 3] {
        let forward = axes[self.forward];
        let forward = if self.against { -forward } else { forward };
        [axes[self.right], axes[self.up], forward]
    }

    /// `d · v` for the direction `d` through each pixel's centre, of `v` along the face's axes.
    ///
    /// With `d = (x, y, 1)`, pixel `i` of a line of `R` lies at `x = (2i + 1)/R − 1`; sides start at
    /// the horizon, `y = (2j + 1)/R`.
    pub(super) fn linear<T>(&self, [right, up, forward]: [T; 3], resolution: usize) -> Linear<T>
    where
        T: Copy + Add<Output = T> + Mul<f32, Output = T>,
    {
        let pixel = 2.0 / resolution as f32;
        let first = 0.5 * pixel - 1.0;
        let lowest = if self.is_top() { first } else { 0.5 * pixel };
        Linear {
            column: right * pixel,
            row: up * pixel,
            base: forward + right * first + up * lowest,
        }
    }

    /// The row of pixels, not rounded, where `up / forward` is `slope`.
    pub(super) fn row_of(&self, slope: f32, resolution: usize) -> f32 {
        let from = if self.is_top() { slope + 1.0 } else { slope };
        0.5 * (resolution as f32 * from - 1.0)
    }
}
