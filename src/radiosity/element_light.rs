use std::sync::Arc;

use glam::Vec3;

use super::element::{ElementId, Elements};
use super::form_factor::Traced;
use super::report::Report;
use super::scene::ObjectId;
use super::solve::Solution;
use super::validate::ValidScene;

/// The light of a scene's elements, before it is gathered at vertices.
///
/// Light is linear RGB radiance in cd/m², so irradiance and radiosity are divided by π.
pub struct ElementLight {
    /// All elements, those of an object one after the other.
    pub elements: Vec<Element>,
    /// What it cost and how good it is. Nothing in it is about vertices.
    pub report: Report,
    triangles: Vec<ElementTriangle>,
    traced: Arc<Traced>,
}

/// A piece of surface of constant light, one side of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// The object it is part of.
    pub object: ObjectId,
    /// Its centre of area, in metres.
    pub center: Vec3,
    /// Mean unit normal of its side.
    pub normal: Vec3,
    /// In square metres, without the part that lets light pass.
    pub area: f32,
    /// Reflectance ρ, 0..1.
    pub reflectance: Vec3,
    /// Emitted radiance.
    pub emission: Vec3,
    /// Direct light that arrives, of lights, sky and emissive surfaces: irradiance / π.
    pub direct: Vec3,
    /// All light that arrives, `H`: irradiance / π.
    pub irradiance: Vec3,
    /// Light that leaves, `B = E + ρ H`: radiosity / π.
    pub radiosity: Vec3,
}

/// A flat part of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementTriangle {
    /// Its place in [`ElementLight::elements`].
    pub element: u32,
    /// In metres, wound as the surface is.
    pub corners: [Vec3; 3],
    /// Unit normal of the element's side.
    pub normal: Vec3,
    /// Whether that is the back of the surface.
    pub back: bool,
}

impl std::fmt::Debug for ElementLight {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("ElementLight")
            .field("elements", &self.elements)
            .field("report", &self.report)
            .finish_non_exhaustive()
    }
}

impl ElementLight {
    pub(crate) fn new(
        scene: &ValidScene,
        elements: &Elements,
        traced: Arc<Traced>,
        arrived: &[Vec3],
        solution: &Solution,
        report: Report,
    ) -> Self {
        let metres =
            |point: Vec3| (point.as_dvec3() * f64::from(scene.scale) + scene.center).as_vec3();
        let triangles = |e: usize| {
            let shape = elements.shape(scene, ElementId(e as u32));
            shape.map(move |(_, corners, normal)| ElementTriangle {
                element: e as u32,
                corners: corners.map(metres),
                normal,
                back: elements.is_back(e),
            })
        };
        let triangles = (0..elements.len()).flat_map(triangles).collect();
        let objects = (0..scene.objects.len()).flat_map(|o| elements.of_object(o).map(move |_| o));
        let element = |(e, o): (usize, usize)| {
            let (center, normal) = elements.middle(scene, ElementId(e as u32));
            Element {
                object: ObjectId(o as u32),
                center: metres(center),
                normal,
                area: elements.area[e] * scene.scale * scene.scale,
                reflectance: elements.reflectance[e],
                emission: elements.emission[e],
                direct: arrived[e],
                irradiance: solution.arriving[e],
                radiosity: elements.emission[e] + Vec3::from(solution.reflected[e]),
            }
        };
        Self {
            elements: objects.enumerate().map(element).collect(),
            report,
            triangles,
            traced,
        }
    }

    /// The flat parts of all elements, those of an element one after the other.
    pub fn triangles(&self) -> &[ElementTriangle] {
        &self.triangles
    }

    /// The form factor from element `i` to element `j`: the share of the light leaving `i` that
    /// reaches `j`.
    ///
    /// Takes as long as the row is; [`Self::row`] is for more of them.
    pub fn form_factor(&self, i: usize, j: usize) -> f64 {
        let mut sum = 0.0;
        self.traced.rows.each(i, |id, weight| {
            sum += f64::from(u8::from(id as usize == j)) * f64::from(weight);
        });
        sum
    }

    /// All form factors from element `i`.
    pub fn row(&self, i: usize) -> Vec<f64> {
        let mut row = vec![0.0; self.elements.len()];
        let mut add = |id: u32, weight: f32| row[id as usize] += f64::from(weight);
        self.traced.rows.each(i, &mut add);
        row
    }

    /// The sum of all form factors from element `i`: 1 where nothing escapes.
    pub fn row_sum(&self, i: usize) -> f64 {
        self.traced.rows.row_sum(i)
    }
}
