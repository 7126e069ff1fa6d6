use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::observer::{Observer, Stage};
use crate::parallel::map_ordered;
pub(crate) use crate::parallel::{map_chunks, threads};

/// The observer asked to stop.
#[derive(Debug)]
pub(crate) struct Cancelled;

/// Runs `work` over `0..count` in ranges of `chunk`, on all cores with the feature `parallel`.
///
/// Results come back in order and do not depend on the number of threads. Progress is reported
/// and cancellation asked for at every range.
pub(crate) fn map_ranges<T: Send>(
    count: usize,
    chunk: usize,
    stage: Stage,
    observer: &dyn Observer,
    work: impl Fn(Range<usize>) -> T + Send + Sync,
) -> Result<Vec<T>, Cancelled> {
    observer.progress(stage, 0.0);
    let (done, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let run = |i: usize| {
        if stop.load(Ordering::Relaxed) || observer.cancelled() {
            stop.store(true, Ordering::Relaxed);
            return None;
        }
        let range = i * chunk..((i + 1) * chunk).min(count);
        let length = range.len();
        let result = work(range);
        let finished = done.fetch_add(length, Ordering::Relaxed) + length;
        if finished < count {
            observer.progress(stage, finished as f32 / count as f32);
        }
        Some(result)
    };
    let results = map_ordered(count.div_ceil(chunk), run);
    if stop.load(Ordering::Relaxed) || observer.cancelled() {
        return Err(Cancelled);
    }
    observer.progress(stage, 1.0);
    Ok(results.into_iter().flatten().collect())
}
