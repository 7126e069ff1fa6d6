//! How far the normals of a bump are off, and how many texels they take: the kernels of height maps, Sobel's
//! differences, and maps of slopes made beforehand. On waves whose normals are known everywhere.

use std::f32::consts::TAU;

use bevy_fresco::height_map::{HeightMap, HeightMapError, Kernel, Wrap, derivative_map};
use glam::{DVec3, Vec2, Vec3};

use crate::chart::{Axis, Chart, Dot, STYLES, Series};
use crate::charts::{Named, axis, styled};
use crate::csv::{cell, table};
use crate::text::count;

/// Texels a wave.
const WAVES: [u32; 4] = [8, 16, 32, 64];
/// Waves of a map, and places on a side at which normals are compared: between texels everywhere.
const REPEATS: u32 = 2;
const PLACES: u32 = 331;

/// How slopes are found.
#[derive(Clone, Copy)]
enum Way {
    /// From heights, by a kernel.
    Heights(Kernel),
    /// Sobel's 3 × 3 differences at texels, linear between them.
    Sobel,
    /// Slopes of a kernel at texels made beforehand, linear between them: one read of the hardware's filter.
    Beforehand(Kernel),
    /// The same as a normal map of 8 bits.
    NormalMap(Kernel),
}

/// Every way, its name, and how many texels a normal takes.
const WAYS: [(Way, &str, u32); 9] = [
    (Way::Heights(Kernel::Bilinear), "bilinear", 4),
    (Way::Heights(Kernel::Forward), "forward differences", 9),
    (Way::Heights(Kernel::HalfCentral), "central, ±½ texel", 9),
    (Way::Heights(Kernel::Central), "central, ±1 texel", 12),
    (Way::Sobel, "Sobel", 16),
    (Way::Heights(Kernel::BSpline), "cubic B-spline", 16),
    (Way::Heights(Kernel::CatmullRom), "Catmull–Rom", 16),
    (Way::Beforehand(Kernel::CatmullRom), "derivative map", 4),
    (Way::NormalMap(Kernel::CatmullRom), "normal map, 8 bits", 4),
];

/// A way on a map.
pub(crate) struct Found {
    way: usize,
    texels_a_wave: u32,
    /// Of the angle, in degrees: root mean square and at most.
    errors: [f64; 2],
}

/// Height and slopes at texture coordinates, the steepest slope 45°.
fn waves(uv: Vec2) -> (f32, Vec2) {
    let at = TAU * REPEATS as f32 * uv;
    let unit = 1.0 / (TAU * REPEATS as f32);
    let slopes = Vec2::new(at.x.cos() * at.y.cos(), -at.x.sin() * at.y.sin());
    (unit * at.x.sin() * at.y.cos(), slopes)
}

fn normal(slopes: Vec2) -> Vec3 {
    Vec3::new(-slopes.x, -slopes.y, 1.0).normalize()
}

/// Slopes by 3 × 3 texels.
fn sobel(map: &HeightMap) -> Vec<Vec2> {
    let [width, height] = map.size().map(i64::from);
    let at = |i: i64| {
        let (x, y) = (i % width, i / width);
        let three = |f: &dyn Fn(i64) -> f32| f(-1) + 2.0 * f(0) + f(1);
        let across = three(&|j| map.texel(x + 1, y + j) - map.texel(x - 1, y + j));
        let down = three(&|i| map.texel(x + i, y + 1) - map.texel(x + i, y - 1));
        Vec2::new(across * width as f32, down * height as f32) / 8.0
    };
    (0..width * height).map(at).collect()
}

/// Values at texels, linear between them, the map repeating.
fn between(values: &[Vec3], n: i64, uv: Vec2) -> Vec3 {
    let place = uv * n as f32 - 0.5;
    let (first, t) = (place.floor().as_i64vec2(), place - place.floor());
    let texel = |x: i64, y: i64| values[(y.rem_euclid(n) * n + x.rem_euclid(n)) as usize];
    let row = |y: i64| texel(first.x, y).lerp(texel(first.x + 1, y), t.x);
    row(first.y).lerp(row(first.y + 1), t.y)
}

