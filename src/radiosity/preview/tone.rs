use glam::Vec3;

use crate::radiosity::color::luminance;

/// From radiance to the 0..1 of a picture, still linear.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tone {
    /// Factor from cd/m² to the 0..1 of the picture.
    pub(super) exposure: f32,
}

/// Where highlights begin to be compressed, and how fast they lose their colour.
const START: f32 = 0.8;
const DESATURATION: f32 = 0.15;

impl Tone {
    /// Khronos PBR Neutral (<https://github.com/KhronosGroup/ToneMapping>): leaves what is below
    /// 0.8 as it is, so that base colours look as they were painted, and compresses the rest with
    /// its hue kept. Its first step takes away the 4 % that a specular layer adds; there is none
    /// here, so that is left out.
    pub(super) fn map(self, radiance: Vec3) -> Vec3 {
        let color = radiance * self.exposure;
        let peak = color.max_element();
        if peak < START {
            return color;
        }
        let room = 1.0 - START;
        let new_peak = 1.0 - room * room / (peak + room - START);
        let blend = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
        (color * (new_peak / peak)).lerp(Vec3::splat(new_peak), blend)
    }
}

/// An exposure at which a picture of this reflected light shows well.
///
/// The log-average becomes a mid grey (Reinhard et al. 2002, "Photographic Tone Reproduction for
/// Digital Images"), but a picture that is mostly shade does not burn out what is lit, and an
/// even one is not all grey.
pub(super) fn auto_exposure(reflected: &[Vec3]) -> f32 {
    const MID_GREY: f32 = 0.2;
    const WHITE: f32 = 0.55;
    const BRIGHT: f32 = 1.6;
    let mut lit: Vec<f32> = reflected
        .iter()
        .map(|&color| luminance(color))
        .filter(|&l| l > 0.0 && l.is_finite())
        .collect();
    if lit.is_empty() {
        return 1.0;
    }
    lit.sort_by(f32::total_cmp);
    let bright = lit[(lit.len() - 1) * 98 / 100];
    // Black corners would pull the average down without end.
    let floor = 1e-3 * bright;
    let logs: f64 = lit.iter().map(|&l| f64::from(l.max(floor)).ln()).sum();
    let average = (logs / lit.len() as f64).exp() as f32;
    (MID_GREY / average).clamp(WHITE / bright, BRIGHT / bright)
}

/// What is behind a scene without a sky: dark, a little lighter below. `down` is 0 at the top of
/// the picture and 1 at the bottom.
pub(super) fn backdrop(down: f32) -> Vec3 {
    Vec3::new(0.95, 1.0, 1.1) * (0.010 + 0.022 * down)
}

/// To 8-bit sRGB, with an ordered dither (Bayer 1973) that hides the steps in smooth shades.
pub(super) fn encode(color: Vec3, x: u32, y: u32) -> [u8; 3] {
    let threshold = bayer(x, y);
    color.to_array().map(|c| {
        let c = c.clamp(0.0, 1.0);
        let encoded = if c <= 0.003_130_8 {
            12.92 * c
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        };
        (encoded * 255.0 + threshold) as u8
    })
}

/// Threshold of an 8 × 8 Bayer matrix, in 0..1.
fn bayer(x: u32, y: u32) -> f32 {
    let mut value = 0;
    for bit in 0..3 {
        let (x, y) = ((x >> bit) & 1, (y >> bit) & 1);
        value = value << 2 | ((x ^ y) << 1) | y;
    }
    (value as f32 + 0.5) / 64.0
}

/// Relative brightness 0..1 of a light value beside the mean of a scene.
pub(super) fn brightness(light: Vec3, mean: f64) -> f64 {
    let light = f64::from(luminance(light));
    if mean > 0.0 {
        light / (light + 0.2 * mean)
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tone_map_is_continuous_monotonic_and_below_one() {
        let tone = Tone { exposure: 1.0 };
        let mut last = 0.0;
        for i in 1..2000 {
            let mapped = tone.map(Vec3::splat(i as f32 * 0.01)).x;
            assert!(mapped > last && mapped < 1.0 && mapped - last < 0.0101);
            last = mapped;
        }
        let red = tone.map(Vec3::new(2.0, 0.2, 0.2));
        assert!(red.x > 2.0 * red.y, "{red}");
    }

    #[test]
    fn dither_keeps_the_mean_and_exact_values() {
        let mean = |c: f32| {
            let cells = (0..8).flat_map(|y| (0..8).map(move |x| (x, y)));
            let sum: u32 = cells
                .map(|(x, y)| u32::from(encode(Vec3::splat(c), x, y)[0]))
                .sum();
            sum as f32 / 64.0
        };
        assert_eq!((mean(0.0), mean(1.0)), (0.0, 255.0));
        // sRGB of 0.2 is 123.555.
        assert!((mean(0.2) - 123.555).abs() < 0.02, "{}", mean(0.2));
    }

    #[test]
    fn exposure_follows_the_light() {
        let dim = auto_exposure(&[Vec3::splat(0.5); 100]);
        let bright = auto_exposure(&[Vec3::splat(50.0); 100]);
        assert!((dim / bright - 100.0).abs() < 0.1);
        assert_eq!(auto_exposure(&[]), 1.0);
    }
}
