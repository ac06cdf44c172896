//! The service's responses as tables for a terminal.

use jiff::Timestamp;
use uuid::Uuid;

use super::{
    node_file::Units,
    numbers::{ABSENT, as_certain_as, rough, rough_or_absent, short, short_or_absent, um_per_mm},
};
use crate::{
    api::{fits::answer::FitResultBody, jobs::trace::TraceBody},
    cli::table::Table,
};
use flankfit_engine::estimation::{
    result::{Coefficient, TermKey},
    spec::ChosenBy,
};

/// Returns the unit of the heights.
fn height_unit(units: Units) -> &'static str {
    match units {
        Units::FlankDeviation => " µm",
        Units::Callers => "",
    }
}

/// Ends of the interval, to the digits that its width allows.
fn interval(coefficient: &Coefficient) -> String {
    let ends = |[low, high]: [f64; 2]| {
        let of = |end| as_certain_as(end, Some(0.25 * (high - low)));
        format!("{} to {}", of(low), of(high))
    };
    coefficient.interval.map_or_else(|| "–".to_owned(), |interval| ends(interval.ends))
}

/// Coefficients with standard errors, bias bounds and intervals.
pub fn coefficients(fit: &FitResultBody, units: Units) -> String {
    let headings = ["term", "value", "± std. error", "bias bound", "least squares", "95 % interval", "unit"];
    let mut table = Table::new(headings, 1).with_remark();
    for coefficient in &fit.coefficients {
        let unit = match (units, &coefficient.key) {
            (Units::FlankDeviation, TermKey::Powers(powers)) => um_per_mm(powers.iter().sum()),
            _ => String::new(),
        };
        table.row([
            coefficient.term.clone(),
            as_certain_as(coefficient.value, coefficient.std_error),
            rough_or_absent(coefficient.std_error),
            rough(coefficient.bias_bound),
            as_certain_as(coefficient.least_squares, coefficient.least_squares_std_error),
            interval(coefficient),
            unit,
        ]);
    }
    let residuals = &fit.residuals;
    let bias = &fit.bias;
    let unit = height_unit(units);
    format!(
        "{table}  {} nodes, {} degrees of freedom; σ̂ = {}{unit}, rms = {}{unit}, largest residual {}{unit}.\n  \
         Bias in the scaled columns: observed {}, sharp bound {}, bound of the paper {} (with ‖A‖ ≤ {}).\n",
        residuals.count,
        residuals.degrees_of_freedom,
        short_or_absent(residuals.sigma),
        short(residuals.rms),
        short_or_absent(residuals.max_abs),
        short(bias.norm),
        short(bias.sharp_bound),
        short_or_absent(bias.paper_bound),
        short(bias.coefficient_norm_limit),
    )
}

/// Eigenvalues of the scaled Fisher information matrix before and after regularisation.
pub fn spectrum(fit: &FitResultBody) -> String {
    let mut table = Table::new(["direction", "eigenvalue", "regularised", "filter factor"], 0);
    let regularized = &fit.spectrum.regularized.eigenvalues;
    for (i, &eigenvalue) in fit.spectrum.eigenvalues.iter().enumerate() {
        table.row([
            (i + 1).to_string(),
            short(eigenvalue),
            short_or_absent(regularized.get(i).copied()),
            short_or_absent(fit.regularization.filter_factors.get(i).copied()),
        ]);
    }
    let damped = fit.regularization.filter_factors.iter().filter(|&&factor| factor < 1.0).count();
    let considered = fit.regularization.count.map_or_else(String::new, |count| {
        format!("; {count} of {} directions may be regularised (L)", fit.spectrum.eigenvalues.len())
    });
    format!(
        "{table}  Condition {} before, {} after{considered}, {damped} damped.\n",
        short_or_absent(fit.spectrum.condition),
        short_or_absent(fit.spectrum.regularized.condition),
    )
}

