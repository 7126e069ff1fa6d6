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
    let write = match &plan {
        plan if plan.only_wants("refinement") => write_refinement,
        plan if plan.only_wants("kernels") => write_kernels,
        plan if plan.only_wants("displacement") => write_displacement,
        _ => write,
    };
    match measure(&plan).and_then(|results| write(&results, &plan.out)) {
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

/// Charts and table of this study alone, the other files and the report left as they are.
fn write_refinement(results: &Results, folder: &Path) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    std::fs::write(
        folder.join("refinement.csv"),
        refinement::csv(&results.used),
    )?;
    for (name, chart) in refinement_charts::charts(&results.used) {
        std::fs::write(folder.join(name), chart.draw())?;
    }
    eprintln!("written to {}", folder.display());
    Ok(())
}

/// The same of this study.
fn write_kernels(results: &Results, folder: &Path) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    std::fs::write(folder.join("kernels.csv"), kernels::csv(&results.kernels))?;
    for (name, chart) in kernels::charts(&results.kernels) {
        std::fs::write(folder.join(name), chart.draw())?;
    }
    eprintln!("written to {}", folder.display());
    Ok(())
}

/// The same of displacement.
fn write_displacement(results: &Results, folder: &Path) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    std::fs::write(
        folder.join("displacement.csv"),
        displacement::csv(&results.raised),
    )?;
    for (name, chart) in displacement::charts(&results.raised) {
        std::fs::write(folder.join(name), chart.draw())?;
    }
    eprintln!("written to {}", folder.display());
    Ok(())
}

/// Charts and tables into a folder, the report beside it.
fn write(results: &Results, folder: &Path) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    std::fs::write(folder.join("accuracy.csv"), csv::accuracy(results))?;
    std::fs::write(folder.join("solvers.csv"), csv::solvers(&results.solved))?;
    std::fs::write(folder.join("elements.csv"), csv::elements(&results.refined))?;
    std::fs::write(
        folder.join("refinement.csv"),
        refinement::csv(&results.used),
    )?;
    std::fs::write(folder.join("kernels.csv"), kernels::csv(&results.kernels))?;
    write_displacement(results, folder)?;
    let used = refinement_charts::charts(&results.used);
    let of_kernels = kernels::charts(&results.kernels);
    for (name, chart) in charts::all(results)
        .into_iter()
        .chain(used)
        .chain(of_kernels)
    {
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
