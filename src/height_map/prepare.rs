use thiserror::Error;

use super::albedo::albedo_edges;
use super::border::not_tiling;
use super::contrast::{Stretch, invert, stretch};
use super::dequantize::dequantize;
use super::highlights::highlights;
use super::low_pass::low_pass;
use super::{HeightMap, Photo, Precision, Raster, RasterError, Warning, Wrap};

/// Shares of texels at an end of the range from which on they are told.
const CLIPPED: f64 = 0.005;

/// What is done to an image on its way to a height map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrepareSettings {
    /// How the map is to go on beyond its border: whatever looks at neighbours goes on there in the same
    /// way. Most photos do not tile.
    pub wrap: [Wrap; 2],
    /// Whether the steps of 8-bit images are taken off. Nothing moves by more than half of one; finer
    /// images stay as they are.
    pub dequantize: bool,
    /// Takes shading out that is broader than a window of this standard deviation, in texels: photos are
    /// divided by it, heights lose it. Limits: above 0.
    pub flatten: Option<f32>,
    /// Smooths with a window of this standard deviation, in texels. Limits: above 0.
    pub smooth: Option<f32>,
    /// Whether dark is high.
    pub invert: bool,
    /// How heights are brought to 0..1.
    pub stretch: Stretch,
}

impl Default for PrepareSettings {
    /// Nothing but stretched contrast, for an image that does not tile.
    fn default() -> Self {
        Self {
            wrap: [Wrap::Clamp; 2],
            dequantize: false,
            flatten: None,
            smooth: None,
            invert: false,
            stretch: Stretch::Full,
        }
    }
}

/// Settings that mean nothing.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum PrepareError {
    /// A window without width.
    #[error("{what} over {sigma} texels: give a width above 0")]
    Width {
        /// What the window is for.
        what: &'static str,
        /// Its standard deviation.
        sigma: f32,
    },
    /// Nothing would be left.
    #[error("leaving out {0} % at either end: give a share above 0 and below 50")]
    Percentile(f32),
    /// The image holds no heights.
    #[error(transparent)]
    Raster(#[from] RasterError),
}

/// A map, and what is to be said about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// The heights.
    pub map: HeightMap,
    /// Which texels of the photo are highlights, if any are.
    pub highlights: Option<Vec<bool>>,
    /// What to know before using it.
    pub warnings: Vec<Warning>,
}

/// A height map from a photo: bright is high.
///
/// # Errors
///
/// If a setting is outside its limits.
pub fn prepare(photo: &Photo, settings: &PrepareSettings) -> Result<Prepared, PrepareError> {
    settings.check()?;
    let grey = HeightMap::new(photo.size(), photo.luminance(), settings.wrap)
        .expect("a raster has as many finite texels as its size says");
    let colours = photo.raster().has_colour().then(|| photo.linear());
    let bounds = photo.bounds().filter(|_| settings.dequantize);

    let mut warnings = warnings_of(photo.raster(), settings);
    let highlights = highlights(&grey, colours.as_deref());
    warnings.extend(highlights.as_ref().map(|found| found.warning));
    let mask = highlights.as_ref().map(|found| found.mask.as_slice());
    warnings.extend(albedo_edges(&grey, colours.as_deref(), mask));

    let map = smooth_out(grey, bounds.as_deref(), settings);
    let map = match settings.flatten {
        Some(sigma) => divided(&map, &low_pass(&map, sigma)),
        None => map,
    };
    let map = finish(map, settings, &mut warnings);
    Ok(Prepared {
        map,
        highlights: highlights.map(|found| found.mask),
        warnings,
    })
}

