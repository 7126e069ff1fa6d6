//! The report: charts, tables and what they say.

use crate::charts::file;
use crate::csv::threads;
use crate::methods::{FAMILIES, LAMP_RAYS, SOLVERS};
use crate::metrics::{Metrics, cost_of};
use crate::reading::{lamps, which_when};
use crate::reference::{Reference, SECOND_RAYS};
use crate::refinement_charts;
use crate::results::{GOALS, Results};
use crate::studies::{AT_POINTS, BY_RAYS, CONTINUUM, REFLECTANCES, Solved};
use crate::text::{count, percent, seconds};

/// The whole report; `folder` is where charts lie as seen from it.
pub(crate) fn report(results: &Results, folder: &str) -> String {
    let chapters = [
        opening(results, folder),
        chapter("Which method when", &which_when(results)),
        chapter("Time to an error", &times_to_goals(results)),
        chapter("Scene by scene", &scenes(results, folder)),
        chapter("Lamps: sampled or found", &lamp_chapter(results, folder)),
        chapter("Solvers", &solver_chapter(results, folder)),
        chapter("How many elements", &element_chapter(results, folder)),
        chapter("Memory", &memory_chapter(results, folder)),
        chapter("What is left at vertices", &vertex_chapter(results)),
        chapter(
            "Vertices used, and spread evenly",
            &refinement_charts::chapter(&results.used, folder),
        ),
        chapter("All measures of one sweep", &all_measures(results)),
        chapter("References", &references(&results.references)),
        chapter("How it was measured", &protocol(results)),
    ];
    chapters.concat()
}

fn chapter(title: &str, text: &str) -> String {
    if text.is_empty() {
        return String::new();
    }
    format!("\n## {title}\n\n{text}")
}

fn opening(results: &Results, folder: &str) -> String {
    let quick = if results.quick {
        "\n> This is a quick run, with few points and short references. Leave out `--quick` for the real one.\n"
    } else {
        ""
    };
    format!(
        "# Speed against accuracy\n\n\
         Methods of finding form factors, solvers and numbers of elements, measured on nine scenes. \
         This file is written by the program that measures, prose with figures included:\n\n\
         ```sh\ncargo accuracy\n```\n{quick}\n\
         Every point is also a row of [accuracy.csv]({folder}/accuracy.csv), with the errors of \
         bounced, direct and all light by seven measures.\n"
    )
}

/// A row of a table.
fn row(cells: &[String]) -> String {
    format!("| {} |\n", cells.join(" | "))
}

pub(crate) fn table(header: &[String], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let rule: Vec<String> = header.iter().map(|_| "---".into()).collect();
    let rows: String = rows.into_iter().map(|cells| row(&cells)).collect();
    row(header) + &row(&rule) + &rows
}

pub(crate) fn strings(cells: &[&str]) -> Vec<String> {
    cells.iter().map(|&c| c.into()).collect()
}

/// For each goal, seconds by scene, size and method; the fastest bold.
fn times_to_goals(results: &Results) -> String {
    let races = results.races();
    let mut text = String::from(
        "Time for form factors and solving, read off the lines between points; – where the method \
         did not come there in the time it had. Goals below the floor of a reference are left out.\n",
    );
    for goal in GOALS {
        let rows = races
            .iter()
            .filter(|r| r.goal == goal && r.winner().is_some());
        let cells = rows.map(|race| {
            let fastest = race
                .seconds
                .iter()
                .flatten()
                .copied()
                .fold(f64::INFINITY, f64::min);
            let time = |t: &Option<f64>| match t {
                Some(t) if *t <= fastest => format!("**{}**", seconds(*t)),
                Some(t) => seconds(*t),
                None => "–".into(),
            };
            let mut cells = vec![
                format!("{} {}", race.subject.id, race.subject.name),
                count(u64::from(race.size)),
            ];
            cells.extend(race.seconds.iter().map(time));
            cells
        });
        let cells: Vec<Vec<String>> = cells.collect();
        if cells.is_empty() {
            continue;
        }
        let names = FAMILIES.iter().map(|f| f.name);
        let header: Vec<&str> = ["scene", "elements, about"]
            .into_iter()
            .chain(names)
            .collect();
        text += &format!(
            "\n**To {}**\n\n{}",
            percent(goal),
            table(&strings(&header), cells)
        );
    }
    text
}

