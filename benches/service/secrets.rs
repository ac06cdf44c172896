//! Measures if the time of comparing digests of keys depends on how much of them is alike:
//!
//!     cargo run --release -p service-benches --example secrets
//!
//! Digests that are alike in some bytes at the front are compared in turns; each row has the median
//! time of one comparison, and its ratio to that of digests that are alike in all.

use std::{hint::black_box, time::Instant};

use flankfit::jobs::secret::same;

/// Bytes at the front that are alike; of the last row all are.
const ALIKE: [usize; 6] = [0, 1, 8, 16, 31, 32];
const BATCH: usize = 2_000;
const ROUNDS: usize = 2_001;

fn main() {
    let kept = [0x5a; 32];
    let presented = ALIKE.map(|alike| {
        let mut digest = kept;
        digest[alike..].iter_mut().for_each(|byte| *byte ^= 1);
        digest
    });
    let mut times = ALIKE.map(|_| Vec::with_capacity(ROUNDS));
    for round in 0..ROUNDS {
        for turn in 0..ALIKE.len() {
            // none is always behind the same other one
            let which = (turn * (1 + round % 2 * 4) + round) % ALIKE.len();
            // all lie at one place, as places differ in time as well
            let digest = presented[which];
            let begun = Instant::now();
            for _ in 0..BATCH {
                let _same = black_box(same(black_box(&kept), black_box(&digest)));
            }
            times[which].push(begun.elapsed().as_secs_f64());
        }
    }
    let medians = times.map(|mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[ROUNDS / 2] / BATCH as f64
    });
    let equal = medians[ALIKE.len() - 1];
    println!("bytes alike    time of one    to equal ones");
    for (alike, time) in ALIKE.iter().zip(medians) {
        println!("{alike:>11}    {:>8.2} ns    {:>13.4}", 1e9 * time, time / equal);
    }
}
