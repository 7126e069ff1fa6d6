use glam::Vec3;

use super::element::Elements;

/// Which part of the light goes into vertices.
///
/// Both parts are solved for in any case, and add up to the whole but for what chance leaves in each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Contribution {
    /// Direct and indirect light.
    #[default]
    All,
    /// Light that comes straight from lights, emissive surfaces and the sky.
    Direct,
    /// Light that surfaces reflected at least once.
    Indirect,
}

impl Contribution {
    /// Whether light is in it that no surface reflected.
    pub(crate) fn has_direct(self) -> bool {
        self != Self::Indirect
    }

    /// Whether light is in it that surfaces reflected.
    pub(crate) fn has_indirect(self) -> bool {
        self != Self::Direct
    }

    /// Light at an element, of which `direct` is such that no surface reflected.
    pub(crate) fn of(self, arriving: Vec3, direct: Vec3) -> Vec3 {
        match self {
            Self::All => arriving,
            Self::Direct => direct,
            Self::Indirect => (arriving - direct).max(Vec3::ZERO),
        }
    }

    /// How many times as much an error of the elements' light, told beside all light, is beside this
    /// part of it.
    pub(crate) fn enlarges(self, elements: &Elements, arriving: &[Vec3], direct: &[Vec3]) -> f32 {
        match self {
            Self::All => 1.0,
            // Elements have no say in it.
            Self::Direct => 0.0,
            Self::Indirect => {
                let both = arriving.iter().zip(direct);
                let part: Vec<Vec3> = both.map(|(&all, &direct)| self.of(all, direct)).collect();
                let part = elements.mean_of(&part);
                if part > 0.0 {
                    (elements.mean_of(arriving) / part) as f32
                } else {
                    0.0
                }
            }
        }
    }
}