fn scenes(results: &Results, folder: &str) -> String {
    let mut text = String::new();
    let mut last = "";
    for (subject, size, elements) in results.stages() {
        if subject.id != last {
            text += &format!(
                "### {} {}\n\n{}.\n\n",
                subject.id, subject.name, subject.about
            );
            last = subject.id;
        }
        if results
            .of((subject.id, size), &FAMILIES[1])
            .next()
            .is_some()
        {
            let name = file(subject, size);
            let alt = format!("{}, {elements} elements", subject.name);
            text += &format!("![{alt}]({folder}/{name})\n\n");
        }
    }
    text
}

fn lamp_chapter(results: &Results, folder: &str) -> String {
    let told = lamps(results);
    if told.is_empty() {
        return told;
    }
    let charts = results
        .stages()
        .into_iter()
        .filter(|s| s.0.compares_lamps && s.1 == 1000);
    let charts = charts.map(|(subject, ..)| {
        let id = subject.id.to_lowercase();
        format!("\n![Lamps of {}]({folder}/lamps_{id}.svg)\n", subject.name)
    });
    let intro = "The first radiosity programs left lamps to form factors like any other surface. \
                 Here lamps are sampled, unless `sample_emitters` is off:\n\n";
    intro.to_owned() + &told + &charts.collect::<String>()
}

fn solver_chapter(results: &Results, folder: &str) -> String {
    if results.solved.is_empty() {
        return String::new();
    }
    let of = |name: &str, reflectance: f32| {
        let is = |s: &&Solved| s.solver == name && s.reflectance == reflectance;
        results.solved.iter().find(is)
    };
    let measured = || {
        REFLECTANCES
            .into_iter()
            .filter(|&r| of(SOLVERS[0].0, r).is_some())
    };
    let header: Vec<String> = (std::iter::once("solver".into()))
        .chain(measured().map(|r| format!("ρ {r}")))
        .collect();
    let sweeps = |s: &Solved| {
        if s.converged {
            s.sweeps.to_string()
        } else {
            "–".into()
        }
    };
    let rows = SOLVERS.iter().map(|(name, _)| {
        let cells = measured().map(|r| of(name, r).map_or_else(String::new, sweeps));
        std::iter::once((*name).to_owned()).chain(cells).collect()
    });
    let told = |s: &&Solved| s.converged && s.error > 0.0;
    let loose = results
        .solved
        .iter()
        .filter(told)
        .map(|s| s.bound / s.error);
    let tightest = loose.fold(f64::INFINITY, f64::min);
    format!(
        "Sweeps until the bound on the error is below 1e-4 of the mean, in a closed room of one \
         reflectance with a column (S6, about 1,000 elements). Shooting counts one sweep for as many \
         shots as there are elements.\n\n{}\n![Sweeps of solvers]({folder}/solvers.svg)\n\n\
         The bound that a solver reports was at least {} the error it had. All figures are in \
         [solvers.csv]({folder}/solvers.csv).\n",
        table(&header, rows),
        format_args!("{tightest:.1} times")
    )
}

fn element_chapter(results: &Results, folder: &str) -> String {
    if results.refined.is_empty() {
        return String::new();
    }
    let order = |series: &str| {
        let of: Vec<_> = results
            .refined
            .iter()
            .filter(|r| r.series == series)
            .collect();
        let (first, last) = (of.first()?, of.last()?);
        let falls =
            (first.error / last.error).ln() / (last.elements as f64 / first.elements as f64).ln();
        Some(format!(
            "- {series}: {} on {} elements, {} on {}; falls as elements to the power of −{falls:.2}\n",
            percent(first.error),
            count(first.elements as u64),
            percent(last.error),
            count(last.elements as u64)
        ))
    };
    let told: String = [CONTINUUM, BY_RAYS, AT_POINTS]
        .into_iter()
        .filter_map(order)
        .collect();
    format!(
        "The unit cube has answers for the continuum, so this is the error of elements being flat in \
         light, with the error of the method next to it:\n\n{told}\n\
         ![Error by elements]({folder}/elements.svg)\n\nAll figures are in \
         [elements.csv]({folder}/elements.csv).\n"
    )
}

fn memory_chapter(results: &Results, folder: &str) -> String {
    if results.of(("S3", 1000), &FAMILIES[0]).next().is_none() {
        return String::new();
    }
    format!("![Memory by error]({folder}/memory.svg)\n")
}

