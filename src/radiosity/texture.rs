use glam::{Vec2, Vec4};

use super::scene::{Texture, Wrap};

/// How the red, green and blue of a texel are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Srgb,
    Linear,
}

/// A texture in linear light with its halved copies, for averages over any area.
pub(crate) struct Pyramid {
    levels: Vec<Level>,
    wrap: [Wrap; 2],
}

struct Level {
    width: usize,
    height: usize,
    texels: Vec<Vec4>,
}

impl Pyramid {
    pub(crate) fn new(texture: &Texture, encoding: Encoding) -> Self {
        let decode: Vec<f32> = (0..=255_u8).map(|byte| decode(byte, encoding)).collect();
        let texels = texture
            .texels
            .iter()
            .map(|&[r, g, b, a]| {
                let [r, g, b] = [r, g, b].map(|byte| decode[usize::from(byte)]);
                Vec4::new(r, g, b, f32::from(a) / 255.0)
            })
            .collect();
        let mut levels = vec![Level {
            width: texture.width as usize,
            height: texture.height as usize,
            texels,
        }];
        while let Some(next) = levels.last().and_then(Level::halved) {
            levels.push(next);
        }
        Self {
            levels,
            wrap: texture.wrap,
        }
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.levels.iter().map(|l| 16 * l.texels.len() as u64).sum()
    }

    /// The mean around `uv` over about `uv_area` (1 is the whole image).
    pub(crate) fn sample(&self, uv: Vec2, uv_area: f32) -> Vec4 {
        // The last level is one texel for the whole image; each level before has half the width.
        let last = (self.levels.len() - 1) as f32;
        let lod = (last + 0.5 * uv_area.log2()).clamp(0.0, last);
        let (fine, blend) = (lod as usize, lod.fract());
        let color = self.levels[fine].bilinear(uv, self.wrap);
        if blend == 0.0 {
            return color;
        }
        color.lerp(self.levels[fine + 1].bilinear(uv, self.wrap), blend)
    }
}

impl Level {
    /// Half the size, each texel the mean of those it covers; `None` for a single texel.
    fn halved(&self) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        // Odd sizes: the last texel of the coarse row also takes the row's odd one.
        let span = |i: usize, coarse: usize, fine: usize| {
            let start = i * fine / coarse;
            start..((i + 1) * fine).div_ceil(coarse).max(start + 1)
        };
        let mut texels = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let (columns, rows) = (span(x, width, self.width), span(y, height, self.height));
                let count = (columns.len() * rows.len()) as f32;
                let sum: Vec4 = rows
                    .flat_map(|r| columns.clone().map(move |c| (r, c)))
                    .map(|(r, c)| self.texels[r * self.width + c])
                    .sum();
                texels.push(sum / count);
            }
        }
        Some(Self {
            width,
            height,
            texels,
        })
    }

    fn bilinear(&self, uv: Vec2, wrap: [Wrap; 2]) -> Vec4 {
        let x = uv.x * self.width as f32 - 0.5;
        let y = uv.y * self.height as f32 - 0.5;
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let column = |i: f32| wrapped(i, self.width, wrap[0]);
        let row = |i: f32| wrapped(i, self.height, wrap[1]) * self.width;
        let (c0, c1, r0, r1) = (column(x0), column(x0 + 1.0), row(y0), row(y0 + 1.0));
        let top = self.texels[r0 + c0].lerp(self.texels[r0 + c1], fx);
        let bottom = self.texels[r1 + c0].lerp(self.texels[r1 + c1], fx);
        top.lerp(bottom, fy)
    }
}

fn wrapped(i: f32, size: usize, wrap: Wrap) -> usize {
    let n = size as i64;
    let i = i as i64;
    let inside = match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Clamp => i.clamp(0, n - 1),
        Wrap::Mirror => {
            let j = i.rem_euclid(2 * n);
            j.min(2 * n - 1 - j)
        }
    };
    inside as usize
}

/// IEC 61966-2-1 for sRGB.
fn decode(byte: u8, encoding: Encoding) -> f32 {
    let c = f32::from(byte) / 255.0;
    match encoding {
        Encoding::Linear => c,
        Encoding::Srgb if c <= 0.040_45 => c / 12.92,
        Encoding::Srgb => ((c + 0.055) / 1.055).powf(2.4),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checker(size: u32) -> Texture {
        let texels = (0..size * size)
            .map(|i| {
                if (i / size + i % size).is_multiple_of(2) {
                    [255; 4]
                } else {
                    [0, 0, 0, 255]
                }
            })
            .collect();
        Texture {
            width: size,
            height: size,
            texels,
            ..Texture::default()
        }
    }

    #[test]
    fn averages_are_of_light_not_of_bytes() {
        let pyramid = Pyramid::new(&checker(8), Encoding::Srgb);
        let mean = pyramid.sample(Vec2::new(0.3, 0.7), 1.0);
        assert!((mean.x - 0.5).abs() < 1e-6, "{mean}");
    }

    #[test]
    fn texel_centres_are_exact() {
        let pyramid = Pyramid::new(&checker(4), Encoding::Linear);
        assert_eq!(pyramid.sample(Vec2::splat(0.125), 0.0).x, 1.0);
        assert_eq!(pyramid.sample(Vec2::new(0.375, 0.125), 0.0).x, 0.0);
    }

    #[test]
    fn wrapping_continues_the_image() {
        assert_eq!(
            [-1.0, 0.0, 4.0].map(|i| wrapped(i, 4, Wrap::Repeat)),
            [3, 0, 0]
        );
        assert_eq!(
            [-1.0, 4.0, 5.0].map(|i| wrapped(i, 4, Wrap::Mirror)),
            [0, 3, 2]
        );
        assert_eq!([-1.0, 4.0].map(|i| wrapped(i, 4, Wrap::Clamp)), [0, 3]);
        for far in [f32::MAX, f32::MIN, 1e20] {
            assert!(wrapped(far, 5, Wrap::Mirror) < 5);
        }
    }

    #[test]
    fn odd_sizes_keep_their_mean() {
        let texture = Texture {
            width: 3,
            height: 1,
            texels: vec![[255; 4], [0; 4], [255; 4]],
            ..Texture::default()
        };
        let mean = Pyramid::new(&texture, Encoding::Linear).sample(Vec2::splat(0.5), 1.0);
        assert!((mean.x - 2.0 / 3.0).abs() < 1e-6);
    }
}
