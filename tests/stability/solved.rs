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

/// Least and most light that arrives at some elements.
pub(crate) fn range<'a>(elements: impl Iterator<Item = &'a Element>) -> (f32, f32) {
    elements.fold((f32::INFINITY, 0.0), |(low, high), e| {
        (low.min(e.irradiance.x), high.max(e.irradiance.x))
    })
}

/// The light of an object's vertices, one channel.
pub(crate) fn lights(bake: &Bake, object: usize) -> Vec<f32> {
    bake.objects[object].light.iter().map(|l| l.x).collect()
}

/// Of the rays of all elements, how many met no element, and how many the object they started from.
pub(crate) fn astray(light: &ElementLight, settings: &BakeSettings) -> (f64, f64) {
    let (mut lost, mut own) = (0.0, 0.0);
    for (i, e) in light.elements.iter().enumerate() {
        lost += 1.0 - light.row_sum(i);
        let entries = light.row(i).into_iter().zip(&light.elements);
        own += entries
            .map(|(f, to)| f * f64::from(u8::from(to.object == e.object)))
            .sum::<f64>();
    }
    let rays = f64::from(settings.element_rays);
    (lost * rays, own * rays)
}

/// Whether a scene without gaps is tight: a point within 10⁻⁷ of an edge may be rounded to the other
/// side of it, so that of a million rays one may get out.
pub(crate) fn tight(light: &ElementLight, settings: &BakeSettings) -> bool {
    let rays = light.elements.len() as f64 * f64::from(settings.element_rays);
    let sums = (0..light.elements.len()).map(|e| light.row_sum(e));
    let lost: f64 = sums.map(|sum| 1.0 - sum).sum();
    lost * f64::from(settings.element_rays) <= (1e-6 * rays).max(1.0)
}

/// How far the radiosity of an element is from 1 at most, in a scene where it is 1 everywhere.
pub(crate) fn furthest_from_one(light: &ElementLight) -> f64 {
    let errors = light
        .elements
        .iter()
        .map(|e| apart(e.radiosity.x.into(), 1.0));
    errors.fold(0.0, f64::max)
}
