//! The Cornell box as its Program of Computer Graphics measured it
//! (<https://www.graphics.cornell.edu/online/box/data.html>), in units of a tenth of a metre to the
//! hundred.
//!
//! Reflectances are the measured spectra as linear sRGB under D65. The lamp shines white. It lies
//! in the plane of the ceiling in the data; here it hangs half a unit below.

use bevy_fresco::radiosity::Scene;
use glam::{Vec3, vec3};

use super::shapes::{Builder, Look, Shape, grey, join, lamp, quad};

const WHITE: Vec3 = vec3(0.7382, 0.7360, 0.7385);
const GREEN: Vec3 = vec3(0.0684, 0.3985, 0.0865);
const RED: Vec3 = vec3(0.4939, 0.0489, 0.0512);
const LAMP: [[f32; 3]; 4] = [
    [343.0, 548.3, 227.0],
    [343.0, 548.3, 332.0],
    [213.0, 548.3, 332.0],
    [213.0, 548.3, 227.0],
];
const SHORT: [[f32; 2]; 4] = [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]];
const TALL: [[f32; 2]; 4] = [
    [423.0, 247.0],
    [265.0, 296.0],
    [314.0, 456.0],
    [472.0, 406.0],
];

pub(super) fn empty(_: u32) -> Scene {
    walls().finish()
}

pub(super) fn with_blocks(_: u32) -> Scene {
    walls()
        .with("short block", block(SHORT, 165.0), colored(WHITE))
        .with("tall block", block(TALL, 330.0), colored(WHITE))
        .finish()
}

fn walls() -> Builder {
    let white = [
        [
            [552.8, 0.0, 0.0],
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 559.2],
            [549.6, 0.0, 559.2],
        ],
        [
            [556.0, 548.8, 0.0],
            [556.0, 548.8, 559.2],
            [0.0, 548.8, 559.2],
            [0.0, 548.8, 0.0],
        ],
        [
            [549.6, 0.0, 559.2],
            [0.0, 0.0, 559.2],
            [0.0, 548.8, 559.2],
            [556.0, 548.8, 559.2],
        ],
    ];
    let green = [
        [0.0, 0.0, 559.2],
        [0.0, 0.0, 0.0],
        [0.0, 548.8, 0.0],
        [0.0, 548.8, 559.2],
    ];
    let red = [
        [552.8, 0.0, 0.0],
        [549.6, 0.0, 559.2],
        [556.0, 548.8, 559.2],
        [556.0, 548.8, 0.0],
    ];
    Builder::default()
        .with("white walls", join(white.map(measured)), colored(WHITE))
        .with("green wall", measured(green), colored(GREEN))
        .with("red wall", measured(red), colored(RED))
        .with("lamp", measured(LAMP), lamp(15.0))
}

fn colored(reflectance: Vec3) -> Look {
    Look {
        reflectance,
        ..grey(0.0)
    }
}

fn measured(corners: [[f32; 3]; 4]) -> Shape {
    quad(corners.map(|c| Vec3::from(c) / 100.0))
}

/// A block without its bottom, which lies on the floor.
fn block(corners: [[f32; 2]; 4], height: f32) -> Shape {
    let at = |i: usize, y: f32| [corners[i % 4][0], y, corners[i % 4][1]];
    let top = measured([0, 1, 2, 3].map(|i| at(i, height)));
    (0..4).fold(top, |all, i| {
        all.and(&measured([
            at(i, 0.0),
            at(i + 1, 0.0),
            at(i + 1, height),
            at(i, height),
        ]))
    })
}
