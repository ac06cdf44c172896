//! Coverage of the 95 % intervals of robust estimators: tables of docs/explanation/intervals.md.
//!
//! A cubic on 45 nodes, errors of four distributions with the same middle: the mean over the four
//! coefficients, that of the worst one, the width, and how often the band of a further measurement
//! holds it. Then surfaces with few nodes a coefficient: mean, worst, width, and how often a part
//! at its limit conforms. `cargo run --release -p engine-benches --example robust_coverage -- 1000
//! Tukey` draws 1,000 times each, of the estimators whose name contains the word; `-- 1000 '' 5000`
//! makes the second table alone, from seed 5000 on.

#[expect(dead_code, reason = "the oracle is shared with the tests, which use all of it")]
#[path = "../../../engine/tests/oracle/mod.rs"]
mod oracle;

use oracle::{
    checked::Checked,
    errors::{Coverage, ERRORS, Errors, coverage, coverage_on, estimators, further, more_estimators},
};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let repetitions: u64 = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(1000);
    let only = arguments.next().unwrap_or_default();
    let first: Option<u64> = arguments.next().and_then(|text| text.parse().ok());
    let mut chosen = estimators();
    chosen.extend(more_estimators());
    chosen.retain(|(name, _)| name.contains(&only));
    let shown = |found: &Coverage| format!("{:.3} / {:.3} / {:.2}", found.mean, found.worst, found.width);
    println!("| estimator | {} |", ERRORS.map(|errors| format!("{errors:?}")).join(" | "));
    println!("|---|{}", "---|".repeat(ERRORS.len()));
    for &(name, estimator) in chosen.iter().filter(|_| first.is_none()) {
        let cells = ERRORS.map(|errors| {
            let further = further(estimator, errors, repetitions, 45);
            format!("{} / {further:.3}", shown(&coverage(estimator, errors, repetitions, 45)))
        });
        println!("| {name} | {} |", cells.join(" | "));
    }
    let seeds = first.unwrap_or(0)..first.unwrap_or(0) + repetitions;
    let [a, b, c, d] = Checked::all();
    let designs = [c, Checked::second_order(), a, d, b];
    println!("\n| estimator | errors | {} |", designs.iter().map(|one| one.name).collect::<Vec<_>>().join(" | "));
    println!("|---|---|{}", "---|".repeat(designs.len()));
    for (name, estimator) in chosen {
        for errors in [Errors::Normal, Errors::Student3, Errors::Gross] {
            let cell = |design: &Checked| {
                let found = coverage_on(design, estimator, errors, seeds.clone());
                let refused = if found.given < 1.0 { format!(" ({:.2} given)", found.given) } else { String::new() };
                format!("{} / {:.3}{refused}", shown(&found), found.at_limit)
            };
            println!("| {name} | {errors:?} | {} |", designs.iter().map(cell).collect::<Vec<_>>().join(" | "));
        }
    }
}
