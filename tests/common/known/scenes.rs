use glam::{Vec3, vec3};

use super::layout::{Corners, Layout, Source, block, ground, inside, solid};
use super::truth::Care;

const GREY: Vec3 = Vec3::splat(0.6);
const LIGHT: Vec3 = Vec3::ONE;

/// The usual care: bounced light to about 0.3 % of all light.
pub(crate) const CARE: Care = Care {
    spacing: 0.3,
    elements: 12_000,
    seeds: 4,
};

/// Ground of two objects, three walls, two blocks and a pole of 4 cm under a hard sun and a sky.
pub(crate) fn court() -> Layout {
    let [_, _, low_x, high_x, low_z, _] = inside(Vec3::ZERO, vec3(6.0, 2.5, 6.0));
    Layout {
        sky: LIGHT,
        ..Layout::new("court")
    }
    .with("west", GREY, &[ground(Vec3::ZERO, vec3(3.0, 0.0, 6.0))])
    .with(
        "east",
        GREY,
        &[ground(vec3(3.0, 0.0, 0.0), vec3(6.0, 0.0, 6.0))],
    )
    .with("walls", GREY, &[low_x, high_x, low_z])
    .with(
        "block",
        GREY,
        &block(vec3(1.1, 0.0, 3.3), vec3(2.0, 0.9, 4.3)),
    )
    .with(
        "across",
        GREY,
        &block(vec3(2.6, 0.0, 1.2), vec3(3.4, 1.5, 1.9)),
    )
    .with(
        "pole",
        GREY,
        &block(vec3(4.5, 0.0, 3.5), vec3(4.54, 1.8, 3.54)),
    )
    .lit_by(Source::Sun {
        direction: vec3(-0.45, -1.0, 0.3),
        light: LIGHT * 10.0,
    })
}

/// The foot of the block that hovers in [`room_with_panel`], by its lowest corner and size.
pub(crate) const HOVERING: [Vec3; 2] = [vec3(0.9, 1e-3, 2.1), vec3(0.8, 0.7, 0.9)];

/// A room with a panel of light and two blocks, one of which hovers 1 mm over the floor.
pub(crate) fn room_with_panel() -> Layout {
    let [low, size] = HOVERING;
    Layout::new("room with a panel")
        .with("room", GREY, &inside(Vec3::ZERO, vec3(4.0, 2.6, 4.0)))
        .with(
            "standing",
            GREY,
            &block(vec3(2.4, 0.0, 1.1), vec3(3.1, 1.4, 1.9)),
        )
        .with("hovering", GREY, &solid(low, low + size))
        .lit_by(panel(vec3(1.9, 2.3, 1.9), 0.7))
}

/// A square that shines down.
fn panel(low: Vec3, side: f32) -> Source {
    let [_, bottom, ..] = solid(low, low + vec3(side, 0.0, side));
    Source::Panel {
        corners: bottom,
        radiance: LIGHT * 10.0,
    }
}

/// Where the wall of [`two_rooms`] begins.
pub(crate) const WALL: f32 = 3.0;

/// A bright room and a dark one under one ceiling, on one floor that runs under the wall between.
pub(crate) fn two_rooms(thickness: f32) -> Layout {
    let (height, depth) = (2.4, 2.0);
    let end = WALL + thickness;
    let hall = inside(Vec3::ZERO, vec3(end + 3.0, height, depth));
    let [_, _, bright, ..] = solid(vec3(WALL, 0.0, 0.0), vec3(WALL, height, depth));
    let [_, _, _, dark, ..] = solid(vec3(end, 0.0, 0.0), vec3(end, height, depth));
    let [ceiling, floor, walls @ ..] = hall;
    Layout::new("two rooms")
        .with("floor", GREY, &[floor])
        .with("ceiling", GREY, &[ceiling])
        .with("walls", GREY, &walls)
        .with("bright side", GREY, &[bright])
        .with("dark side", GREY, &[dark])
        .lit_by(panel(vec3(1.2, 2.2, 0.7), 0.6))
}

