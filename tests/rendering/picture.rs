//! A picture in linear colour, and how far two are apart.

use std::path::PathBuf;

/// Linear RGBA, row by row from the top left.
pub(crate) struct Picture {
    pub(crate) size: usize,
    pub(crate) pixels: Vec<[f32; 4]>,
}

impl Picture {
    pub(crate) fn from_bytes(size: usize, bytes: &[u8]) -> Self {
        let floats: Vec<f32> = bytes
            .chunks_exact(4)
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        let pixels: Vec<_> = floats
            .chunks_exact(4)
            .map(|p| [p[0], p[1], p[2], p[3]])
            .collect();
        assert_eq!(pixels.len(), size * size);
        Self { size, pixels }
    }

    /// The pixel at a fraction of width and height.
    pub(crate) fn at(&self, x: f32, y: f32) -> [f32; 3] {
        let index = |v: f32| ((v * self.size as f32) as usize).min(self.size - 1);
        let [r, g, b, _] = self.pixels[index(y) * self.size + index(x)];
        [r, g, b]
    }

    /// Root mean square of the difference in RGB, over that of the other's RGB.
    pub(crate) fn distance(&self, other: &Self) -> f64 {
        let square = |x: f32| f64::from(x) * f64::from(x);
        let (mut difference, mut whole) = (0.0, 0.0);
        for (a, b) in self.pixels.iter().zip(&other.pixels) {
            for channel in 0..3 {
                difference += square(a[channel] - b[channel]);
                whole += square(b[channel]);
            }
        }
        (difference / f64::max(whole, 1e-30)).sqrt()
    }

    /// The greatest difference of two pixels in any channel.
    pub(crate) fn greatest_difference(&self, other: &Self) -> f32 {
        let pairs = self.pixels.iter().zip(&other.pixels);
        pairs
            .flat_map(|(a, b)| (0..4).map(move |c| (a[c] - b[c]).abs()))
            .fold(0.0, f32::max)
    }

    /// Saves it, its brightest value as white, where a failed test's pictures are looked for.
    pub(crate) fn save(&self, name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join("bevy_fresco_rendering");
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join(format!("{}.png", name.replace([' ', '/'], "_")));
        let brightest = self.pixels.iter().flat_map(|p| &p[..3]).copied();
        let brightest = brightest.fold(1e-6, f32::max);
        let bytes = self
            .pixels
            .iter()
            .flat_map(|p| [p[0], p[1], p[2]])
            .map(|v| ((v / brightest).clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0) as u8)
            .collect();
        let size = self.size as u32;
        image::RgbImage::from_raw(size, size, bytes)
            .unwrap()
            .save(&path)
            .unwrap();
        path
    }
}

/// Fails, with both pictures saved, unless they are the same within `limit`.
pub(crate) fn assert_same(name: &str, found: &Picture, expected: &Picture, limit: f64) {
    let distance = found.distance(expected);
    println!("{name}: {:.4} %", 100.0 * distance);
    if std::env::var_os("SAVE_PICTURES").is_some() {
        found.save(&format!("{name} found"));
        expected.save(&format!("{name} expected"));
    }
    if distance >= limit {
        let found = found.save(&format!("{name} found"));
        let expected = expected.save(&format!("{name} expected"));
        panic!("{name}: {distance} apart: {found:?}, {expected:?}");
    }
}