/// Returns the choice of every criterion, side by side.
pub fn choices(fit: &FitResultBody) -> String {
    let headings = ["criterion", "λ*", "condition", "bias", "predicted error²", "÷ least squares", "rms", ""];
    let mut table = Table::new(headings, 1).with_remark();
    let plain = fit.regularization.choices.iter().find(|choice| choice.criterion == ChosenBy::LeastSquares);
    let plain_error = plain.and_then(|choice| choice.predicted_mse).filter(|&error| error > 0.0);
    for choice in &fit.regularization.choices {
        let ratio = choice.predicted_mse.zip(plain_error).map(|(error, plain)| error / plain);
        let chosen = fit.regularization.criterion == Some(choice.criterion);
        table.row([
            choice.criterion.name().to_owned(),
            short_or_absent(choice.lambda_star),
            short_or_absent(choice.condition),
            short(choice.bias_norm),
            short_or_absent(choice.predicted_mse),
            short_or_absent(ratio),
            short(choice.rms),
            if chosen { "← this fit".into() } else { String::new() },
        ]);
    }
    format!("{table}  Predicted error² is bias² + variance of all coefficients, in the scaled columns.\n")
}

/// Which terms the nodes cannot tell apart, and the warnings of the fit.
pub fn collinearity(fit: &FitResultBody) -> String {
    let mut text = String::new();
    for dependency in &fit.collinearity.near_dependencies {
        text.push_str(&format!("  • {}\n", dependency.sentence));
    }
    if text.is_empty() {
        text.push_str("  No near dependency: the nodes tell all terms apart.\n");
    }
    text
}

/// The warnings of a fit, one a line.
pub fn warnings(fit: &FitResultBody) -> String {
    fit.warnings.iter().map(|warning| format!("  ! {}: {}\n", warning.code, warning.message)).collect()
}

/// Returns the stored fits of one iteration, side by side.
pub fn fits(fits: &[(Uuid, &FitResultBody)], chosen: Uuid) -> String {
    let headings = ["fit", "criterion", "λ*", "condition", "regularised", "bias", "rms", ""];
    let mut table = Table::new(headings, 2).with_remark();
    for (i, (id, result)) in fits.iter().enumerate() {
        table.row([
            (i + 1).to_string(),
            result.regularization.criterion.map_or(ABSENT, ChosenBy::name).to_owned(),
            short_or_absent(result.regularization.lambda_star),
            short_or_absent(result.spectrum.condition),
            short_or_absent(result.spectrum.regularized.condition),
            short(result.bias.norm),
            short(result.residuals.rms),
            if *id == chosen { "← chosen".into() } else { String::new() },
        ]);
    }
    table.to_string()
}

/// Everything that was recorded of the job, in the order in which it happened.
pub fn trace(trace: &TraceBody) -> String {
    let headings = ["time (UTC)", "it.", "what", "λ*", "condition", "regularised", "bias", "rms", "reason"];
    let mut events: Vec<(Timestamp, Vec<String>)> = Vec::new();
    for iteration in &trace.iterations {
        let number = iteration.measured.number.to_string();
        let label = |fit_id: Uuid| {
            let place = iteration.fits.iter().position(|fit| fit.summary.id == fit_id);
            place.map_or_else(|| "fit".to_owned(), |place| format!("fit {}", place + 1))
        };
        let reason = |reason: &Option<String>| reason.clone().unwrap_or_default();
        for fit in iteration.fits.iter().map(|fit| &fit.summary) {
            let criterion = fit.criterion.unwrap_or(ChosenBy::LeastSquares).name();
            let figures = [
                short_or_absent(fit.lambda_star),
                short_or_absent(fit.condition),
                short_or_absent(fit.regularized_condition),
                short_or_absent(fit.bias_norm),
                short_or_absent(fit.rms),
                reason(&fit.reason),
            ];
            let head = [number.clone(), format!("{} by {criterion}", label(fit.id))];
            events.push((fit.created_at.0, head.into_iter().chain(figures).collect()));
        }
        let remark = |what: String, reason: String| {
            let mut cells = vec![number.clone(), what];
            cells.resize(headings.len() - 2, String::new());
            cells.push(reason);
            cells
        };
        for choice in &iteration.choices {
            let what = format!("{} is chosen", label(choice.fit_id));
            events.push((choice.created_at.0, remark(what, reason(&choice.reason))));
        }
        for decision in &iteration.decisions {
            events.push((
                decision.created_at.0,
                remark(format!("decision: {}", decision.decision.name()), reason(&decision.reason)),
            ));
        }
    }
    // The sort keeps the order of equal times.
    events.sort_by_key(|(time, _)| *time);
    let mut table = Table::new(headings, 3).with_remark();
    for (time, cells) in events {
        let clock = time.strftime("%F %T").to_string();
        table.row(std::iter::once(clock).chain(cells));
    }
    table.to_string()
}