/// Where the partition of [`partition`] stands: from the wall at z = 0 to the middle of the floor.
pub(crate) const PARTITION: [Vec3; 2] = [vec3(2.0, 0.0, 0.0), vec3(2.005, 2.4, 1.5)];

/// A room with a partition of 5 mm that ends in the middle of its floor; a panel on one side.
pub(crate) fn partition() -> Layout {
    let [_, _, low_x, high_x, _, high_z] = solid(PARTITION[0], PARTITION[1]);
    Layout::new("partition")
        .with("room", GREY, &inside(Vec3::ZERO, vec3(4.0, 2.4, 3.0)))
        .with("partition", GREY, &[low_x, high_x, high_z])
        .lit_by(panel(vec3(0.7, 2.2, 0.5), 0.6))
}

/// A gallery under six bulbs, with three plinths.
pub(crate) fn gallery() -> Layout {
    let plinth = |x: f32| block(vec3(x, 0.0, 1.3), vec3(x + 0.4, 1.0, 1.7));
    let bulbs = [0.8, 2.2, 3.6, 5.0, 6.4, 7.8].map(|x| Source::Bulb {
        position: vec3(x, 2.4, 2.2),
        light: LIGHT * 3.0,
    });
    let layout = Layout::new("gallery")
        .with("gallery", GREY, &inside(Vec3::ZERO, vec3(8.6, 3.0, 3.0)))
        .with("plinth", GREY, &plinth(1.5))
        .with("plinth", GREY, &plinth(4.1))
        .with("plinth", GREY, &plinth(6.6));
    bulbs.into_iter().fold(layout, Layout::lit_by)
}

/// The Cornell box of `assets/scenes/cornell_box.glb`, bare: a face where that has a grid.
#[expect(clippy::approx_constant, reason = "3.14 m is a measurement, not π")]
pub(crate) fn cornell_box() -> Layout {
    let white = Vec3::splat(0.73);
    let (red, green) = (vec3(0.63, 0.065, 0.05), vec3(0.14, 0.45, 0.091));
    let [ceiling, floor, low_x, high_x, _, back] = inside(Vec3::ZERO, vec3(5.528, 5.488, 5.592));
    let [top, lamp, sides @ ..] = solid(vec3(2.13, 5.288, 2.27), vec3(3.43, 5.388, 3.32));
    let short = [[1.30, 0.65], [0.82, 2.25], [2.40, 2.72], [2.90, 1.14]];
    let tall = [[4.23, 2.47], [2.65, 2.96], [3.14, 4.56], [4.72, 4.06]];
    Layout::new("Cornell box")
        .with("Floor", white, &[floor])
        .with("Ceiling", white, &[ceiling])
        .with("Back wall", white, &[back])
        .with("Red wall", red, &[high_x])
        .with("Green wall", green, &[low_x])
        .with("Lamp casing", white, &[&[top], &sides[..]].concat())
        .with("Short block", white, &turned_block(short, 1.65))
        .with("Tall block", white, &turned_block(tall, 3.30))
        .with_lamp(lamp, white, vec3(17.0, 12.0, 4.0))
}

/// A block on the floor by its corners (x, z), anticlockwise seen from above.
fn turned_block(corners: [[f32; 2]; 4], height: f32) -> Vec<Corners> {
    let at = |i: usize, y: f32| vec3(corners[i % 4][0], y, corners[i % 4][1]);
    let side = |i: usize| [at(i, 0.0), at(i + 1, 0.0), at(i + 1, height), at(i, height)];
    let top = [0, 1, 2, 3].map(|i| at(i, height));
    std::iter::once(top).chain((0..4).map(side)).collect()
}

/// All of them but those whose light only leaks.
pub(crate) fn lit_scenes() -> [Layout; 5] {
    [
        court(),
        room_with_panel(),
        partition(),
        gallery(),
        cornell_box(),
    ]
}
