use super::components::components;
use super::low_pass::low_pass;
use super::{HeightMap, Warning};

/// Blocks along the shorter side in which the level of matte light is looked for. Fewer than half of a
/// block's texels may be highlights.
const BLOCKS: usize = 4;

/// A highlight is where gloss adds this share of the matte light, or more.
const ADDED: f32 = 0.5;

/// How far above the median of logarithms no matte texel is, in distances from the median to the quartile.
const FENCE: f32 = 4.0;

/// Smaller spots are noise.
const SMALLEST: usize = 16;

/// Less of a photo than this share is as likely to be something white, and not told.
const TOLD: f64 = 0.001;

/// Highlights fade out over some texels; the border of what is painted is sharp. Share of its light that a
/// spot loses in the two texels across a sharp border.
const SHARP: f32 = 0.55;

/// Luminance at the end of what a camera tells apart: little that is painted is as bright, so a spot with a
/// tenth of its texels up there may be sharp.
const DAZZLING: f32 = 0.97;

/// Photos of less saturation count as grey.
const COLOURED: f32 = 0.25;

/// Where gloss mirrors the lamp.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Highlights {
    /// Which texels.
    pub(super) mask: Vec<bool>,
    /// What to say about them.
    pub(super) warning: Warning,
}

/// Finds light that no matte surface could have sent: spots where gloss adds half of the matte light or
/// more, that are brighter than the rest, and that begin gradually.
///
/// How much of the light is matte is told by its colour where there is one: gloss sends the lamp's light
/// as it is (S. A. Shafer, "Using color to separate reflection components", 1985). In photos without
/// colour it is told by the brightness of the surroundings.
pub(super) fn highlights(
    luminance: &HeightMap,
    colours: Option<&[[f32; 3]]>,
) -> Option<Highlights> {
    let smooth = luminance.with_heights(low_pass(luminance, 1.0));
    let level = matte_level(&smooth);
    let mut logs: Vec<f32> = (smooth.heights().iter().zip(&level))
        .map(|(&light, &level)| (light.max(1e-3 * level) / level).ln())
        .collect();
    let brightness = logs.clone();
    // The darker half is all matte, and the brighter half would be its mirror image.
    let [lower, median] = [0.25, 0.5].map(|share| quantile(&mut logs, share));
    let upper = 2.0 * median - lower;
    let fence = (median + FENCE * (median - lower)).max(upper + (1.0 + ADDED).ln());

    let by_colour = colours.and_then(|colours| matte_by_colour(luminance, &smooth, colours));
    let matte = by_colour.unwrap_or_else(|| level.iter().map(|l| l * upper.exp()).collect());
    let glossy: Vec<bool> = (smooth.heights().iter().zip(&matte))
        .map(|(&light, &matte)| light > (1.0 + ADDED) * matte)
        .collect();
    let mut spots = components(luminance, &glossy);
    spots.retain(|spot| {
        spot.len() >= SMALLEST
            && spot.iter().any(|&i| brightness[i] > fence)
            && (is_dazzling(luminance, spot) || !is_painted(luminance, &matte, &glossy, spot))
    });
    let largest = spots.iter().max_by_key(|spot| spot.len())?;
    let mut mask = vec![false; glossy.len()];
    spots.iter().flatten().for_each(|&i| mask[i] = true);
    let count: usize = spots.iter().map(Vec::len).sum();
    let share = count as f64 / mask.len() as f64;
    (share >= TOLD).then(|| Highlights {
        warning: Warning::Highlights {
            share,
            at: middle(largest, &smooth),
        },
        mask,
    })
}

/// Luminance without what is white in it and is not in most of the photo; `None` for photos without colour.
///
/// With `ρ` the least of the matte light's channels by their mean, and gloss that adds `s` to each,
///
/// ```text
///   mean = d + s     least = ρ d + s            s = (least − ρ mean) / (1 − ρ)
/// ```
fn matte_by_colour(
    luminance: &HeightMap,
    smooth: &HeightMap,
    colours: &[[f32; 3]],
) -> Option<Vec<f32>> {
    let channels = [0, 1, 2].map(|k| {
        let channel = luminance.with_heights(colours.iter().map(|c| c[k]).collect());
        low_pass(&channel, 1.0)
    });
    let ends = (0..colours.len()).map(|i| {
        let [r, g, b] = [0, 1, 2].map(|k| channels[k][i].max(0.0));
        [r.min(g).min(b), (r + g + b) / 3.0]
    });
    let ends: Vec<[f32; 2]> = ends.collect();
    let share = |[least, mean]: &[f32; 2]| if *mean > 0.0 { least / mean } else { 1.0 };
    let usual = quantile(&mut ends.iter().map(share).collect::<Vec<_>>(), 0.5);
    if usual > 1.0 - COLOURED {
        return None;
    }
    let matte = ends
        .iter()
        .zip(smooth.heights())
        .map(|([least, mean], light)| {
            let gloss = (least - usual * mean) / (1.0 - usual);
            light - gloss.max(0.0)
        });
    Some(matte.collect())
}

