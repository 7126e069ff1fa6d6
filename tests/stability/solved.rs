//! What the tests ask of a solution.

use bevy_fresco::radiosity::{
    Bake, BakeSettings, Element, ElementLight, Scene, bake, solve_elements,
};

pub(crate) fn baked(scene: Scene, settings: &BakeSettings) -> Bake {
    bake(&scene.validate().unwrap(), settings, &()).unwrap()
}

pub(crate) fn solved(scene: Scene, settings: &BakeSettings) -> ElementLight {
    solve_elements(&scene.validate().unwrap(), settings, &()).unwrap()
}

/// The elements of an object.
pub(crate) fn of_object(light: &ElementLight, object: u32) -> impl Iterator<Item = &Element> {
    let elements = light.elements.iter();
    elements.filter(move |e| e.object.0 == object)
}

/// Mean over the area of some elements.
pub(crate) fn mean<'a>(
    elements: impl Iterator<Item = &'a Element>,
    value: impl Fn(&Element) -> f32,
) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for e in elements {
        sum += f64::from(e.area) * f64::from(value(e));
        total += f64::from(e.area);
    }
    sum / total
}

/// How far `a` is from `b`, as a share of `b`.
pub(crate) fn apart(a: f64, b: f64) -> f64 {
    (a / b - 1.0).abs()
}

/// Root mean square and largest difference of two lists, as shares of the mean of `b`.
pub(crate) fn differences(a: &[f32], b: &[f32]) -> (f64, f64) {
    assert_eq!(a.len(), b.len());
    let mean = b.iter().map(|&x| f64::from(x)).sum::<f64>() / b.len() as f64;
    let each = || a.iter().zip(b).map(|(x, y)| f64::from((x - y).abs()));
    let square: f64 = each().map(|d| d * d).sum();
    let largest = each().fold(0.0, f64::max);
    ((square / b.len() as f64).sqrt() / mean, largest / mean)
}
