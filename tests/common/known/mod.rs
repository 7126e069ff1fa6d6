//! Scenes whose light is known to a few thousandths, and how far a bake of them is off.
//!
//! | file | |
//! |---|---|
//! | `layout` | a scene told by flat faces and sources of light |
//! | `scenes` | the scenes |
//! | `polygon` | convex polygons: cut, and met by rays |
//! | `direct` | light that arrives without a bounce, exactly |
//! | `shown` | the light that a mesh shows at a point |
//! | `truth` | direct light, and what bounces from a fine bake |
//! | `error` | a bake against the truth |

#![allow(dead_code, reason = "tests and the accuracy example use some each")]

pub(crate) mod direct;
pub(crate) mod error;
pub(crate) mod layout;
pub(crate) mod polygon;
pub(crate) mod scenes;
pub(crate) mod shown;
pub(crate) mod truth;
