/// The two kinds of light that vertices get, each with a mesh, samples and errors of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// What rays gather: bounced light, sky, wide emitters.
    Smooth,
    /// Light of lights and sampled emitters, with its shadows.
    Sharp,
}

/// Something for each kind of light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ByKind<T> {
    pub(crate) smooth: T,
    pub(crate) sharp: T,
}

impl<T: Copy> ByKind<T> {
    pub(crate) fn both(value: T) -> Self {
        Self {
            smooth: value,
            sharp: value,
        }
    }

    pub(crate) fn of(&self, kind: Kind) -> T {
        match kind {
            Kind::Smooth => self.smooth,
            Kind::Sharp => self.sharp,
        }
    }

    pub(crate) fn map<U>(self, mut f: impl FnMut(T) -> U) -> ByKind<U> {
        ByKind {
            smooth: f(self.smooth),
            sharp: f(self.sharp),
        }
    }

    /// Of each kind, made of what two know of it.
    pub(crate) fn with<U: Copy, V>(
        self,
        other: ByKind<U>,
        mut f: impl FnMut(T, U) -> V,
    ) -> ByKind<V> {
        ByKind {
            smooth: f(self.smooth, other.smooth),
            sharp: f(self.sharp, other.sharp),
        }
    }
}

impl ByKind<f64> {
    /// Both together, of errors that have nothing to do with each other.
    pub(crate) fn total(self) -> f64 {
        self.smooth.hypot(self.sharp)
    }
}
