use std::time::Duration;

use glam::{DVec3, Vec3};

use super::element::Elements;
use super::emitter_tree::{EmitterTree, WIDE};
use super::form_factor::{FormFactors, Traced};
use super::observer::Stage;
use super::pipeline::Pass;
use super::report::{Counts, EnergyBalance, ErrorEstimate, Report, Stopped, Work};
use super::sampling_error::SamplingError;
use super::settings::BakeSettings;
use super::solve::Solution;
use super::validate::{ValidScene, shines};

/// Estimates of sampling errors are raised by this, so that they are above the true ones in more than
/// 95 of 100 bakes (`tests/sampling_error.rs`) and not in every other: half-sets are smoothed by what they
/// have in common, and a few elements stand for all.
pub(crate) const COVER: f32 = 1.25;

/// Light that is expected to err by more than this share is worth a note.
const NOISY: f64 = 0.1;

/// What the solution of the elements can be asked about.
pub(crate) struct Findings<'a> {
    pub(crate) scene: &'a ValidScene,
    pub(crate) settings: &'a BakeSettings,
    pub(crate) elements: &'a Elements,
    pub(crate) tree: &'a EmitterTree,
    pub(crate) traced: &'a Traced,
    /// Direct light at each element.
    pub(crate) arrived: &'a [Vec3],
    pub(crate) solution: &'a Solution,
    /// Errors of elements, beside all light.
    pub(crate) error: SamplingError,
    /// How many times as much they are beside the light of vertices, which may be a part of it.
    pub(crate) enlarged: f32,
    pub(crate) stages: &'a [(Stage, Duration)],
    pub(crate) work: Work,
    pub(crate) occluder_bytes: u64,
}

/// What the light of vertices can be asked about.
pub(crate) struct VertexFindings<'a> {
    pub(crate) pass: &'a Pass,
    pub(crate) lit_from_behind: &'a [bool],
}

