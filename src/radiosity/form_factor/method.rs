/// How form factors are found.
///
/// | method | a row costs | wrong by | made for |
/// |---|---|---|---|
/// | hit list | so many rays | noise, less with more rays | everything |
/// | hemicube | five pictures of the scene's triangles | aliasing, less with more pixels | few triangles |
/// | analytic | an integral and shadow rays for each pair | noise of the shadow rays | few elements |
/// | area sampling | shadow rays for each pair | noise, and much of it where elements touch | comparison |
///
/// Whatever the method, light at vertices is gathered by rays from the elements' light: the method
/// decides about light that bounces more than once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FormFactors {
    /// Rays distributed by the cosine, [`element_rays`](super::BakeSettings::element_rays) from
    /// each element: every hit weighs the same, and the list of them is the row (Malley 1988).
    #[default]
    HitList,
    /// The scene drawn onto the faces of a half cube over each element, with a z-buffer (Cohen and
    /// Greenberg 1985).
    Hemicube {
        /// Pixels along an edge of the half cube: an even number, 16..=512.
        resolution: u32,
    },
    /// The closed form between polygons, times the visible share.
    Analytic {
        /// Shadow rays between two elements. Limit: 1..=16384.
        visibility_rays: u32,
    },
    /// The double integral over two elements as a sum over pairs of points, a shadow ray each.
    AreaSampling {
        /// Pairs of points between two elements. Limit: 1..=16384.
        samples: u32,
    },
}

impl FormFactors {
    /// With twice the resolution: four times the pixels, or rays between two elements.
    pub(crate) const fn denser(self) -> Self {
        match self {
            Self::HitList => self,
            Self::Hemicube { resolution } => Self::Hemicube {
                resolution: 2 * resolution,
            },
            Self::Analytic { visibility_rays } => Self::Analytic {
                visibility_rays: 4 * visibility_rays,
            },
            Self::AreaSampling { samples } => Self::AreaSampling {
                samples: 4 * samples,
            },
        }
    }

    /// A short name for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::HitList => "hit list",
            Self::Hemicube { .. } => "hemicube",
            Self::Analytic { .. } => "analytic",
            Self::AreaSampling { .. } => "area sampling",
        }
    }
}