fn vertex_chapter(results: &Results) -> String {
    let rows = results.at_vertices.iter().map(|v| {
        vec![
            v.method.to_owned(),
            v.budget.to_string(),
            percent(v.error),
            seconds(v.seconds),
        ]
    });
    let rows: Vec<Vec<String>> = rows.collect();
    let Some(one) = results.at_vertices.first() else {
        return String::new();
    };
    let header = strings(&["method", "knob", "error at vertices", "whole bake"]);
    format!(
        "Light at vertices is gathered by rays from the light of elements, whatever the method. Here \
         it is the Cornell box at {} vertices, about 1,000 elements and 128 gathering rays a sample, \
         against a long bake on 4,000 elements:\n\n{}",
        count(one.vertices as u64),
        table(&header, rows)
    )
}

/// Every measure of every point on the Cornell box.
fn all_measures(results: &Results) -> String {
    let stage = ("S3", 1000);
    let rows = FAMILIES.iter().flat_map(|family| {
        results.of(stage, family).map(|(point, m)| {
            let mut cells = vec![
                family.name.to_owned(),
                point.budget.to_string(),
                seconds(m.cost.bounces()),
            ];
            cells.extend(m.errors.bounced.values().map(percent));
            cells
        })
    });
    let rows: Vec<Vec<String>> = rows.collect();
    if rows.is_empty() {
        return String::new();
    }
    let names = [
        "relative L2",
        "RMS / mean",
        "largest / mean",
        "p95",
        "p99",
        "gain",
        "area off by > 5 %",
    ];
    debug_assert_eq!(names.len(), Metrics::NAMES.len(), "a name for each");
    let header: Vec<&str> = ["method", "knob", "time"]
        .into_iter()
        .chain(names)
        .collect();
    let intro = "Bounced light of the Cornell box on about 1,000 elements. p95 and p99 are relative \
                 errors that so much of the area stays below; gain is the signed mean.\n\n";
    intro.to_owned() + &table(&strings(&header), rows)
}

fn references(references: &[Reference]) -> String {
    let row = |r: &Reference| {
        let second = r.second.map_or_else(
            || strings(&["", "", ""]),
            |s| {
                let verdict = if s.agrees() { "agree" } else { "differ" };
                vec![
                    percent(s.difference.l2),
                    percent(s.expected),
                    verdict.into(),
                ]
            },
        );
        let mut cells = vec![
            r.subject.to_owned(),
            count(r.elements as u64),
            format!("{} × {}", r.runs, count(u64::from(r.rays))),
            percent(r.standard_error),
            if r.floor > 0.0 {
                percent(r.floor)
            } else {
                "none".into()
            },
        ];
        cells.extend(second);
        cells
    };
    let header = strings(&[
        "scene",
        "elements",
        "runs × rays",
        "standard error",
        "floor",
        "second reference off by",
        "expected",
        "",
    ]);
    format!(
        "Light of the same elements, the mean of long hit lists with other seeds. Errors below three \
         standard errors are not told from those of the reference: that is the floor, grey in the \
         charts, where points are hollow. S2 has a closed form and needs \
         no floor: what is left there is that flat elements are no sphere. The second reference shares only the ray \
         hierarchy with the first: analytic form factors with {SECOND_RAYS} shadow rays a pair, several \
         seeds. It agrees if it is off by less than twice what the standard errors of both make \
         expect.\n\n{}",
        table(&header, references.iter().map(row))
    )
}

fn protocol(results: &Results) -> String {
    let skipped = results
        .points
        .iter()
        .filter(|p| p.measured().is_none())
        .count();
    let fastest = results.line(("S3", 1000), &FAMILIES[0]);
    let example = cost_of(0.02, &fastest).map_or_else(String::new, |time| {
        format!(" (a hit list to 2 % on the Cornell box: {})", seconds(time))
    });
    format!(
        "- {} threads. Times are wall clock; the processor time of all threads and the peak of \
         resident memory are in the CSV where Linux tells them. They depend on the machine{example}; \
         ratios depend on it less.\n\
         - A point is the median of several runs with seeds from 1 on, of each figure by itself. A run \
         that takes longer than the limit is not repeated, and budgets expected to take longer from the \
         one before are skipped: {skipped} of {} points, named in the CSV.\n\
         - Direct light is sampled with {LAMP_RAYS} shadow rays an element for all methods. Errors are \
         those of bounced light, which is what form factors are for; time is that of form factors and \
         solving. On S2 and in the charts of lamps it is all light.\n\
         - Errors are of luminance, weighted by area, without elements that emit (on S2 with them).\n\
         - The reference is the mean over an element. A hemicube looks from the middle of it: what \
         differs between the two stays however many pixels it has, and goes with smaller elements.\n",
        threads(),
        results.points.len()
    )
}
