//! What each criterion for λ* wins and loses: the tables of docs/choosing-lambda.md.
//!
//! For each design the true coefficients have norm 1 (in columns of unit length), along the worst
//! determined direction, the best, or all alike; the noise is a tenth, once and ten times what
//! makes the worst direction as uncertain as it is large. `cargo run --release -p flankfit-engine
//! --example criteria_table -- 300` draws 300 times each; `-- 300 press` shows the rows of one
//! criterion alone (`min_mse` with what follows).

#[expect(dead_code, reason = "the oracle is shared with the tests, which use all of it")]
#[path = "../tests/oracle/mod.rs"]
mod oracle;

use flankfit_engine::estimation::{
    FitError, FitSpec, Nodes, fit,
    spec::{Count, Criterion, DEFAULT_CONDITION_LIMIT, Include, Model, Parameter, Regularization, Scheme},
};
use oracle::{
    coverage::{Design, Truth, designs},
    random::Random,
};

/// One design, truth and noise.
struct Case<'a> {
    design: &'a Design,
    coefficients: Vec<f64>,
    lengths: Vec<f64>,
    sigma: f64,
}

/// True squared errors in columns of unit length, and what was predicted.
#[derive(Clone, Copy, Default)]
struct Errors {
    own: f64,
    least_squares: f64,
    predicted: f64,
    corrected: f64,
}

impl Case<'_> {
    fn errors(&self, regularization: &Regularization, corrected: bool, draws: usize) -> Result<Errors, FitError> {
        let mut random = Random::new(7);
        let mut sums = Errors::default();
        for _ in 0..draws {
            let fitted = |row: &Vec<f64>| row.iter().zip(&self.coefficients).map(|(x, a)| x * a).sum::<f64>();
            let heights = self.design.x.iter().map(|row| fitted(row) + self.sigma * random.normal()).collect();
            let nodes = Nodes::matrix(self.design.x.concat(), self.lengths.len(), heights, None, None)
                .expect("finite numbers are nodes");
            let spec = FitSpec {
                regularization: regularization.clone(),
                include: Include { predicted_mse: corrected, ..Include::default() },
                ..FitSpec::new(Model::Linear)
            };
            let found = fit(&nodes, &spec)?;
            for ((c, a), length) in found.coefficients.iter().zip(&self.coefficients).zip(&self.lengths) {
                sums.own += ((c.value - a) * length).powi(2);
                sums.least_squares += ((c.least_squares - a) * length).powi(2);
            }
            let report = &found.regularization;
            let chosen = report.choices.iter().find(|choice| choice.criterion == report.criterion);
            sums.predicted += chosen.and_then(|choice| choice.predicted_mse).unwrap_or(0.0);
            sums.corrected += report.predicted_mse_corrected.unwrap_or(0.0);
        }
        Ok(sums)
    }
}

fn cases(designs: &[Design]) -> Vec<Case<'_>> {
    let mut cases = Vec::new();
    for design in designs {
        let length = |j: usize| design.x.iter().map(|row| row[j] * row[j]).sum::<f64>().sqrt();
        for truth in [Truth::Smallest, Truth::Largest, Truth::Every] {
            for noise in [0.1, 1.0, 10.0] {
                cases.push(Case {
                    design,
                    coefficients: design.truth(truth, 1.0),
                    lengths: (0..design.x[0].len()).map(length).collect(),
                    sigma: noise * design.directions[0].0,
                });
            }
        }
    }
    cases
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let draws: usize = std::env::args().nth(1).map_or(Ok(300), |text| text.parse())?;
    let designs = designs();
    let cases = cases(&designs);
    let spectral = |criterion: Criterion| Regularization::Spectral {
        scheme: Scheme::FirstOrder,
        count: Count::Auto,
        condition_limit: DEFAULT_CONDITION_LIMIT,
        lambda_star: Parameter::Criterion(criterion),
    };
    let ridge = |criterion: Criterion| Regularization::Ridge { parameter: Parameter::Criterion(criterion) };
    let rank = |criterion: Criterion| Regularization::TruncatedSvdBy { criterion };
    let name = |kind: &str, criterion: Criterion| format!("{kind} | `{}`", criterion.name());
    let mut rows: Vec<(String, Regularization)> = Vec::new();
    let asked = || Criterion::ALL.into_iter().chain(Criterion::MORE);
    rows.extend(asked().map(|criterion| (name("`first_order`", criterion), spectral(criterion))));
    let of_ridge = asked().filter(|criterion| *criterion != Criterion::MinCondition).chain([Criterion::Hkb1975]);
    rows.extend(of_ridge.map(|criterion| (name("ridge", criterion), ridge(criterion))));
    rows.extend(Criterion::OF_RANK.map(|criterion| (name("`truncated_svd`", criterion), rank(criterion))));
    let only = std::env::args().nth(2);
    if let Some(only) = &only {
        rows.retain(|(name, _)| name.contains(&format!("`{only}`")));
    }
    println!("{draws} draws of each of {} cases\n", cases.len());
    println!("| regularisation | criterion | geometric mean | mean | worst | cases worse than least squares |");
    println!("|---|---|---|---|---|---|");
    for (name, regularization) in &rows {
        // some criteria have no answer for so few directions
        let ratios: Result<Vec<f64>, FitError> = cases
            .iter()
            .map(|case| case.errors(regularization, false, draws).map(|sums| sums.own / sums.least_squares))
            .collect();
        match ratios {
            Ok(ratios) => {
                let count = ratios.len() as f64;
                let geometric = (ratios.iter().map(|r| r.ln()).sum::<f64>() / count).exp();
                let (mean, worst) = (ratios.iter().sum::<f64>() / count, ratios.iter().fold(0.0f64, |w, r| w.max(*r)));
                let worse = ratios.iter().filter(|r| **r > 1.005).count();
                println!("| {name} | {geometric:.3} | {mean:.2} | {worst:.1} | {worse} of {} |", ratios.len());
            }
            Err(error) => println!("| {name} | – | – | – | {error} |"),
        }
    }
    if only.is_some_and(|only| only != "min_mse") {
        return Ok(());
    }
    println!("\nmean predicted over mean true squared error, least and most over the cases");
    println!("\n| regularisation | criterion | `predicted_mse` | `predicted_mse_corrected` |");
    println!("|---|---|---|---|");
    let shown = [("`first_order`", Criterion::MinMse), ("`first_order`", Criterion::Gcv), ("ridge", Criterion::MinMse)];
    for (kind, criterion) in shown {
        let regularization = if kind == "ridge" { ridge(criterion) } else { spectral(criterion) };
        let (mut plain, mut corrected) = ([f64::INFINITY, 0.0f64], [f64::INFINITY, 0.0f64]);
        for case in &cases {
            let sums = case.errors(&regularization, true, draws)?;
            for (ends, predicted) in [(&mut plain, sums.predicted), (&mut corrected, sums.corrected)] {
                *ends = [ends[0].min(predicted / sums.own), ends[1].max(predicted / sums.own)];
            }
        }
        println!(
            "| {kind} | `{}` | {:.2}–{:.2} | {:.2}–{:.2} |",
            criterion.name(),
            plain[0],
            plain[1],
            corrected[0],
            corrected[1]
        );
    }
    Ok(())
}
