//! What Bevy needs to know of baked light.

mod attribute;

pub use attribute::ATTRIBUTE_BAKED_LIGHT;