/// A height map from an image of heights. Its numbers are taken as they are: nothing is decoded, and
/// whole numbers become 0 to 1.
///
/// # Errors
///
/// If the image has colours, or a setting is outside its limits.
pub fn prepare_data(data: &Raster, settings: &PrepareSettings) -> Result<Prepared, PrepareError> {
    settings.check()?;
    let heights = data.one_channel(0.0)?;
    let map = HeightMap::new(data.size(), heights, settings.wrap)
        .expect("a raster has as many finite texels as its size says");
    let bounds = match settings.dequantize && data.precision() == Precision::Eight {
        true => {
            let (low, high) = (data.one_channel(-0.5)?, data.one_channel(0.5)?);
            // Black and white stay the ends of the range.
            let inside = |(l, h): (f32, f32)| [l.max(0.0), h.min(1.0)];
            Some(low.into_iter().zip(high).map(inside).collect::<Vec<_>>())
        }
        false => None,
    };
    let mut warnings = warnings_of(data, settings);
    let map = smooth_out(map, bounds.as_deref(), settings);
    let map = match settings.flatten {
        Some(sigma) => lowered(&map, &low_pass(&map, sigma)),
        None => map,
    };
    let map = finish(map, settings, &mut warnings);
    Ok(Prepared {
        map,
        highlights: None,
        warnings,
    })
}

impl PrepareSettings {
    fn check(&self) -> Result<(), PrepareError> {
        for (what, sigma) in [("flattening", self.flatten), ("smoothing", self.smooth)] {
            match sigma {
                // Written so that NaN fails.
                Some(sigma) if !(sigma > 0.0 && sigma.is_finite()) => {
                    return Err(PrepareError::Width { what, sigma });
                }
                _ => (),
            }
        }
        match self.stretch {
            Stretch::Percentile(p) if !(p > 0.0 && p < 50.0) => Err(PrepareError::Percentile(p)),
            _ => Ok(()),
        }
    }
}

/// What is known from the numbers alone.
fn warnings_of(raster: &Raster, settings: &PrepareSettings) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if raster.precision() == Precision::Eight && !settings.dequantize {
        warnings.push(Warning::EightBits);
    }
    let [black, white] = raster.clipped();
    if black > CLIPPED {
        warnings.push(Warning::ClippedBlacks { share: black });
    }
    if white > CLIPPED {
        warnings.push(Warning::ClippedWhites { share: white });
    }
    warnings
}

/// Takes off the steps of rounding, then what is finer than asked for.
fn smooth_out(
    map: HeightMap,
    bounds: Option<&[[f32; 2]]>,
    settings: &PrepareSettings,
) -> HeightMap {
    let map = match bounds {
        Some(bounds) => dequantize(&map, bounds),
        None => map,
    };
    match settings.smooth {
        Some(sigma) => map.with_heights(low_pass(&map, sigma)),
        None => map,
    }
}

/// What a photo would be in even light: shading multiplies. As bright on the whole as before.
fn divided(map: &HeightMap, shading: &[f32]) -> HeightMap {
    let mean =
        |values: &[f32]| values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
    let level = mean(map.heights());
    // In the dark there is noise and no shading.
    let floor = 0.02 * level.abs().max(f64::MIN_POSITIVE);
    let even = map.heights().iter().zip(shading).map(|(&h, &s)| {
        let light = f64::from(h) * level / f64::from(s).max(floor);
        light.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
    });
    map.with_heights(even.collect())
}

/// Heights without what is broad in them, on the whole where they were: waviness adds.
fn lowered(map: &HeightMap, waves: &[f32]) -> HeightMap {
    let level = waves.iter().map(|&w| f64::from(w)).sum::<f64>() / waves.len() as f64;
    let even = map.heights().iter().zip(waves).map(|(&h, &w)| {
        let height = f64::from(h) - f64::from(w) + level;
        height.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
    });
    map.with_heights(even.collect())
}

/// Turns over and stretches.
fn finish(map: HeightMap, settings: &PrepareSettings, warnings: &mut Vec<Warning>) -> HeightMap {
    let map = if settings.invert { invert(&map) } else { map };
    let map = stretch(&map, settings.stretch).unwrap_or_else(|| {
        let wild = map.heights().iter().any(|&h| h != map.heights()[0]);
        warnings.push(match settings.stretch {
            Stretch::Percentile(percent) if wild => Warning::ConstantWithin { percent },
            _ => Warning::Constant,
        });
        map.with_heights(vec![0.5; map.heights().len()])
    });
    warnings.extend(not_tiling(&map));
    map
}
