//! Nodes in chunks of a fixed size, whose partial sums are added in order: results do not depend on
//! how many threads work.

use rayon::prelude::*;

use flankfit_numerics::cancel;

/// Nodes of one partial sum.
pub(crate) const CHUNK: usize = 4096;
/// From how many nodes on chunks are shared among threads.
const PARALLEL: usize = 65_536;

/// Runs `work` over every chunk and folds the results in order.
pub(crate) fn over_chunks<P: Send>(
    count: usize,
    work: impl Fn(std::ops::Range<usize>) -> P + Sync,
    fold: impl FnMut(P),
) {
    let chunks = count.div_ceil(CHUNK);
    let handle = cancel::current();
    let work = |range| {
        cancel::checkpoint();
        work(range)
    };
    let range = |i: usize| i * CHUNK..((i + 1) * CHUNK).min(count);
    if count < PARALLEL {
        (0..chunks).map(|i| work(range(i))).for_each(fold);
    } else {
        let parts: Vec<P> =
            (0..chunks).into_par_iter().map(|i| cancel::carry(handle.as_ref(), || work(range(i)))).collect();
        parts.into_iter().for_each(fold);
    }
}
