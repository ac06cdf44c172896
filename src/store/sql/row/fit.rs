//! Fits, choices and decisions of an iteration.

use std::sync::Arc;

use crate::jobs::{Choice, DecisionEvent, Event, Figures, FitRecord, FitSummary, Told, TracedFit};

/// The columns of [`Figures`].
macro_rules! figure_columns {
    () => {
        "lambda_star, criterion, scheme, count, condition, regularized_condition, bias_norm, bias_sharp_bound, rms, \
         max_abs"
    };
}
pub(in crate::store::sql) use figure_columns;

from_row! {
    Figures {
        lambda_star, criterion, scheme, count, condition, regularized_condition, bias_norm, bias_sharp_bound, rms,
        max_abs,
    }
    Event { reason, by = "actor", created_at }
    FitRecord { @event, id, spec, result, flank = "flank_figures", chosen }
    FitSummary { @event, @figures, id, chosen, chosen_by, flank = "flank_figures" }
    Choice { @event, fit_id }
    DecisionEvent { @event, decision, concession }
}

row! {
    pub struct TracedFitRow {
        @summary: FitSummary,
        coefficients: Option<Arc<str>>,
        prior: Option<Arc<str>>,
        /// Present if neither is stored separately; empty if it was purged.
        result: Option<Arc<str>>,
    }
}

impl From<TracedFitRow> for TracedFit {
    fn from(TracedFitRow { summary, coefficients, prior, result }: TracedFitRow) -> Self {
        let told = result.as_ref().map_or_else(Told::default, |result| Told::of(result));
        let text = |kept: Option<Arc<str>>, found: Option<&str>| kept.as_deref().or(found).map(str::to_owned);
        TracedFit {
            summary,
            coefficients: text(coefficients, told.coefficients).unwrap_or_else(|| "[]".to_owned()),
            prior: text(prior, told.prior),
        }
    }
}
