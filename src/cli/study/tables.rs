//! A study as text.

use std::fmt::Write;

use crate::{
    api::json::writer::text_of,
    api::studies::result::{RandomizationResult, RegularizedReference},
    cli::table::Table,
};
use flankfit_engine::estimation::randomization::{LevelRatios, MethodResults, Summary};

/// Everything a person wants to see of a study.
pub fn text(result: &RandomizationResult) -> String {
    let mut out = String::new();
    let list = |values: &[f64]| values.iter().map(|x| format!("{x:.3e}")).collect::<Vec<_>>().join(", ");
    // writing to a string cannot fail
    let _ = writeln!(out, "Randomisation of X: {} rows, columns {}", result.count, result.terms.join(", "));
    let _ = writeln!(
        out,
        "A = ({}), σ = {:.3e}, {} repetitions, seed {}",
        list(&result.coefficients),
        result.noise_sigma,
        result.repetitions,
        result.seed
    );
    let _ = writeln!(out, "eigenvalues of XᵀX: {}", list(&result.eigenvalues));
    if let (Some(low), Some(high)) = (result.smallest_correlation, result.largest_correlation) {
        let _ = writeln!(out, "|correlation| of columns that vary: {low:.4} to {high:.6}");
    }
    let _ = writeln!(out, "{}\n", result.remark);
    let mut table = Table::new(["k", "cond", "log10 det", "‖A−Â‖²", "quartiles", "", "RSS", "RSS on X̃"], 0);
    for level in &result.levels {
        let bias = |field: fn(Summary) -> f64| number(level.results.bias_norm_squared.map(field));
        table.row([
            format!("{:.3e}", level.level),
            median(level.results.condition),
            level.results.log10_determinant.map_or_else(String::new, |q| format!("{:.2}", q.median)),
            median(level.results.bias_norm_squared),
            bias(|q| q.q1),
            bias(|q| q.q3),
            median(level.results.rss),
            median(level.fitted_rss),
        ]);
    }
    let _ = writeln!(out, "{table}");
    let mut table = Table::new(["estimate", "λ* by", "cond", "log10 det", "‖A−Â‖²", "quartiles", "", "RSS"], 2);
    let determinant = |q: Option<Summary>| q.map_or_else(String::new, |q| format!("{:.2}", q.median));
    let cells = |name: &str, by: String, results: &MethodResults| {
        let bias = results.bias_norm_squared;
        [
            name.to_owned(),
            by,
            median(results.condition),
            determinant(results.log10_determinant),
            median(results.bias_norm_squared),
            number(bias.map(|q| q.q1)),
            number(bias.map(|q| q.q3)),
            median(results.rss),
        ]
    };
    table.row(cells("least squares", String::new(), &result.references.least_squares));
    let references: [(&str, Option<&RegularizedReference>); 3] = [
        ("spectral, first order", result.references.spectral_first_order.as_ref()),
        ("spectral, exact", result.references.spectral_exact.as_ref()),
        ("ridge", Some(&result.references.ridge)),
    ];
    for (name, reference) in references {
        for choice in reference.iter().flat_map(|reference| &reference.choices) {
            let by = text_of(&choice.criterion);
            table.row(cells(name, by.trim_matches('"').to_owned(), &choice.chosen.results));
        }
    }
    let _ = writeln!(out, "{table}");
    let _ = writeln!(out, "{}", versus_least_squares(result));
    if let Some(optimum) = &result.optimum {
        let _ = writeln!(out, "best level {}", ratios(&optimum.best));
        let [low, high] = optimum.plateau;
        let _ = writeln!(out, "within 5 % of the least error: k = {low:.3e} to {high:.3e}");
        let _ = writeln!(out, "least condition there at {}", ratios(&optimum.least_condition));
    }
    for warning in &result.warnings {
        let _ = writeln!(out, "warning: {}", warning.message);
    }
    out
}

/// Returns every level against least squares, with B of the same level next to it.
fn versus_least_squares(result: &RandomizationResult) -> Table {
    let heads = ["k", "‖A−Â‖ ÷", "cond ÷", "RSS ×", "B of level k: λ*", "‖A−Â‖ ÷", "cond ÷", "RSS ×"];
    let mut table = Table::new(heads, 0);
    let base = &result.references.least_squares;
    let over = |a: Option<Summary>, b: Option<Summary>| a.zip(b).map(|(a, b)| a.median / b.median);
    let three = |results: &MethodResults| {
        [
            number(over(base.bias_norm_squared, results.bias_norm_squared).map(f64::sqrt)),
            number(over(base.condition, results.condition)),
            number(over(results.rss, base.rss)),
        ]
    };
    for level in &result.levels {
        let [error, condition, rss] = three(&level.results);
        let b = level.matrix_b.as_ref();
        let [b_error, b_condition, b_rss] = b.map_or_else(Default::default, |b| three(&b.results));
        let lambda_star = number(b.map(|b| b.lambda_star));
        table.row([format!("{:.3e}", level.level), error, condition, rss, lambda_star, b_error, b_condition, b_rss]);
    }
    table
}

fn ratios(ratios: &LevelRatios) -> String {
    let condition = ratios.condition_ratio.map_or_else(String::new, |r| format!(", condition {r:.3e} times less"));
    let rss = ratios.rss_ratio.map_or_else(String::new, |r| format!(", RSS {r:.2} times"));
    let error = ratios.error_ratio.sqrt();
    format!("k = {:.3e}: median ‖A−Â‖ {error:.3} times less than least squares{condition}{rss}", ratios.level)
}

fn median(summary: Option<Summary>) -> String {
    number(summary.map(|q| q.median))
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |x| format!("{x:.3e}"))
}
