//! The scenes: each is made to be hard in a way of its own.

mod cornell;
mod rooms;
mod shapes;

use bevy_fresco::radiosity::{Element, Scene};

pub(crate) use rooms::{bright_room, unit_cube};

/// A scene that methods are compared on.
pub(crate) struct Subject {
    pub(crate) id: &'static str,
    pub(crate) name: &'static str,
    /// What is hard about it.
    pub(crate) about: &'static str,
    /// Makes it, for about so many elements.
    pub(crate) build: fn(u32) -> Scene,
    /// About how many elements to solve it on, one sweep of methods each.
    pub(crate) sizes: &'static [u32],
    /// Where errors count.
    pub(crate) counts: fn(&Element) -> bool,
    pub(crate) judged: Judged,
    /// Whether lamps left to form factors are tried as well.
    pub(crate) compares_lamps: bool,
}

/// Which light a method is judged by.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Judged {
    /// Light that bounced: direct light is sampled, the same by all methods.
    Bounced,
    /// All light. Every surface glows, and form factors find it; the answer is known.
    AllInASphere,
}

impl Judged {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Bounced => "bounced light",
            Self::AllInASphere => "all light",
        }
    }
}

const USUAL: [u32; 2] = [1000, 4000];

const fn subject(
    id: &'static str,
    name: &'static str,
    about: &'static str,
    build: fn(u32) -> Scene,
) -> Subject {
    Subject {
        id,
        name,
        about,
        build,
        sizes: &USUAL,
        counts: |element| element.emission.max_element() == 0.0,
        judged: Judged::Bounced,
        compares_lamps: false,
    }
}

pub(crate) const SUBJECTS: [Subject; 9] = [
    subject(
        "S1",
        "unit cube",
        "Nothing in between; the ceiling glows, ρ 0.5",
        |_| unit_cube(0.5),
    ),
    Subject {
        judged: Judged::AllInASphere,
        counts: |_| true,
        ..subject(
            "S2",
            "integrating sphere",
            "Every face emits and reflects by chance; the answer is exact",
            rooms::integrating_sphere,
        )
    },
    Subject {
        sizes: &[250, 1000, 4000, 16_000],
        compares_lamps: true,
        ..subject(
            "S3",
            "Cornell box",
            "Two blocks, as measured at Cornell",
            cornell::with_blocks,
        )
    },
    subject(
        "S4",
        "empty Cornell box",
        "The same without its blocks",
        cornell::empty,
    ),
    Subject {
        counts: |element| element.emission.max_element() == 0.0 && rooms::in_room_b(element.center),
        ..subject(
            "S5",
            "two rooms and a slit",
            "Light has to pass the slit: ρ 0.8, the lamp is in the other room",
            rooms::two_rooms,
        )
    },
    subject(
        "S6",
        "bright closed room",
        "ρ 0.95 and a column: light bounces twenty times",
        |_| bright_room(0.95),
    ),
    Subject {
        compares_lamps: true,
        ..subject(
            "S7",
            "hall of 64 small lamps",
            "Lamps of 2 cm in 10 m",
            rooms::hall,
        )
    },
    subject(
        "S8",
        "clutter",
        "Eleven thousand triangles in a room",
        rooms::clutter,
    ),
    subject(
        "S9",
        "louvres",
        "Slats twenty times as deep as the gaps between",
        rooms::louvres,
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_sound_and_lit() {
        for subject in &SUBJECTS {
            let scene = (subject.build)(500).validate();
            let scene = scene.unwrap_or_else(|e| panic!("{}: {e}", subject.id));
            assert!(scene.triangle_count() >= 12, "{}", subject.id);
        }
    }
}
