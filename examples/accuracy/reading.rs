//! Which method when: sentences made from the figures, so that they cannot say anything else.

use crate::methods::{FAMILIES, Family, LAMPS};
use crate::metrics::cost_of;
use crate::results::{Race, Results, Standing, standings};
use crate::text::{count, list, percent, seconds, times};

/// The whole chapter.
pub(crate) fn which_when(results: &Results) -> String {
    let races = results.races();
    let run: Vec<Race> = races.into_iter().filter(|r| r.winner().is_some()).collect();
    if run.is_empty() {
        return "Too little was measured to say.\n".into();
    }
    let standings = standings(&run);
    let mut text = format!(
        "A *race* is a scene, a number of elements and an error to come below; time is that for \
         form factors and solving. {} races had a finisher.\n\n",
        run.len()
    );
    text += &standings_table(&standings);
    text += "\n";
    text += &best(&standings, run.len());
    text += "\nBy size and goal:\n\n";
    text += &by_size(&run);
    text += "\nMethod by method:\n\n";
    for standing in &standings {
        text += &portrait(results, &run, standing);
    }
    text
}

fn standings_table(standings: &[Standing]) -> String {
    let mut text = String::from(
        "| method | first | arrived | behind the first, median | at worst |\n|---|---|---|---|---|\n",
    );
    for s in standings {
        let behind = |value: f64| {
            if s.arrived > 0 {
                format!("× {value:.1}")
            } else {
                "–".into()
            }
        };
        text += &format!(
            "| {} | {} | {} | {} | {} |\n",
            s.family.name,
            s.first,
            s.arrived,
            behind(s.usual),
            behind(s.worst)
        );
    }
    text
}

/// What to take if one does not want to choose.
fn best(standings: &[Standing], races: usize) -> String {
    let Some(best) = standings.iter().max_by_key(|s| (s.first, s.arrived)) else {
        return String::new();
    };
    let mut text = format!(
        "**If you do not want to choose, take the {} method**: it was first in {} of {races} races \
         and came to the goal in {}.",
        best.family.name, best.first, best.arrived
    );
    if best.worst > 1.05 {
        text += &format!(
            " Where another was faster it took at worst {} as long.",
            times(best.worst)
        );
    }
    let others = standings.iter().filter(|s| s.arrived > best.arrived);
    for other in others {
        text += &format!(
            " The {} method came to the goal in {}, at a median of {} the time of the first.",
            other.family.name,
            other.arrived,
            times(other.usual)
        );
    }
    text + "\n"
}

/// Winners of each size and goal, with their scenes.
fn by_size(races: &[Race]) -> String {
    let mut kinds: Vec<(u32, f64)> = races.iter().map(|r| (r.size, r.goal)).collect();
    kinds.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    kinds.dedup();
    let mut text = String::new();
    for (size, goal) in kinds {
        let here = || races.iter().filter(|r| r.size == size && r.goal == goal);
        let winners = FAMILIES.iter().filter_map(|family| {
            let won = here().filter(|r| r.winner().is_some_and(|w| w.0.name == family.name));
            let scenes: Vec<String> = won.map(scene_and_lead).collect();
            (!scenes.is_empty()).then(|| format!("**{}** on {}", family.name, list(&scenes)))
        });
        let winners: Vec<String> = winners.collect();
        text += &format!(
            "- about {} elements, {}: {}\n",
            count(u64::from(size)),
            percent(goal),
            winners.join("; ")
        );
    }
    text
}

/// "S3 (× 2.1)", the lead over the second.
fn scene_and_lead(race: &Race) -> String {
    let lead = race.winner().and_then(|w| w.1);
    let lead = lead.map_or_else(|| "alone".into(), |lead| format!("× {lead:.1}"));
    format!("{} ({lead})", race.subject.id)
}

/// Where a method is first, where it never arrives, and the best it did.
fn portrait(results: &Results, races: &[Race], standing: &Standing) -> String {
    let family = standing.family;
    let won = races
        .iter()
        .filter(|r| r.winner().is_some_and(|w| w.0.name == family.name));
    let largest = won.clone().map(|r| r.size).max();
    let verdict = match (standing.first, largest) {
        (0, _) | (_, None) => "first nowhere".into(),
        (n, Some(largest)) => format!(
            "first in {n} of {}, on up to about {} elements",
            races.len(),
            count(u64::from(largest))
        ),
    };
    let example = example(results, family);
    format!("- **{}**: {verdict}. {example}\n", family.name)
}

/// What the method does on the Cornell box.
fn example(results: &Results, family: &Family) -> String {
    let stage = ("S3", 1000);
    let points = results.of(stage, family);
    let best = points.min_by(|a, b| a.0.error(&a.1.errors).total_cmp(&b.0.error(&b.1.errors)));
    let Some((_, best)) = best else {
        return "It was not measured on the Cornell box.".into();
    };
    let errors = best.errors.bounced;
    let line = results.line(stage, family);
    let to = |goal: f64| {
        let time = cost_of(goal, &line).filter(|_| goal > best.floor)?;
        Some(format!("{} in {}", percent(goal), seconds(time)))
    };
    let goals: Vec<String> = [0.05, 0.02, 0.01].into_iter().filter_map(to).collect();
    let comes = if goals.is_empty() {
        String::new()
    } else {
        format!(" it comes to {};", list(&goals))
    };
    format!(
        "On the Cornell box with about 1,000 elements{comes} the best it did in the time it had was \
         {} in {}, with 95 % of the area off by less than {} and 99 % by less than {}.",
        at_least(errors.l2, best.floor),
        seconds(best.cost.bounces()),
        percent(errors.p95),
        percent(errors.p99)
    )
}

/// An error, or that it is below what the reference can tell.
fn at_least(error: f64, floor: f64) -> String {
    if error < floor {
        format!(
            "less than the {} that the reference can tell",
            percent(floor)
        )
    } else {
        percent(error)
    }
}

/// What leaving lamps to form factors costs.
pub(crate) fn lamps(results: &Results) -> String {
    let mut text = String::new();
    for (subject, size, _) in results.stages() {
        let stage = (subject.id, size);
        let least = |family: &Family| {
            let errors = results.of(stage, family).map(|(_, m)| m.errors.total.l2);
            errors.min_by(f64::total_cmp)
        };
        let line = |family: &Family| -> Vec<(f64, f64)> {
            let points = results.of(stage, family);
            points
                .map(|(_, m)| (m.cost.light(), m.errors.total.l2))
                .collect()
        };
        let [sampled, by_rays, by_pixels] = &LAMPS;
        let (Some(rays), Some(pixels)) = (least(by_rays), least(by_pixels)) else {
            continue;
        };
        let same = cost_of(rays, &line(sampled)).zip(cost_of(rays, &line(by_rays)));
        let compared = same.map_or_else(String::new, |(quick, slow)| {
            format!(
                " Sampling comes as near in {}, found by rays it took {}: {} as long.",
                seconds(quick),
                seconds(slow),
                times(slow / quick)
            )
        });
        text += &format!(
            "- {} {}: lamps left to the hit list leave {} of error at best, left to the hemicube {}.{compared}\n",
            subject.id,
            subject.name,
            percent(rays),
            percent(pixels)
        );
    }
    text
}
