//! Height maps: grey images that say how far a surface stands out, and how steep it is between
//! their texels.
//!
//! A map is a function `F(u, v)` over texture coordinates, known at the centres of texels. Relief
//! is shaded by its slopes, so what counts is how these are found ([`Kernel`]). Blinn took
//! differences of neighbouring values (J. F. Blinn, "Simulation of wrinkled surfaces", SIGGRAPH
//! 1978, section 4):
//!
//! ```text
//!   ┌──────────────────────────────────────────────┐
//!   │  F_u = (F(u + ε, v) − F(u − ε, v)) / 2ε       │     ε: half a texel, or one
//!   └──────────────────────────────────────────────┘
//! ```
//!
//! with `F` linear between texels. That has two faults when a map is magnified: with ε small, slopes
//! are constant within a texel and jump at its border, so that facets show; with one-sided differences
//! relief moves by half of ε. Kernels that are smooth themselves have neither: their slope is the slope
//! of a curve through the texels ([`Kernel::CatmullRom`]) or past them ([`Kernel::BSpline`]).
//!
//! # From an image to a map
//!
//! Whoever has no map has a photo. Nothing of it is height: it is light, and becomes height by a guess that
//! is better the more even the light and the colour are (bright is high). [`prepare`] makes the map and
//! tells what spoils the guess:
//!
//! ```text
//!   Raster ── Photo ─ luminance ─ dequantize ─ smooth ─ ÷ shading ─┐
//!      │        └─ highlights, albedo edges ─► warnings            ├─ invert ─ stretch ─► HeightMap
//!      └───── prepare_data ────── dequantize ─ smooth ─ − waves ───┘                     │
//!                                                               derivative map, normal map ◄┘
//! ```
//!
//! A [`Raster`] is numbers. Only a [`Photo`] says what light they stand for, and only its numbers are
//! decoded; heights are taken as they are. So an sRGB curve never gets into heights by mistake.
//!
//! | file | what it does |
//! |---|---|
//! | `map` | the map: texels, how it goes on beyond its border, errors |
//! | `kernel` | heights and slopes between texels |
//! | `raster` | the numbers of an image |
//! | `photo` | what they say of light; greyscale |
//! | `prepare` | from an image to a map, in the order of the picture |
//! | `dequantize` | takes the steps of 8 bits off |
//! | `low_pass` | what of a map is broader than a window |
//! | `contrast` | inversion and stretch |
//! | `highlights`, `albedo`, `border` | what looks like relief and is none |
//! | `components` | groups of texels that hang together |
//! | `warning` | what is told about it |
//! | `slopes` | derivative maps and normal maps |
//! | `pyramid` | smaller and smaller, with what slopes vary by |
//! | `bounds` | how high and low blocks of it go, for rays |
//! | `planes` | planes over blocks, and how far heights leave them |

mod albedo;
#[cfg(test)]
mod albedo_test;
mod border;
mod bounds;
mod components;
mod contrast;
mod dequantize;
#[cfg(test)]
mod dequantize_test;
mod highlights;
#[cfg(test)]
mod highlights_test;
mod kernel;
#[cfg(test)]
mod kernel_test;
mod low_pass;
mod map;
mod photo;
mod planes;
mod prepare;
#[cfg(test)]
mod prepare_test;
mod pyramid;
mod raster;
mod slopes;
#[cfg(test)]
mod test_photos;
mod warning;

pub use bounds::{Bounds, BoundsLevel};
pub use contrast::Stretch;
pub use kernel::{Kernel, Relief};
pub use map::{HeightMap, HeightMapError, Wrap};
pub use photo::{Encoding, Photo};
pub use planes::{Block, PlanePyramid};
pub use prepare::{PrepareError, PrepareSettings, Prepared, prepare, prepare_data};
pub use pyramid::{Level, Moments, Pyramid};
pub use raster::{Precision, Raster, RasterError, Texels};
pub use slopes::{
    Green, NormalMapSettings, decode_normal, derivative_map, encode_normal, normal_map,
};
pub use warning::Warning;
