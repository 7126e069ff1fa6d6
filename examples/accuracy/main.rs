//! Speed against accuracy of all methods, in charts: `cargo accuracy`.
//!
//! | file | |
//! |---|---|
//! | `plan` | how much is measured |
//! | `scenes` | what is lit |
//! | `methods` | what is swept |
//! | `measure` | a run and what it took |
//! | `reference` | what runs are compared with |
//! | `metrics` | how far they are off |
//! | `sweep` | every method with every budget on one scene |
//! | `studies` | solvers, numbers of elements, vertices |
//! | `refinement`, `refinement_charts` | vertices placed by the light, and spread evenly |
//! | `kernels` | normals of bumps, by kernels of height maps |
//! | `displacement`, `displaced_error` | relief by vertices where they are needed, and spread evenly |
//! | `known` | scenes whose light is known at every point, shared with tests |
//! | `results` | all that was measured, and who won |
//! | `csv`, `charts`, `chart`, `svg`, `markdown`, `reading`, `text` | how it is told |

#![expect(clippy::print_stderr, reason = "a program that says how far it is")]

mod chart;
mod charts;
mod csv;
#[path = "../../tests/displacement/measure.rs"]
mod displaced_error;
mod displacement;
mod kernels;
#[path = "../../tests/common/known/mod.rs"]
mod known;
mod markdown;
mod measure;
mod methods;
mod metrics;
mod plan;
mod reading;
mod reference;
mod refinement;
mod refinement_charts;
mod results;
mod scenes;
mod studies;
mod svg;
mod sweep;
mod text;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use charts::Named;
use plan::Plan;
use reference::Reference;
use results::Results;
use scenes::SUBJECTS;

fn main() -> ExitCode {
    let plan = match Plan::read(std::env::args().skip(1)) {
        Ok(plan) => plan,
        Err(why) => {
            eprintln!("{why}");
            return ExitCode::FAILURE;
        }
    };
    match measure(&plan).and_then(|results| write(&plan, &results)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

fn measure(plan: &Plan) -> Result<Results, Box<dyn Error>> {
    let start = Instant::now();
    let say = |what: &str| eprintln!("{:4.0} s  {what}", start.elapsed().as_secs_f64());
    let mut results = Results {
        quick: plan.quick,
        ..Results::default()
    };
    for subject in SUBJECTS.iter().filter(|s| plan.wants(s.id)) {
        for size in plan.sizes(subject.sizes) {
            say(&format!(
                "{} {}, about {size} elements",
                subject.id, subject.name
            ));
            let scene = (subject.build)(size).validate()?;
            let mut reference = Reference::find(subject, &scene, size, plan)?;
            reference.ask_second(&scene, size, subject.judged)?;
            results
                .points
                .extend(sweep::sweep(subject, &scene, size, &reference, plan)?);
            results.references.push(reference);
        }
    }
    if plan.wants("solvers") {
        say("solvers");
        results.solved = studies::solvers(plan)?;
    }
    if plan.wants("elements") {
        say("elements");
        results.refined = studies::elements(plan)?;
    }
    if plan.wants("vertices") {
        say("vertices");
        results.at_vertices = studies::vertices(plan)?;
    }
    if plan.wants("refinement") {
        results.used = refinement::study(plan, say)?;
    }
    if plan.wants("kernels") {
        say("kernels");
        results.kernels = kernels::study()?;
    }
    if plan.wants("displacement") {
        results.raised = displacement::study(plan, say)?;
    }
    say("measured");
    Ok(results)
}

/// Charts and table of a study alone, the other files and the report left as they are.
struct Part {
    table: &'static str,
    csv: String,
    charts: Vec<Named>,
}

impl Part {
    fn of_refinement(results: &Results) -> Self {
        Self {
            table: "refinement.csv",
            csv: refinement::csv(&results.used),
            charts: refinement_charts::charts(&results.used),
        }
    }

    fn of_kernels(results: &Results) -> Self {
        Self {
            table: "kernels.csv",
            csv: kernels::csv(&results.kernels),
            charts: kernels::charts(&results.kernels),
        }
    }

    fn of_displacement(results: &Results) -> Self {
        Self {
            table: "displacement.csv",
            csv: displacement::csv(&results.raised),
            charts: displacement::charts(&results.raised),
        }
    }

    fn write(self, folder: &Path) -> Result<(), Box<dyn Error>> {
        std::fs::write(folder.join(self.table), self.csv)?;
        for (name, chart) in self.charts {
            std::fs::write(folder.join(name), chart.draw())?;
        }
        Ok(())
    }
}

/// What was measured into a folder: of one study alone, or all with the report beside it.
fn write(plan: &Plan, results: &Results) -> Result<(), Box<dyn Error>> {
    let folder = &plan.out;
    std::fs::create_dir_all(folder)?;
    let parts: [(&str, fn(&Results) -> Part); 3] = [
        ("refinement", Part::of_refinement),
        ("kernels", Part::of_kernels),
        ("displacement", Part::of_displacement),
    ];
    if let Some((_, part)) = parts.iter().find(|(name, _)| plan.only_wants(name)) {
        part(results).write(folder)?;
        eprintln!("written to {}", folder.display());
        return Ok(());
    }
    for (_, part) in parts {
        part(results).write(folder)?;
    }
    std::fs::write(folder.join("accuracy.csv"), csv::accuracy(results))?;
    std::fs::write(folder.join("solvers.csv"), csv::solvers(&results.solved))?;
    std::fs::write(folder.join("elements.csv"), csv::elements(&results.refined))?;
    for (name, chart) in charts::all(results) {
        std::fs::write(folder.join(name), chart.draw())?;
    }
    let name = folder
        .file_name()
        .map_or_else(|| ".".into(), |n| n.to_string_lossy());
    let report = markdown::report(results, &name);
    std::fs::write(folder.with_extension("md"), report)?;
    eprintln!(
        "written to {} and {}",
        folder.display(),
        folder.with_extension("md").display()
    );
    Ok(())
}
