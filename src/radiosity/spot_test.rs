//! Light at the spots of elements, on a floor of two triangles.

use glam::{Vec3, Vec3A};

use super::baker_test::quad;
use super::cells::in_cell;
use super::element::{ElementId, Elements};
use super::layout::Layout;
use super::sampling::{hash, unit_float};
use super::spot::{ALONG, MIDDLE, SPOTS};
use super::surface::{Pyramids, Surfaces};
use super::validate::ValidScene;
use super::{BakeSettings, Scene};

fn floor() -> (ValidScene, Elements) {
    let scene = Scene {
        objects: vec![quad(1, [Vec3::ZERO, Vec3::Z, Vec3::X], 1, 0)],
        materials: vec![Default::default()],
        sky: Vec3::ONE,
        ..Scene::default()
    };
    let scene = scene.validate().unwrap();
    let settings = BakeSettings {
        elements: 500,
        ..BakeSettings::DRAFT
    };
    let pyramids = Pyramids::new(&scene, None);
    let layout = Layout::even(&scene, &settings);
    let elements = Elements::new(&scene, &Surfaces::new(&scene, &pyramids), &layout, 0.99);
    assert!(elements.len() > 300);
    (scene, elements)
}

/// Middles of an element's spots.
fn spots(scene: &ValidScene, elements: &Elements, e: usize) -> Vec<Vec3> {
    let (_, [a, b, c], _) = elements.shape(scene, ElementId(e as u32)).next().unwrap();
    (0..SPOTS)
        .map(|spot| in_cell(MIDDLE, spot, ALONG))
        .map(|w| a * w.x + b * w.y + c * w.z)
        .collect()
}

fn middles(scene: &ValidScene, elements: &Elements) -> Vec<Vec3> {
    (0..elements.len())
        .map(|e| elements.middle(scene, ElementId(e as u32)).0)
        .collect()
}

/// Values that lie inside those of their neighbours are linear to the last bit but rounding: on all
/// elements except those at the border, which are the extremes there.
#[test]
fn linear_light_stays_linear() {
    let (scene, elements) = floor();
    let light = |p: Vec3| Vec3A::new(2.0 + p.x * 1e-3, 3.0 - p.z * 2e-3, 1.0);
    let middles = middles(&scene, &elements);
    let values: Vec<Vec3A> = middles.iter().map(|&p| light(p)).collect();
    let spread = elements.spread(&values);
    let (mut linear, mut all) = (0, 0);
    for e in 0..elements.len() {
        for (k, p) in spots(&scene, &elements, e).into_iter().enumerate() {
            let found = spread[e * SPOTS as usize + k];
            all += 1;
            linear += u32::from(found.distance(light(p)) < 1e-4);
            // Never farther off than if the element had one value.
            assert!(found.distance(light(p)) < values[e].distance(light(p)) + 1e-4);
        }
    }
    assert!(
        f64::from(linear) > 0.7 * f64::from(all),
        "{linear} of {all}"
    );
}

#[test]
fn elements_keep_their_mean_and_no_spot_is_beyond_the_neighbours() {
    let (_, elements) = floor();
    // A third of the elements have the least, and as many the most.
    let at = |e: usize, salt| (30.0 * unit_float(hash(e as u32, salt)) - 10.0).clamp(0.0, 10.0);
    let values: Vec<Vec3A> = (0..elements.len())
        .map(|e| Vec3A::new(at(e, 1), at(e, 2), f32::from(u8::from(e % 5 == 0))))
        .collect();
    let (least, most) = (
        values.iter().copied().fold(Vec3A::INFINITY, Vec3A::min),
        values.iter().copied().fold(Vec3A::NEG_INFINITY, Vec3A::max),
    );
    let spread = elements.spread(&values);
    for (value, spots) in values.iter().zip(spread.chunks(SPOTS as usize)) {
        let mean = spots.iter().sum::<Vec3A>() / SPOTS as f32;
        assert!(mean.distance(*value) < 1e-4, "{mean} {value}");
        for spot in spots {
            // Not by a rounding either: below 0 there is no light.
            assert!(spot.cmpge(least).all() && spot.cmple(most).all());
            // What is dark beside bright ones stays dark.
            assert!(value.z > 0.0 || spot.z == 0.0);
        }
    }
}

#[test]
fn one_element_on_a_triangle_is_even() {
    let scene = Scene {
        objects: vec![quad(1, [Vec3::ZERO, Vec3::Z, Vec3::X], 8, 0)],
        materials: vec![Default::default()],
        sky: Vec3::ONE,
        ..Scene::default()
    };
    let scene = scene.validate().unwrap();
    let settings = BakeSettings {
        elements: 10,
        ..BakeSettings::DRAFT
    };
    let pyramids = Pyramids::new(&scene, None);
    let layout = Layout::even(&scene, &settings);
    let elements = Elements::new(&scene, &Surfaces::new(&scene, &pyramids), &layout, 0.99);
    let values: Vec<Vec3A> = (0..elements.len())
        .map(|e| Vec3A::splat(e as f32))
        .collect();
    let spread = elements.spread(&values);
    for (value, spots) in values.iter().zip(spread.chunks(SPOTS as usize)) {
        assert!(spots.iter().all(|spot| spot == value));
    }
}
