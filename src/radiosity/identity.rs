use std::collections::HashMap;

use super::sampling::hash;
use super::validate::ValidScene;

/// What tells a thing from others from one bake to the next: its key, and which of those of the
/// key it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Identity {
    key: u64,
    nth: u32,
}

impl Identity {
    /// Where the random numbers of a thing start: its own, whatever else is in the scene.
    pub(crate) fn seed(self) -> u32 {
        hash(self.nth, hash(self.key as u32, (self.key >> 32) as u32))
    }
}

/// The identities of things with these keys, in order.
pub(crate) fn identities(keys: impl Iterator<Item = u64>) -> Vec<Identity> {
    let mut seen = HashMap::new();
    keys.map(|key| {
        let count = seen.entry(key).or_insert(0);
        *count += 1;
        Identity {
            key,
            nth: *count - 1,
        }
    })
    .collect()
}

/// For each of `new`, where it was in `old`.
pub(crate) fn matches(old: &[Identity], new: &[Identity]) -> Vec<Option<usize>> {
    let places: HashMap<Identity, usize> = old.iter().copied().zip(0..).collect();
    new.iter().map(|id| places.get(id).copied()).collect()
}

pub(crate) fn object_identities(scene: &ValidScene) -> Vec<Identity> {
    identities(scene.objects.iter().map(|o| o.key))
}

pub(crate) fn light_identities(scene: &ValidScene) -> Vec<Identity> {
    identities(scene.lights.iter().map(|l| l.key))
}

/// A seed for each object of a scene.
pub(crate) fn object_seeds(scene: &ValidScene) -> Vec<u32> {
    let identities = object_identities(scene);
    identities.into_iter().map(Identity::seed).collect()
}
