//! How much is measured, and how the command line chooses it.

use std::path::PathBuf;

/// How much is measured.
pub(crate) struct Plan {
    /// Whether every second point is left out.
    pub(crate) quick: bool,
    /// One scene by its short name, or one study.
    pub(crate) only: Option<String>,
    /// Where results are written.
    pub(crate) out: PathBuf,
    /// Runs of a point, of which the median counts.
    pub(crate) runs: u32,
    /// A point whose run would take longer than this, in seconds, is skipped.
    pub(crate) limit: f64,
    /// Rays of an element in a run that the reference is the mean of.
    pub(crate) reference_rays: u32,
}

pub(crate) const USAGE: &str = "\
Measures speed against accuracy of all methods and writes charts.

  --quick         a minute instead of a quarter of an hour: fewer points, shorter references
  --only WHAT     one scene, S1 to S9, or solvers, elements, vertices, refinement, kernels or
                  displacement
  --out FOLDER    where to write [default: docs/accuracy]";

impl Plan {
    fn new(quick: bool) -> Self {
        Self {
            quick,
            only: None,
            out: "docs/accuracy".into(),
            runs: if quick { 3 } else { 5 },
            limit: if quick { 0.2 } else { 0.8 },
            reference_rays: if quick { 1024 } else { 4096 },
        }
    }

    /// Reads the arguments; an error is a sentence for people.
    pub(crate) fn read(arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let arguments: Vec<String> = arguments.collect();
        let mut plan = Self::new(arguments.iter().any(|a| a == "--quick"));
        let mut rest = arguments.into_iter();
        while let Some(argument) = rest.next() {
            let mut value = || rest.next().ok_or(format!("{argument} needs a value"));
            match argument.as_str() {
                "--quick" => {}
                "--only" => plan.only = Some(value()?),
                "--out" => plan.out = value()?.into(),
                _ => return Err(format!("{argument} is unknown\n\n{USAGE}")),
            }
        }
        Ok(plan)
    }

    /// Whether a scene or a study is asked for.
    pub(crate) fn wants(&self, id: &str) -> bool {
        self.only
            .as_ref()
            .is_none_or(|only| only.eq_ignore_ascii_case(id))
    }

    /// Whether nothing else is asked for.
    pub(crate) fn only_wants(&self, id: &str) -> bool {
        self.only.is_some() && self.wants(id)
    }

    /// Of several values all, or every second one, the first among them.
    pub(crate) fn some<'a, T>(&self, all: &'a [T]) -> impl Iterator<Item = &'a T> + use<'a, T> {
        all.iter().step_by(if self.quick { 2 } else { 1 })
    }

    /// The sizes to solve a scene on.
    pub(crate) fn sizes<'a>(&self, all: &'a [u32]) -> impl Iterator<Item = u32> + use<'a> {
        let largest = if self.quick { 1000 } else { u32::MAX };
        all.iter().copied().filter(move |&n| n <= largest)
    }

    /// Runs of a reference: fewer where elements are many, for their rays are.
    pub(crate) fn reference_runs(&self, elements: u32) -> u32 {
        let most = if self.quick { 2 } else { 12 };
        (24_000 / elements.max(1)).clamp(3.min(most), most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(line: &str) -> Result<Plan, String> {
        Plan::read(line.split_whitespace().map(String::from))
    }

    #[test]
    fn arguments_are_read() {
        let plan = read("--only s3 --quick --out x").unwrap();
        assert!(plan.quick && plan.wants("S3") && !plan.wants("S4"));
        assert_eq!(plan.out, PathBuf::from("x"));
        assert!(plan.only_wants("s3") && !read("").unwrap().only_wants("s3"));
        assert!(!read("").unwrap().quick && read("").unwrap().wants("S4"));
        assert!(read("--only").is_err() && read("--fast").is_err());
    }
}
