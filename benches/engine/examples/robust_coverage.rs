//! Coverage of the 95 % intervals of robust estimators: the table of docs/explanation/intervals.md.
//!
//! A cubic on 45 nodes, errors of four distributions with the same middle; the mean over the four
//! coefficients, that of the worst one, the width, and how often the band of a further measurement
//! holds it. `cargo run --release -p engine-benches --example
//! robust_coverage -- 1000` draws 1,000 times each.

#[expect(dead_code, reason = "the oracle is shared with the tests, which use all of it")]
#[path = "../../../engine/tests/oracle/mod.rs"]
mod oracle;

use oracle::errors::{ERRORS, coverage, estimators, further};

fn main() {
    let repetitions: u64 = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(1000);
    println!("| estimator | {} |", ERRORS.map(|errors| format!("{errors:?}")).join(" | "));
    println!("|---|{}", "---|".repeat(ERRORS.len()));
    for (name, estimator) in estimators() {
        let cells = ERRORS.map(|errors| {
            let found = coverage(estimator, errors, repetitions, 45);
            let further = further(estimator, errors, repetitions, 45);
            format!("{:.3} / {:.3} / {:.2} / {further:.3}", found.mean, found.worst, found.width)
        });
        println!("| {name} | {} |", cells.join(" | "));
    }
}
