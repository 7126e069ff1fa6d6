use std::time::Duration;

use glam::{DVec3, Vec3};

use super::element::Elements;
use super::emitter_tree::EmitterTree;
use super::fit::Fit;
use super::form_factor::HitList;
use super::gathered::TriangleSamples;
use super::observer::Stage;
use super::receiver_mesh::ReceiverMeshes;
use super::report::{Counts, EnergyBalance, Report, Work};
use super::settings::BakeSettings;
use super::solve::Solution;
use super::validate::{ValidScene, shines};

/// Everything a finished bake can be asked about.
pub(crate) struct Findings<'a> {
    pub(crate) scene: &'a ValidScene,
    pub(crate) settings: &'a BakeSettings,
    pub(crate) receivers: &'a ReceiverMeshes,
    pub(crate) elements: &'a Elements,
    pub(crate) tree: &'a EmitterTree,
    pub(crate) rows: &'a HitList,
    /// Direct light at each element.
    pub(crate) arrived: &'a [Vec3],
    pub(crate) solution: &'a Solution,
    pub(crate) lit_from_behind: &'a [bool],
    pub(crate) samples: &'a [TriangleSamples],
    pub(crate) fitted: &'a Fit,
    pub(crate) work: Work,
}

impl Findings<'_> {
    /// What the bake did, what it cost and how good it is.
    pub(crate) fn report(&self, stages: Vec<(Stage, Duration)>, occluder_bytes: u64) -> Report {
        let energy = self.energy();
        Report {
            stages,
            counts: self.counts(),
            bytes: occluder_bytes
                + self.elements.bytes()
                + self.rows.bytes()
                + size_of_val(self.samples) as u64,
            energy,
            solver: self.solution.report,
            sampling_error: self.fitted.smoothing.sampling_error,
            mean_light: self.fitted.mean,
            work: self.work,
            notes: self.notes(&energy),
        }
    }

    fn counts(&self) -> Counts {
        let taken: u64 = self.samples.iter().map(|s| u64::from(s.taken)).sum();
        let elements = self.elements.len() as u64;
        let shadow_rays = u64::from(self.settings.emitter_rays) * u64::from(self.tree.len() > 0)
            + self.scene.lights.len() as u64;
        let vertices_with = |flags: &[bool]| {
            let unknowns = self.receivers.meshes.iter().flat_map(|m| &m.unknown);
            unknowns.filter(|&&u| flags[u as usize]).count() as u64
        };
        Counts {
            objects: self.scene.objects.iter().filter(|o| o.receives).count() as u64,
            triangles: self.scene.triangle_count() as u64,
            vertices: self.receivers.vertex_count() as u64,
            elements,
            emitters: self.elements.emissive_triangles().count() as u64,
            lights: self.scene.lights.len() as u64,
            rays: elements * u64::from(self.settings.element_rays)
                + taken * u64::from(self.settings.gather_rays),
            shadow_rays: (elements + taken) * shadow_rays,
            samples: taken,
            invalid_samples: self.samples.iter().map(|s| u64::from(s.invalid)).sum(),
            filled_vertices: vertices_with(&self.fitted.filled),
            dark_vertices: vertices_with(&self.fitted.dark),
        }
    }

    /// Adds up where the light went, over the elements.
    fn energy(&self) -> EnergyBalance {
        let mut balance = EnergyBalance::default();
        for (e, direct) in self.arrived.iter().enumerate() {
            let area = f64::from(self.elements.area[e]);
            let reflected = self.solution.reflected[e].as_dvec3();
            balance.arrived += direct.as_dvec3() * area;
            balance.absorbed += (self.solution.arriving[e].as_dvec3() - reflected) * area;
            balance.escaped += reflected * area * (1.0 - self.rows.row_sum(e));
        }
        // Areas are in internal units.
        let unit = f64::from(self.scene.scale).powi(2);
        EnergyBalance {
            arrived: balance.arrived * unit,
            absorbed: balance.absorbed * unit,
            escaped: balance.escaped * unit,
        }
    }

    /// What was mended, skipped or looks wrong.
    fn notes(&self, energy: &EnergyBalance) -> Vec<String> {
        let mut notes = self.scene.notes.clone();
        if self.elements.clamped > 0 {
            notes.push(format!(
                "{} elements reflect more than {} of the light and were clamped to it",
                self.elements.clamped, self.settings.max_reflectance
            ));
        }
        for (o, object) in self.scene.objects.iter().enumerate() {
            if self.lit_from_behind[o] {
                notes.push(format!(
                    "object \"{}\" is double-sided and lit from behind: its vertices carry the light of the back",
                    object.name
                ));
            }
            let dark = self.receivers.meshes[o]
                .unknown
                .iter()
                .filter(|&&u| self.fitted.dark[u as usize])
                .count();
            if dark > 0 {
                notes.push(format!(
                    "object \"{}\": {dark} vertices belong to pieces of mesh wholly inside other geometry and stay black",
                    object.name
                ));
            }
        }
        let solver = &self.solution.report;
        if !solver.converged {
            notes.push(format!(
                "the solver stopped after {} sweeps with an error of at most {:.2e}: raise max_sweeps or the tolerance",
                solver.sweeps, solver.error_bound
            ));
        }
        if !shines(self.scene) {
            notes.push("nothing in the scene emits light: the baked light is black".into());
        } else if energy.arrived == DVec3::ZERO {
            notes.push(
                "no light reaches any surface, the result is black: check where lights are, and which way \
                 one-sided emitters face"
                    .into(),
            );
        }
        notes
    }
}
