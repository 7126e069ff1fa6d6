//! Work on all cores with the feature `parallel`, on one without; results are the same.

use std::ops::Range;

/// Runs `work` over `0..count` in ranges of `chunk`; results come in order.
pub(crate) fn map_chunks<T: Send>(
    count: usize,
    chunk: usize,
    work: impl Fn(Range<usize>) -> T + Send + Sync,
) -> Vec<T> {
    map_ordered(count.div_ceil(chunk), |i| {
        work(i * chunk..((i + 1) * chunk).min(count))
    })
}

/// Makes each of `items` from its index, in chunks of `chunk` of them.
pub(crate) fn fill<T: Send>(
    items: &mut [T],
    chunk: usize,
    make: impl Fn(usize) -> T + Send + Sync,
) {
    let fill = |(i, items): (usize, &mut [T])| {
        for (k, item) in items.iter_mut().enumerate() {
            *item = make(i * chunk + k);
        }
    };
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        items.par_chunks_mut(chunk).enumerate().for_each(fill);
    }
    #[cfg(not(feature = "parallel"))]
    items.chunks_mut(chunk).enumerate().for_each(fill);
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

/// Runs `run` for `0..count`; results come in order.
#[cfg(feature = "parallel")]
pub(crate) fn map_ordered<T: Send>(count: usize, run: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    use rayon::prelude::*;
    (0..count)
        .into_par_iter()
        .with_max_len(1)
        .map(run)
        .collect()
}

/// Runs `run` for `0..count`; results come in order.
#[cfg(not(feature = "parallel"))]
pub(crate) fn map_ordered<T: Send>(count: usize, run: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    (0..count).map(run).collect()
}
