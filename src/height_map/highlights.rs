use super::{HeightMap, Warning};

/// Where gloss mirrors the lamp.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Highlights {
    /// Which texels.
    pub(super) mask: Vec<bool>,
    /// What to say about them.
    pub(super) warning: Warning,
}

pub(super) fn highlights(
    _luminance: &HeightMap,
    _colours: Option<&[[f32; 3]]>,
) -> Option<Highlights> {
    None
}
