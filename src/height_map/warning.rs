use thiserror::Error;

/// What somebody who uses a prepared map should know, and what helps.
///
/// Shares are of all texels, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Warning {
    /// Every height is the same, so all of them are ½.
    #[error(
        "the image is the same all over: every height is one half, and nothing will show; use an image \
         that has contrast"
    )]
    Constant,
    /// Every height is the same but for those that percentiles leave out, so all of them are ½.
    #[error(
        "the image is the same all over once {percent} % are left out at either end: every height is one \
         half; ask for a smaller percentile, or for none"
    )]
    ConstantWithin {
        /// What was asked for.
        percent: f32,
    },
    /// Light mirrored by gloss: it says nothing of height, and shows as peaks.
    #[error(
        "gloss: {:.1} % of the photo are highlights, most of them around texel ({}, {}), and will stand out \
         as peaks; take the photo under an overcast sky or with crossed polarisers, or paint them over",
        100.0 * .share,
        .at[0],
        .at[1]
    )]
    Highlights {
        /// How much of the photo.
        share: f64,
        /// Column and row of the middle of the largest.
        at: [u32; 2],
    },
    /// Colour or shadow taken for relief.
    #[error(
        "colour, not relief: {:.0} % of the contrast is in sharp steps between even areas, as paint and cast \
         shadows make them, the sharpest at texel ({}, {}); they will become cliffs. Even the colours out, or \
         use a photo or a height map of the relief alone",
        100.0 * .share,
        .at[0],
        .at[1]
    )]
    AlbedoEdges {
        /// How much of the squared difference between neighbours.
        share: f64,
        /// Column and row of the sharpest.
        at: [u32; 2],
    },
    /// Too dark for the camera.
    #[error(
        "{:.1} % of the image are black, at the end of its range: what lies deeper is cut off flat; expose \
         longer",
        100.0 * .share
    )]
    ClippedBlacks {
        /// How much of the image.
        share: f64,
    },
    /// Too bright for the camera.
    #[error(
        "{:.1} % of the image are at the upper end of its range: what stands higher is cut off flat; expose \
         less",
        100.0 * .share
    )]
    ClippedWhites {
        /// How much of the image.
        share: f64,
    },
    /// 256 steps of height: gentle slopes become terraces.
    #[error(
        "the image has 8 bits, so gentle slopes become terraces of 1/255 of its range: dequantise it \
         (--dequantize), or use 16 bits"
    )]
    EightBits,
    /// A map that is to repeat has a step at its border.
    #[error(
        "it does not tile: neighbours across the {} border differ {times:.1} times as much as inside, and \
         the relief will show a seam; make the image tile, or use it once (without --tile)",
        if *.axis == 0 { "left and right" } else { "upper and lower" }
    )]
    NotTiling {
        /// 0: from left to right, 1: from top to bottom.
        axis: usize,
        /// Difference of neighbours across the border by difference of neighbours inside, root mean
        /// square.
        times: f64,
    },
}