/// Median luminance of blocks, above 0, and between their centres by bilinear interpolation.
fn matte_level(luminance: &HeightMap) -> Vec<f32> {
    let [width, height] = luminance.size().map(|n| n as usize);
    let side = (width.min(height) / BLOCKS).max(1);
    let blocks = [width.div_ceil(side), height.div_ceil(side)];
    let mut levels = Vec::new();
    for v in 0..blocks[1] {
        for u in 0..blocks[0] {
            let rows = v * side..((v + 1) * side).min(height);
            let columns = u * side..((u + 1) * side).min(width);
            let texels = rows.flat_map(|y| columns.clone().map(move |x| y * width + x));
            let mut light: Vec<f32> = texels.map(|i| luminance.heights()[i]).collect();
            levels.push(quantile(&mut light, 0.5).max(1e-6));
        }
    }
    let between = |i: usize, n: usize| {
        let at = ((i as f32 + 0.5) / side as f32 - 0.5).clamp(0.0, (n - 1) as f32);
        let first = (at as usize).min(n.saturating_sub(2));
        (first, (first + 1).min(n - 1), at - first as f32)
    };
    let level = |i: usize| {
        let (u0, u1, s) = between(i % width, blocks[0]);
        let (v0, v1, t) = between(i / width, blocks[1]);
        let row = |v: usize| {
            let [a, b] = [levels[v * blocks[0] + u0], levels[v * blocks[0] + u1]];
            a + s * (b - a)
        };
        row(v0) + t * (row(v1) - row(v0))
    };
    (0..width * height).map(level).collect()
}

fn is_dazzling(luminance: &HeightMap, spot: &[usize]) -> bool {
    let light = luminance.heights();
    let dazzling = spot.iter().filter(|&&i| light[i] > DAZZLING).count();
    10 * dazzling > spot.len()
}

/// Whether a spot begins at a sharp border: whether light falls off there at once, beside what it is some
/// texels inside.
fn is_painted(luminance: &HeightMap, matte: &[f32], glossy: &[bool], spot: &[usize]) -> bool {
    let [width, height] = luminance.size().map(i64::from);
    let excess = |x: i64, y: i64| {
        let i = luminance.index(x.clamp(0, width - 1), y.clamp(0, height - 1));
        luminance.heights()[i] - matte[i]
    };
    let (mut fall, mut inside) = (0.0, 0.0);
    for &i in spot {
        let (x, y) = (i as i64 % width, i as i64 / width);
        for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
            let within = (0..width).contains(&(x + dx)) && (0..height).contains(&(y + dy));
            if within && !glossy[luminance.index(x + dx, y + dy)] {
                fall += excess(x - dx, y - dy) - excess(x + dx, y + dy);
                inside += excess(x - 3 * dx, y - 3 * dy).max(excess(x, y));
            }
        }
    }
    fall > SHARP * inside
}

fn quantile(values: &mut [f32], share: f64) -> f32 {
    let at = (share * (values.len() - 1) as f64).round() as usize;
    *values.select_nth_unstable_by(at, f32::total_cmp).1
}

/// A texel of a spot near its centre of mass.
fn middle(spot: &[usize], map: &HeightMap) -> [u32; 2] {
    let width = map.size()[0] as usize;
    let place = |i: usize| [(i % width) as f64, (i / width) as f64];
    let mut centre = [0.0; 2];
    for &i in spot {
        let p = place(i);
        centre = [0, 1].map(|k| centre[k] + p[k] / spot.len() as f64);
    }
    let far = |&&i: &&usize| {
        let p = place(i);
        ((p[0] - centre[0]).powi(2) + (p[1] - centre[1]).powi(2)) as u64
    };
    let nearest = spot.iter().min_by_key(far).copied().unwrap_or_default();
    [(nearest % width) as u32, (nearest / width) as u32]
}
