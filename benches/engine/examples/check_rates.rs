//! How often the checks of residuals warn: the tables of docs/explanation/intervals.md.
//!
//! `cargo run --release -p engine-benches --example check_rates -- 5000` draws 5,000 times for
//! false alarms, and a fifth of that for power.

#[expect(dead_code, reason = "the oracle is shared with the tests, which use all of it")]
#[path = "../../../engine/tests/oracle/mod.rs"]
mod oracle;

use std::collections::BTreeMap;

use flankfit_engine::estimation::{
    FitError, FitSpec, Nodes, Plans, fit_remembering,
    spec::{Along, Contamination, Correlation, Distribution, Errors, Estimator, Loss, MEstimator, Start, Variance},
};
use oracle::{checked::Checked, random::Random};

type Draw<'a> = &'a dyn Fn(&Checked, &mut Random) -> Result<Nodes, FitError>;

/// Share of fits with each warning, with any, and with doubtful intervals.
fn rates(design: &Checked, spec: &FitSpec, draws: usize, draw: Draw) -> Result<String, FitError> {
    let codes =
        ["correlated_residuals", "uneven_variance", "lack_of_fit", "clustered_low_weights", "outliers_suspected"];
    let (plans, mut random) = (Plans::default(), Random::new(20_261));
    let (mut any, mut doubtful, mut each) = (0, 0, BTreeMap::new());
    for _ in 0..draws {
        let found = fit_remembering(&draw(design, &mut random)?, spec, &plans)?;
        let mut warned: Vec<&str> = found.warnings.iter().map(|warning| warning.code()).collect();
        warned.retain(|code| codes.contains(code));
        warned.sort_unstable();
        warned.dedup();
        any += usize::from(!warned.is_empty());
        doubtful += usize::from(!found.doubts().is_empty());
        for code in warned {
            *each.entry(code).or_insert(0) += 1;
        }
    }
    let share = |count: usize| format!("{:.3}", count as f64 / draws as f64);
    let each = codes.map(|code| share(each.get(code).copied().unwrap_or(0)));
    Ok(format!("**{}** | {} | {}", share(any), share(doubtful), each.join(" | ")))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let draws: usize = arguments.next().map_or(Ok(5000), |text| text.parse())?;
    let only = arguments.next().unwrap_or_default();
    let line = |label: &str, design: &Checked, spec: &FitSpec, draws: usize, draw: Draw| {
        if label.contains(&only) {
            println!("| {} | {label} | {} |", design.name, rates(design, spec, draws, draw)?);
        }
        Ok::<(), FitError>(())
    };
    println!("| design | fit | any | doubtful | correlated | uneven | lack | clustered | gross |");
    println!("|---|---|---|---|---|---|---|---|---|");
    let m = |loss| Estimator::M(MEstimator::new(loss));
    let estimators = [
        ("least squares", Estimator::LeastSquares),
        ("Huber", m(Loss::HUBER)),
        ("Huber, share estimated", Estimator::M(MEstimator::minimax(Contamination::Estimated))),
        ("Tukey", m(Loss::TUKEY)),
        ("Tukey from LTS", Estimator::M(MEstimator { start: Start::LeastTrimmed, ..MEstimator::new(Loss::TUKEY) })),
        ("least absolute", Estimator::LeastAbsolute),
        ("Lp 1.5", Estimator::Lp { p: 1.5 }),
        ("LTS 0.75", Estimator::LeastTrimmed { coverage: 0.75, seed: 1 }),
        ("LTS 0.5", Estimator::LeastTrimmed { coverage: 0.5, seed: 1 }),
        ("ranks", Estimator::Rank),
        ("normal scores", Estimator::NormalScores),
        ("Student, ν estimated", Estimator::Likelihood(Distribution::Student { freedom: None })),
        ("Student, ν 4", Estimator::Likelihood(Distribution::Student { freedom: Some(4.0) })),
    ];
    let designs = Checked::all();
    let clean: Draw = &|design, random| design.white(random);
    for (name, estimator) in estimators {
        for design in &designs {
            line(
                &format!("false alarms, {name}"),
                design,
                &FitSpec { estimator, ..design.spec.clone() },
                draws,
                clean,
            )?;
        }
    }
    let along = |along| Some(Errors { correlation: Correlation::Ar1 { rho: None }, along, lines: None });
    for design in &designs {
        for (name, spec) in [
            ("false alarms, ar1 along u", FitSpec { errors: along(Along::U), ..design.spec.clone() }),
            ("false alarms, hc3", FitSpec { variance: Variance::Hc3, ..design.spec.clone() }),
        ] {
            line(name, design, &spec, draws / 5, clean)?;
        }
    }
    let few = draws / 5;
    let [a, b, c, d] = &designs;
    for design in [a, c] {
        for (name, along_u) in [("AR(0.6) along u", true), ("AR(0.6) along v", false)] {
            line(name, design, &design.spec, few, &|design, random| design.correlated(random, 0.6, along_u))?;
        }
    }
    for design in [a, b, c, d] {
        let huber = FitSpec { estimator: m(Loss::HUBER), ..design.spec.clone() };
        for (name, spec) in [("σ × 3.5 on border rows", &design.spec), ("σ × 3.5 on border rows, Huber", &huber)] {
            line(name, design, spec, few, &|design, random| design.rough_borders(random, 3.5))?;
        }
        line("relief of 15 σ and 10 σ", design, &design.spec, few, &|design, random| {
            design.relieved(random, 15.0, 10.0)
        })?;
    }
    let wrong = FitSpec { errors: along(Along::U), ..b.spec.clone() };
    line("AR(0.6) along v, modelled along u", b, &wrong, few, &|design, random| design.correlated(random, 0.6, false))?;
    for (name, estimator) in [("Tukey", m(Loss::TUKEY)), ("Huber", m(Loss::HUBER))] {
        let spec = FitSpec { estimator, ..b.spec.clone() };
        line(&format!("corner off by 15 σ, {name}"), b, &spec, few, &|design, random| design.cornered(random))?;
    }
    Ok(())
}