impl Findings<'_> {
    /// What the bake did, what it cost and how good it is.
    pub(crate) fn report(&self, vertices: Option<&VertexFindings>) -> Report {
        let energy = self.energy();
        let mut notes = self.notes();
        notes.extend(self.lamps_left_to_chance(vertices.is_some()));
        notes.extend(vertices.iter().flat_map(|v| v.notes(self.scene)));
        notes.extend(self.darkness(&energy));
        Report {
            stages: self.stages.to_vec(),
            counts: self.counts(vertices),
            bytes: self.occluder_bytes
                + self.elements.bytes()
                + self.traced.rows.bytes()
                + self.solution.report.bytes
                + vertices.map_or(0, |v| v.pass.inside.bytes()),
            energy,
            error: vertices.map_or_else(ErrorEstimate::default, |v| self.error(v)),
            stopped: vertices.map_or_else(Stopped::default, |v| v.pass.stopped),
            form_factors: self.traced.report.clone(),
            solver: self.solution.report.clone(),
            element_error: COVER * self.error.elements,
            sampling_error: vertices.map_or(0.0, |v| self.sampling_error(v)),
            mean_light: vertices.map_or(0.0, |v| v.pass.fitted.mean),
            work: self.work,
            notes,
        }
    }

    fn sampling_error(&self, vertices: &VertexFindings) -> f32 {
        COVER
            * (vertices.pass.fitted.smoothing.sampling_error)
                .hypot(self.enlarged * self.error.vertices)
    }

    /// How far off the vertices' light is, by source.
    fn error(&self, vertices: &VertexFindings) -> ErrorEstimate {
        let Some(control) = vertices.pass.control else {
            return ErrorEstimate::new(
                0.0,
                self.sampling_error(vertices),
                self.enlarged * self.error.cells,
                self.solver_error(),
            );
        };
        // What points apart from the samples found is made of what the mesh and what chance left there.
        let found = control.found.bound() as f32;
        let by_chance = vertices.pass.fitted.smoothing.sampling_error.min(found);
        let meshing = (found * found - by_chance * by_chance).max(0.0).sqrt();
        let sampling = by_chance.hypot(COVER * self.enlarged * self.error.vertices);
        ErrorEstimate::new(
            meshing,
            sampling,
            self.enlarged * self.error.cells,
            self.solver_error(),
        )
    }

    fn solver_error(&self) -> f32 {
        let mean = self.elements.mean_of(&self.solution.arriving);
        if mean > 0.0 {
            self.enlarged * (self.solution.report.error_bound / mean) as f32
        } else {
            0.0
        }
    }

    /// What the light of elements adds to the error of vertices.
    pub(crate) fn error_of_elements(&self) -> f64 {
        let noise =
            (COVER * self.enlarged * self.error.vertices).hypot(self.enlarged * self.error.cells);
        f64::from(noise.hypot(self.solver_error()))
    }

    fn counts(&self, vertices: Option<&VertexFindings>) -> Counts {
        let elements = self.elements.len() as u64;
        let shadow_rays = u64::from(self.settings.emitter_rays) * u64::from(self.tree.len() > 0)
            + self.scene.lights.len() as u64;
        let counts = vertices.map_or_else(Counts::default, VertexFindings::counts);
        Counts {
            objects: self.scene.objects.iter().filter(|o| o.receives).count() as u64,
            triangles: self.scene.triangle_count() as u64,
            elements,
            emitters: self.elements.emissive_triangles().count() as u64,
            lights: self.scene.lights.len() as u64,
            rays: self.element_rays() + counts.samples * u64::from(self.settings.gather_rays),
            shadow_rays: (elements + counts.samples) * shadow_rays,
            ..counts
        }
    }

    /// Rays of all elements, where form factors are made of rays.
    fn element_rays(&self) -> u64 {
        match self.settings.form_factors {
            FormFactors::HitList => self.elements.rays.iter().map(|&rays| u64::from(rays)).sum(),
            _ => 0,
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
            balance.escaped += reflected * area * (1.0 - self.traced.rows.row_sum(e));
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
    fn notes(&self) -> Vec<String> {
        let mut notes = self.scene.notes.clone();
        if self.elements.clamped > 0 {
            notes.push(format!(
                "{} elements reflect more than {} of the light and were clamped to it",
                self.elements.clamped, self.settings.max_reflectance
            ));
        }
        let solver = &self.solution.report;
        if let Some(given_up) = solver.fell_back {
            notes.push(format!(
                "the residual of the solver, {}, grew three sweeps running; {} went on from its best: {}",
                given_up.name(),
                solver.solver.name(),
                given_up.cure()
            ));
        }
        if !solver.converged {
            notes.push(format!(
                "the solver stopped after {} sweeps with an error of at most {:.2e}: raise max_sweeps or the tolerance",
                solver.sweeps, solver.error_bound
            ));
        }
        notes
    }

    /// Emitters that would be sampled, are not, and are hard to find by chance.
    ///
    /// Of `S` rays a share `F` finds emitters that fill the share `F` of the view, so many that
    /// their number is known to
    ///
    /// ```text
    ///   √(S F (1 − F)) of S F      ┌─────────────────────┐
    ///                              │  error ≈ 1 / √(S F) │    F ≪ 1
    ///                              └─────────────────────┘
    /// ```
    fn lamps_left_to_chance(&self, at_vertices: bool) -> Option<String> {
        let share = if self.settings.sample_emitters {
            0.0
        } else {
            self.view_of_lamps()
        };
        let (rays, place) = match self.settings.form_factors {
            _ if at_vertices => {
                let rays = f64::from(self.settings.gather_rays);
                (
                    rays * f64::from(self.settings.samples_per_vertex),
                    "vertices",
                )
            }
            FormFactors::HitList => (f64::from(self.settings.element_rays), "elements"),
            // These err by aliasing or by shadows, not by the number of rays.
            _ => return None,
        };
        let error = 1.0 / (rays * share).sqrt();
        (share > 0.0 && error > NOISY).then(|| {
            format!(
                "emissive surfaces fill {:.2} % of the view and are left to rays, {rays} for each of the {place}: \
                 expect their light to err by {:.0} %, or set sample_emitters",
                100.0 * share,
                100.0 * error
            )
        })
    }

    /// The share of the view that emissive materials fill which are small enough to be sampled,
    /// averaged over all surfaces. By reciprocity an emitter is seen as it sees:
    /// `Σ_i A_i F_ij = A_j Σ_i F_ji`, which finds the smallest lamp.
    fn view_of_lamps(&self) -> f64 {
        let elements = self.elements;
        let mut views = vec![0.0; self.scene.materials.len()];
        for (o, object) in self.scene.objects.iter().enumerate() {
            let shine = |&e: &usize| elements.emission[e] != Vec3::ZERO;
            let seen = |e: usize| f64::from(elements.area[e]) * self.traced.rows.row_sum(e);
            views[object.material.0 as usize] +=
                elements.of_object(o).filter(shine).map(seen).sum::<f64>();
        }
        let all: f64 = elements.area.iter().map(|&a| f64::from(a)).sum();
        let shares = views.iter().map(|view| view / all.max(f64::MIN_POSITIVE));
        shares.filter(|&share| share <= f64::from(WIDE)).sum()
    }

    /// Why the result is black, if it is.
    fn darkness(&self, energy: &EnergyBalance) -> Option<String> {
        if !shines(self.scene) {
            Some("nothing in the scene emits light: the baked light is black".into())
        } else if energy.arrived == DVec3::ZERO {
            Some(
                "no light reaches any surface, the result is black: check where lights are, and which way \
                 one-sided emitters face"
                    .into(),
            )
        } else {
            None
        }
    }
}

impl VertexFindings<'_> {
    fn counts(&self) -> Counts {
        let samples = &self.pass.inside.smooth.samples;
        let vertices_with = |flags: &[bool]| {
            let unknowns = self
                .pass
                .receivers
                .fine
                .meshes
                .iter()
                .flat_map(|m| &m.unknown);
            unknowns.filter(|&&u| flags[u as usize]).count() as u64
        };
        Counts {
            vertices: self.pass.receivers.fine.vertex_count() as u64,
            samples: samples.iter().map(|s| u64::from(s.taken)).sum(),
            invalid_samples: samples.iter().map(|s| u64::from(s.invalid)).sum(),
            filled_vertices: vertices_with(&self.pass.fitted.filled),
            dark_vertices: vertices_with(&self.pass.fitted.dark),
            ..Counts::default()
        }
    }

    fn notes(&self, scene: &ValidScene) -> Vec<String> {
        let mut notes = Vec::new();
        for (o, object) in scene.objects.iter().enumerate() {
            if self.lit_from_behind[o] {
                notes.push(format!(
                    "object \"{}\" is double-sided and lit from behind: its vertices carry the light of the back",
                    object.name
                ));
            }
            let dark = self.pass.receivers.fine.meshes[o]
                .unknown
                .iter()
                .filter(|&&u| self.pass.fitted.dark[u as usize])
                .count();
            // What was cut off where others stand on it is meant to be inside them.
            let is_cut = scene.cuts.get(o).is_some_and(Option::is_some);
            if dark > 0 && !is_cut {
                notes.push(format!(
                    "object \"{}\": {dark} vertices belong to pieces of mesh wholly inside other geometry and stay black",
                    object.name
                ));
            }
        }
        notes
    }
}
