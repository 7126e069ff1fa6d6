//! All that was measured, and questions to it.

use crate::displacement::Raised;
use crate::kernels;
use crate::methods::{FAMILIES, Family};
use crate::metrics::{cost_of, median};
use crate::reference::Reference;
use crate::refinement::Used;
use crate::scenes::Subject;
use crate::studies::{AtVertices, Refined, Solved};
use crate::sweep::{Measured, Point};

#[derive(Default)]
pub(crate) struct Results {
    pub(crate) points: Vec<Point>,
    pub(crate) references: Vec<Reference>,
    pub(crate) solved: Vec<Solved>,
    pub(crate) refined: Vec<Refined>,
    pub(crate) at_vertices: Vec<AtVertices>,
    pub(crate) used: Vec<Used>,
    pub(crate) kernels: Vec<kernels::Found>,
    pub(crate) raised: Vec<Raised>,
    pub(crate) quick: bool,
}

/// Errors that methods race to.
pub(crate) const GOALS: [f64; 4] = [0.05, 0.02, 0.01, 0.005];

/// All methods on their way to an error on a scene of one size.
pub(crate) struct Race<'a> {
    pub(crate) subject: &'a Subject,
    pub(crate) size: u32,
    pub(crate) goal: f64,
    /// Seconds of each of [`FAMILIES`]; `None` if it did not come there in the time it had.
    pub(crate) seconds: Vec<Option<f64>>,
}

impl Race<'_> {
    /// The fastest method, and how many times as long the second takes.
    pub(crate) fn winner(&self) -> Option<(&'static Family, Option<f64>)> {
        let mut arrived: Vec<(f64, &Family)> = (self.seconds.iter().zip(&FAMILIES))
            .filter_map(|(s, family)| Some(((*s)?, family)))
            .collect();
        arrived.sort_by(|a, b| a.0.total_cmp(&b.0));
        let &(first, family) = arrived.first()?;
        Some((family, arrived.get(1).map(|second| second.0 / first)))
    }
}

/// How a method did in all races that somebody finished.
pub(crate) struct Standing {
    pub(crate) family: &'static Family,
    pub(crate) first: usize,
    pub(crate) arrived: usize,
    /// Times the winner's time: in the middle and at worst, of races it finished.
    pub(crate) usual: f64,
    pub(crate) worst: f64,
}

impl Results {
    /// Scenes and sizes in the order they were measured, with the number of elements.
    pub(crate) fn stages(&self) -> Vec<(&'static Subject, u32, usize)> {
        let mut stages: Vec<(&'static Subject, u32, usize)> = Vec::new();
        for p in &self.points {
            if stages
                .last()
                .is_none_or(|s| (s.0.id, s.1) != (p.subject.id, p.size))
            {
                stages.push((p.subject, p.size, p.elements));
            }
        }
        stages
    }

    /// The points of a method on a scene of one size, with what was measured.
    pub(crate) fn of<'a>(
        &'a self,
        (id, size): (&'a str, u32),
        family: &'a Family,
    ) -> impl Iterator<Item = (&'a Point, &'a Measured)> {
        let of =
            move |p: &&Point| p.subject.id == id && p.size == size && p.family.name == family.name;
        let points = self.points.iter().filter(of);
        points.filter_map(|p| p.measured().map(|m| (p, m)))
    }

    pub(crate) fn reference(&self, id: &str, elements: usize) -> Option<&Reference> {
        let of = |r: &&Reference| r.subject == id && r.elements == elements;
        self.references.iter().find(of)
    }

    /// Seconds for bounces against error, errors below the floor lifted to it.
    pub(crate) fn line(&self, stage: (&str, u32), family: &Family) -> Vec<(f64, f64)> {
        let at = |(p, m): (&Point, &Measured)| (m.cost.bounces(), p.error(&m.errors).max(m.floor));
        self.of(stage, family).map(at).collect()
    }

    /// Races to errors that can be told from those of the reference, where methods compete.
    pub(crate) fn races(&self) -> Vec<Race<'_>> {
        let mut races = Vec::new();
        for (subject, size, elements) in self.stages() {
            let floor = self
                .reference(subject.id, elements)
                .map_or(0.0, |r| r.floor);
            let lines: Vec<_> = (FAMILIES.iter())
                .map(|family| self.line((subject.id, size), family))
                .collect();
            if lines.iter().filter(|line| !line.is_empty()).count() < 2 {
                continue;
            }
            for goal in GOALS.into_iter().filter(|&goal| goal > floor) {
                races.push(Race {
                    subject,
                    size,
                    goal,
                    seconds: lines.iter().map(|line| cost_of(goal, line)).collect(),
                });
            }
        }
        races
    }
}

/// How all methods did.
pub(crate) fn standings(races: &[Race]) -> Vec<Standing> {
    let standing = |(i, family): (usize, &'static Family)| {
        let behind = |race: &Race| {
            let best = race
                .seconds
                .iter()
                .flatten()
                .copied()
                .fold(f64::INFINITY, f64::min);
            race.seconds[i].map(|own| own / best)
        };
        let behind: Vec<f64> = races.iter().filter_map(behind).collect();
        Standing {
            family,
            first: behind.iter().filter(|&&b| b <= 1.0).count(),
            arrived: behind.len(),
            usual: median(behind.iter().copied()),
            worst: behind.iter().copied().fold(0.0, f64::max),
        }
    };
    FAMILIES.iter().enumerate().map(standing).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::SUBJECTS;

    fn race(seconds: [Option<f64>; 4]) -> Race<'static> {
        Race {
            subject: &SUBJECTS[0],
            size: 1000,
            goal: 0.01,
            seconds: seconds.to_vec(),
        }
    }

    #[test]
    fn winners_and_standings() {
        let races = [
            race([Some(1.0), Some(4.0), None, None]),
            race([Some(3.0), None, Some(1.0), None]),
            race([None; 4]),
        ];
        let (family, lead) = races[0].winner().unwrap();
        assert_eq!((family.name, lead), ("hit list", Some(4.0)));
        assert!(races[2].winner().is_none());
        let standings = standings(&races);
        assert_eq!((standings[0].first, standings[0].arrived), (1, 2));
        assert_eq!(standings[0].worst, 3.0);
        assert_eq!((standings[2].first, standings[2].worst), (1, 1.0));
        assert_eq!(standings[3].arrived, 0);
    }
}
