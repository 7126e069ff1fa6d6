use std::sync::Arc;

use glam::{Vec3, Vec3A};

use super::Run;
use crate::radiosity::bake::BakeError;
use crate::radiosity::direct::{Sampler, loose_emission};
use crate::radiosity::element::Elements;
use crate::radiosity::element_error::Sent;
use crate::radiosity::emitter::Emitters;
use crate::radiosity::emitter_tree::EmitterTree;
use crate::radiosity::first_look::FirstLook;
use crate::radiosity::form_factor::{FormFactors, Traced, View, form_factors};
use crate::radiosity::layout::Layout;
use crate::radiosity::observer::{Observer, Stage};
use crate::radiosity::occlusion::Occluders;
use crate::radiosity::settings::BakeSettings;
use crate::radiosity::solve::{Solver, System, Watch, solve};
use crate::radiosity::surface::Surfaces;

/// How well a first look is solved: far below what its few rays leave to chance.
const TOLERANCE: f32 = 0.01;

/// Elements as the light asks for, how surfaces are cut for them, and what the first look found.
type Looked = (Arc<Elements>, Arc<Layout>, Option<FirstLook>);

/// Asks whether to stop, and tells nothing: a first look has no stages of its own.
struct Quiet<'a>(&'a dyn Observer);

impl Observer for Quiet<'_> {
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

impl Run<'_> {
    /// Cuts the patches by the light that they send, unless that was decided already.
    pub(super) fn first_look(
        &mut self,
        patches: Arc<Elements>,
        layout: Arc<Layout>,
        (surfaces, occluders): (&Surfaces, Occluders),
        emitters: &EmitterTree,
    ) -> Result<Looked, BakeError> {
        let decided = self.start.before.is_some() || self.start.plan.is_some();
        if decided || !self.settings.adapt {
            return Ok((patches, layout, None));
        }
        self.stage(Stage::FirstLook, |run| {
            // Rays are the cheapest form factors, and tell how noisy they are.
            let settings = BakeSettings {
                form_factors: FormFactors::HitList,
                solver: Solver::GaussSeidelMeanField,
                solver_tolerance: TOLERANCE,
                ..run.settings.clone()
            };
            let sampled = Emitters::at_elements(emitters, &settings);
            let view = View {
                scene: run.scene,
                occluders,
                elements: &patches,
                emitters: sampled,
                marks: &sampled.marks(&patches),
                settings: &settings,
                remember: false,
            };
            let (seen, arriving, traced) = run.look(&view)?;
            let first = FirstLook {
                elements: patches.clone(),
                halves: Sent::new(&view, &traced, &seen).spots,
                seen,
                arriving,
            };
            let layout = first.layout(run.scene, &traced, &layout, run.settings);
            let elements = run.elements(surfaces, &layout);
            Ok((elements.into(), layout.into(), Some(first)))
        })
    }

    /// What leaves the patches and form factors find, what arrives at them, and the form factors.
    fn look(&mut self, view: &View) -> Result<(Vec<Vec3A>, Vec<Vec3>, Traced), BakeError> {
        let quiet = Quiet(self.observer);
        let (traced, element_rays) = form_factors(view, None, &quiet)?;
        let (direct, rays) = Sampler::new(view).run(None, &quiet)?;
        self.work.element_rays += element_rays;
        self.work.light_rays += rays.lights;
        self.work.emitter_rays += rays.emitters;
        let (elements, scene) = (view.elements, self.scene);
        let system = System {
            elements,
            rows: &traced.rows,
            direct: &direct.arriving(scene, elements, &traced, view.marks),
        };
        let watch = Watch {
            go_on: &|| !quiet.cancelled(),
            show: &|_| (),
        };
        let solution = solve(&system, view.settings, None, &watch)?;
        self.work.sweeps += u64::from(solution.report.sweeps);
        let loose = loose_emission(elements, view.marks);
        let reflected = solution.reflected.iter();
        let seen = reflected.zip(loose).map(|(&r, e)| r + e).collect();
        Ok((seen, solution.arriving, traced))
    }
}
