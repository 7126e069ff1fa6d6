use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::observer::{Observer, Stage};

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

/// Runs `work` over `0..count` in ranges of `chunk`, without telling anybody: for what is quick.
pub(crate) fn map_chunks<T: Send>(
    count: usize,
    chunk: usize,
    work: impl Fn(Range<usize>) -> T + Send + Sync,
) -> Vec<T> {
    map_ordered(count.div_ceil(chunk), |i| {
        work(i * chunk..((i + 1) * chunk).min(count))
    })
}

/// How many ranges are worked on at a time.
#[cfg(feature = "parallel")]
pub(crate) fn threads() -> usize {
    rayon::current_num_threads()
}

/// How many ranges are worked on at a time.
#[cfg(not(feature = "parallel"))]
pub(crate) fn threads() -> usize {
    1
}

#[cfg(feature = "parallel")]
fn map_ordered<T: Send>(count: usize, run: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    use rayon::prelude::*;
    (0..count)
        .into_par_iter()
        .with_max_len(1)
        .map(run)
        .collect()
}

#[cfg(not(feature = "parallel"))]
fn map_ordered<T: Send>(count: usize, run: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    (0..count).map(run).collect()
}
