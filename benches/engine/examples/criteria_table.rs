//! Gains and losses of each criterion for λ*: the tables of docs/explanation/choosing-lambda.md.
//!
//! For each design the true coefficients have norm 1 (in columns of unit length), along the worst
//! determined direction, the best, or all alike; the noise is a tenth, once and ten times what
//! makes the worst direction as uncertain as it is large. `cargo run --release -p engine-benches
//! --example criteria_table -- 300` draws 300 times each; `-- 300 press` shows the rows of one
//! criterion alone (`min_mse` with what follows, `predicted` what follows alone).

#[expect(dead_code, reason = "the oracle is shared with the tests, which use all of it")]
#[path = "../../../engine/tests/oracle/mod.rs"]
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
    truth: Truth,
    noise: f64,
}

/// Ratio of the draws that determine the true error to the others.
const REFERENCE: usize = 50;

/// True squared errors in columns of unit length, and what was predicted.
#[derive(Clone, Copy, Default)]
struct Errors {
    own: f64,
    least_squares: f64,
    predicted: f64,
}

impl Case<'_> {
    fn errors(&self, regularization: &Regularization, draws: usize) -> Result<Errors, FitError> {
        let mut sums = Errors::default();
        self.each(regularization, false, draws, |one, _| {
            sums.own += one.own;
            sums.least_squares += one.least_squares;
            sums.predicted += one.predicted;
        })?;
        Ok(sums)
    }

    /// Mean uncorrected and corrected prediction over the mean true error of `REFERENCE` times as
    /// many draws. That of the corrected goes by how far the uncorrected ones of the same draws lie
    /// from theirs (a control variate), and comes with its standard error.
    fn predicted(&self, regularization: &Regularization, draws: usize) -> Result<[f64; 3], FitError> {
        let all = self.errors(regularization, REFERENCE * draws)?;
        let (truth, expected) = (all.own / (REFERENCE * draws) as f64, all.predicted / (REFERENCE * draws) as f64);
        let mut pairs = Vec::new();
        self.each(regularization, true, draws, |one, corrected| pairs.push((one.predicted, corrected)))?;
        let count = draws as f64;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / count;
        let (plain, corrected) = (mean(&|p| p.0), mean(&|p| p.1));
        let variance = mean(&|p| (p.0 - plain).powi(2));
        let slope = if variance > 0.0 { mean(&|p| (p.0 - plain) * (p.1 - corrected)) / variance } else { 0.0 };
        let left = mean(&|p| (p.1 - corrected - slope * (p.0 - plain)).powi(2));
        let found = corrected - slope * (plain - expected);
        Ok([expected / truth, found / truth, (left / count).sqrt() / truth])
    }

    fn each(
        &self,
        regularization: &Regularization,
        corrected: bool,
        draws: usize,
        mut take: impl FnMut(Errors, f64),
    ) -> Result<(), FitError> {
        let mut random = Random::new(7);
        for _ in 0..draws {
            let mut sums = Errors::default();
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
            let chosen = report.choices.iter().find(|choice| Some(choice.criterion) == report.criterion);
            sums.predicted += chosen.and_then(|choice| choice.predicted_mse).unwrap_or(0.0);
            take(sums, report.predicted_mse_corrected.unwrap_or(0.0));
        }
        Ok(())
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
                    truth,
                    noise,
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
            .map(|case| case.errors(regularization, draws).map(|sums| sums.own / sums.least_squares))
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
    if only.is_some_and(|only| only != "min_mse" && only != "predicted") {
        return Ok(());
    }
    println!("\nmean predicted over mean true squared error\n");
    println!("| regularisation | criterion | design | truth | noise | `predicted_mse` | corrected | ± |");
    println!("|---|---|---|---|---|---|---|---|");
    for (kind, criterion) in [("`first_order`", Criterion::MinMse), ("ridge", Criterion::MinMse)] {
        let regularization = if kind == "ridge" { ridge(criterion) } else { spectral(criterion) };
        for case in &cases {
            let [plain, corrected, error] = case.predicted(&regularization, draws)?;
            let (design, truth, noise) = (case.design.name, case.truth, case.noise);
            println!(
                "| {kind} | `{}` | {design} | {truth:?} | {noise} | {plain:.2} | {corrected:.3} | {error:.3} |",
                criterion.name()
            );
        }
    }
    Ok(())
}
