//! Fits, choices and decisions of an iteration.

use uuid::Uuid;

use crate::{
    jobs::{Choice, Decision, DecisionEvent, Event, Figures, FitRecord, FitSummary, Told, TracedFit},
    store::sql::columns::{CriterionName, Document, Integer, Moment, SchemeName},
};

/// The columns of [`FigureRow`].
macro_rules! figure_columns {
    () => {
        "lambda_star, criterion, scheme, count, condition, regularized_condition, bias_norm, bias_sharp_bound, rms, \
         max_abs"
    };
}
pub(in crate::store) use figure_columns;

row! {
    pub struct FigureRow {
        lambda_star: Option<f64>,
        criterion: Option<CriterionName>,
        scheme: Option<SchemeName>,
        count: Option<Integer<u32>>,
        condition: Option<f64>,
        regularized_condition: Option<f64>,
        bias_norm: Option<f64>,
        bias_sharp_bound: Option<f64>,
        rms: Option<f64>,
        max_abs: Option<f64>,
    }
}

impl From<FigureRow> for Figures {
    fn from(row: FigureRow) -> Self {
        Figures {
            lambda_star: row.lambda_star,
            criterion: row.criterion.map(|name| name.0),
            scheme: row.scheme.map(|name| name.0),
            count: row.count.map(|count| count.0),
            condition: row.condition,
            regularized_condition: row.regularized_condition,
            bias_norm: row.bias_norm,
            bias_sharp_bound: row.bias_sharp_bound,
            rms: row.rms,
            max_abs: row.max_abs,
        }
    }
}

row! {
    /// When something was said, by whom and why.
    pub struct ReasonRow {
        reason: Option<String>,
        actor: Option<String>,
        created_at: Moment,
    }
}

impl From<ReasonRow> for Event {
    fn from(ReasonRow { reason, actor, created_at }: ReasonRow) -> Self {
        Event { reason, by: actor.map(Into::into), created_at: created_at.0 }
    }
}

row! {
    pub struct FitRow {
        @event: ReasonRow,
        id: Uuid,
        chosen: bool,
        flank_figures: Option<String>,
        spec: Document,
        result: Document,
    }
}

impl FitRow {
    /// Whether the fit was purged.
    pub fn is_gone(&self) -> bool {
        self.result.0.is_empty()
    }
}

impl From<FitRow> for FitRecord {
    fn from(row: FitRow) -> Self {
        FitRecord {
            id: row.id,
            spec: row.spec.into(),
            result: row.result.into(),
            flank: row.flank_figures.map(Into::into),
            event: row.event.into(),
            chosen: row.chosen,
        }
    }
}

row! {
    pub struct FitSummaryRow {
        @event: ReasonRow,
        @figures: FigureRow,
        id: Uuid,
        chosen: bool,
        chosen_by: Option<String>,
        flank_figures: Option<String>,
    }
}

impl From<FitSummaryRow> for FitSummary {
    fn from(row: FitSummaryRow) -> Self {
        FitSummary {
            id: row.id,
            chosen: row.chosen,
            chosen_by: row.chosen_by.map(Into::into),
            figures: row.figures.into(),
            flank: row.flank_figures.map(Into::into),
            event: row.event.into(),
        }
    }
}

row! {
    pub struct TracedFitRow {
        @summary: FitSummaryRow,
        coefficients: Option<Document>,
        prior: Option<Document>,
        /// Where neither is kept beside it; empty where it was purged.
        result: Option<Document>,
    }
}

impl From<TracedFitRow> for TracedFit {
    fn from(TracedFitRow { summary, coefficients, prior, result }: TracedFitRow) -> Self {
        let told = result.as_ref().map_or_else(Told::default, |Document(result)| Told::of(result));
        let text =
            |kept: Option<Document>, found: Option<&str>| kept.map(|Document(text)| text).or(found.map(Into::into));
        TracedFit {
            summary: summary.into(),
            coefficients: text(coefficients, told.coefficients).unwrap_or_else(|| "[]".to_owned()),
            prior: text(prior, told.prior),
        }
    }
}

row! {
    /// The latest choice or decision of an iteration, and its reason.
    pub struct Latest<W> {
        what: W,
        reason: Option<String>,
    }
}

impl<W: PartialEq> Latest<W> {
    /// Returns whether an event would repeat it.
    pub fn is(&self, what: &W, event: &Event) -> bool {
        (&self.what, &self.reason) == (what, &event.reason)
    }
}

row! {
    pub struct ChoiceRow {
        @event: ReasonRow,
        fit_id: Uuid,
    }
}

impl From<ChoiceRow> for Choice {
    fn from(ChoiceRow { fit_id, event }: ChoiceRow) -> Self {
        Choice { fit_id, event: event.into() }
    }
}

row! {
    pub struct DecisionRow {
        @event: ReasonRow,
        decision: Decision,
        concession: Option<i64>,
    }
}

impl From<DecisionRow> for DecisionEvent {
    fn from(DecisionRow { decision, concession, event }: DecisionRow) -> Self {
        DecisionEvent { decision, concession: concession.is_some(), event: event.into() }
    }
}
