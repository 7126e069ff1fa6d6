use std::sync::Mutex;
use std::sync::atomic::Ordering;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::Session;
use crate::displacement::Watch;
use crate::radiosity::{Observer, Stage};

/// A progress bar for the stage at work, and the wish to stop.
pub(super) struct Progress<'a> {
    session: &'a Session,
    bar: Option<Bar>,
}

struct Bar {
    line: ProgressBar,
    stage: Mutex<Option<Stage>>,
}

/// Steps of a bar.
const STEPS: f32 = 1000.0;

impl<'a> Progress<'a> {
    pub(super) fn new(session: &'a Session, quiet: bool) -> Self {
        let bar = (session.bars && !quiet).then(|| {
            let target = ProgressDrawTarget::stderr_with_hz(10);
            let line = ProgressBar::with_draw_target(Some(STEPS as u64), target);
            let style = ProgressStyle::with_template("{msg:14} {bar:40} {percent:>3} % {elapsed}");
            if let Ok(style) = style {
                line.set_style(style);
            }
            Bar {
                line,
                stage: Mutex::new(None),
            }
        });
        Self { session, bar }
    }

    /// Names a step that has no measure of its progress.
    pub(super) fn step(&self, name: &'static str) {
        if let Some(bar) = &self.bar {
            bar.line.set_message(name);
            bar.line.set_position(0);
            bar.line.tick();
        }
    }
}

impl Observer for Progress<'_> {
    fn progress(&self, stage: Stage, done: f32) {
        let Some(bar) = &self.bar else { return };
        let Ok(mut current) = bar.stage.lock() else {
            return;
        };
        let position = (done * STEPS) as u64;
        if *current != Some(stage) {
            *current = Some(stage);
            bar.line.set_message(stage.name());
            bar.line.reset();
        }
        // Threads may report out of order.
        if position > bar.line.position() {
            bar.line.set_position(position);
        }
    }

    fn cancelled(&self) -> bool {
        self.session.cancel.load(Ordering::Relaxed)
    }
}

impl Watch for Progress<'_> {
    fn goes_on(&self, stage: &'static str, done: f32) -> bool {
        if let Some(bar) = &self.bar {
            bar.line.set_message(stage);
            bar.line.set_position((done * STEPS) as u64);
        }
        !self.session.cancel.load(Ordering::Relaxed)
    }
}

impl Drop for Progress<'_> {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.line.finish_and_clear();
        }
    }
}