fn errors(way: Way, texels_a_wave: u32) -> Result<[f64; 2], HeightMapError> {
    let n = texels_a_wave * REPEATS;
    let at = |i: u32| (Vec2::new((i % n) as f32, (i / n) as f32) + 0.5) / n as f32;
    let heights = (0..n * n).map(|i| waves(at(i)).0).collect();
    let map = HeightMap::new([n; 2], heights, [Wrap::Repeat; 2])?;
    let flat = |slopes: Vec<Vec2>| slopes.into_iter().map(|s| s.extend(0.0)).collect();
    let values: Vec<Vec3> = match way {
        Way::Heights(_) => Vec::new(),
        Way::Sobel => flat(sobel(&map)),
        Way::Beforehand(kernel) => flat(derivative_map(&map, kernel)),
        Way::NormalMap(kernel) => {
            let eight_bits = |s: Vec2| {
                let n = 127.5 * normal(s) + 127.5;
                n.round() / 127.5 - 1.0
            };
            derivative_map(&map, kernel)
                .into_iter()
                .map(eight_bits)
                .collect()
        }
    };
    let (mut squares, mut most) = (0.0, 0.0_f64);
    for i in 0..PLACES * PLACES {
        let place = Vec2::new((i % PLACES) as f32, (i / PLACES) as f32) + 0.5;
        let uv = place / PLACES as f32;
        let found = match way {
            Way::Heights(kernel) => normal(map.at(uv, kernel).slopes),
            Way::Sobel | Way::Beforehand(_) => normal(between(&values, n.into(), uv).truncate()),
            Way::NormalMap(_) => between(&values, n.into(), uv).normalize(),
        };
        let [a, b]: [DVec3; 2] = [found, normal(waves(uv).1)].map(Into::into);
        let off = a.cross(b).length().atan2(a.dot(b)).to_degrees();
        squares += off * off;
        most = most.max(off);
    }
    Ok([(squares / f64::from(PLACES * PLACES)).sqrt(), most])
}

/// Every way with every wave.
pub(crate) fn study() -> Result<Vec<Found>, HeightMapError> {
    let every = (0..WAYS.len()).flat_map(|way| WAVES.map(|n| (way, n)));
    let found = every.map(|(way, texels_a_wave)| {
        let errors = errors(WAYS[way].0, texels_a_wave)?;
        Ok(Found {
            way,
            texels_a_wave,
            errors,
        })
    });
    found.collect()
}

pub(crate) fn csv(all: &[Found]) -> String {
    table(
        "kernel,texels,texels_a_wave,rms_degrees,most_degrees",
        all,
        |f| {
            let (_, name, texels) = WAYS[f.way];
            vec![
                cell(name),
                cell(texels),
                cell(f.texels_a_wave),
                cell(f.errors[0]),
                cell(f.errors[1]),
            ]
        },
    )
}

/// Texels of a way, those that take as many a little beside each other.
fn beside(way: usize) -> f64 {
    let texels = WAYS[way].2;
    let of = |ways: &[(Way, &str, u32)]| ways.iter().filter(|w| w.2 == texels).count() as f64;
    let place = of(&WAYS[..way]) - 0.5 * (of(&WAYS) - 1.0);
    f64::from(texels) * 1.08_f64.powf(place)
}

pub(crate) fn charts(all: &[Found]) -> Vec<Named> {
    if all.is_empty() {
        return Vec::new();
    }
    let line = |(i, &(_, name, _)): (usize, &(Way, &str, u32))| {
        let dots = all.iter().filter(|f| f.way == i).map(|f| Dot {
            at: (beside(i), f.errors[0]),
            label: count(f.texels_a_wave.into()),
        });
        // More lines than styles: the second time round with other markers.
        let marker = STYLES[(i + i / STYLES.len()) % STYLES.len()].1;
        Series {
            marker,
            ..styled(i, name, dots.collect())
        }
    };
    let series: Vec<_> = WAYS.iter().enumerate().map(line).collect();
    let chart = Chart {
        title: "Normals of a bump: error against texels".into(),
        subtitle: "Waves of 45° at the steepest, by texels a wave; those of as many texels stand a little apart"
            .into(),
        x: Axis {
            ticks: [4_u32, 9, 12, 16]
                .map(|n| (f64::from(n), count(n.into())))
                .to_vec(),
            ..axis("texels that a normal takes", |v| count(v as u64))
        },
        y: axis("error of the normal, RMS", |v| {
            format!("{}°", (v * 1e6).round() / 1e6)
        }),
        // Lines join maps, not budgets: there is nothing to race.
        front: Vec::new(),
        series,
        guides: Vec::new(),
        floor: None,
    };
    vec![("kernels.svg".into(), chart)]
}
