//! A fit on record: what was asked, what was answered, and the figures that the trace lists.

use std::sync::Arc;

use flankfit_engine::estimation::{
    FitResult,
    spec::{ChosenBy, Criterion, Scheme},
};
use uuid::Uuid;

use super::{
    encoded_text::EncodedResult,
    said::{Choice, Event},
};

/// A fit computed and written down, on its way to be stored.
#[derive(Clone, Debug, PartialEq)]
pub struct Computed {
    /// The request without the nodes: a JSON document.
    pub spec: Arc<str>,
    /// The response: the JSON document itself, so that a replay can compare bit by bit.
    pub result: EncodedResult,
    pub figures: Figures,
    /// The figures of the flank that it is of, if its nodes are known to be on one: a JSON
    /// document. They are by the job's gear and requirements of that time.
    pub flank: Option<Arc<str>>,
}

/// A fit about to be stored.
#[derive(Clone, Debug, PartialEq)]
pub struct NewFit {
    pub id: Uuid,
    pub computed: Computed,
    pub event: Event,
}

impl NewFit {
    /// Returns the bytes that it adds to the log of a database, roughly.
    pub fn bytes(&self) -> usize {
        self.computed.result.bytes().len() + self.computed.flank.as_ref().map_or(0, |flank| flank.len())
    }

    /// Returns the choice of this fit, for fits that are chosen when they are stored.
    pub fn choice(&self) -> Choice {
        Choice { fit_id: self.id, event: Event { reason: None, ..self.event.clone() } }
    }
}

/// A stored fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FitRecord {
    pub id: Uuid,
    pub spec: Arc<str>,
    pub result: Arc<str>,
    /// The figures of the flank, as they were answered first.
    pub flank: Option<Arc<str>>,
    pub event: Event,
    /// True if it is the chosen fit.
    pub chosen: bool,
}

/// The figures that compare λ* choices at a glance. A figure that does not exist (or is
/// not finite) is `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures {
    pub lambda_star: Option<f64>,
    /// Name of the criterion, `fixed` for a caller's value.
    pub criterion: Option<&'static str>,
    pub scheme: Option<&'static str>,
    pub count: Option<u32>,
    pub condition: Option<f64>,
    pub regularized_condition: Option<f64>,
    pub bias_norm: Option<f64>,
    pub bias_sharp_bound: Option<f64>,
    pub rms: Option<f64>,
    pub max_abs: Option<f64>,
}

impl Figures {
    /// The figures of a result.
    pub fn of(result: &FitResult) -> Self {
        // none is below zero, and not every database keeps the sign of a zero
        let finite = |value: f64| value.is_finite().then_some(value + 0.0);
        let regularization = &result.regularization;
        Figures {
            lambda_star: regularization.lambda_star.and_then(finite),
            criterion: regularization.criterion.map(ChosenBy::name),
            scheme: regularization.scheme.map(scheme_name),
            count: regularization.count.and_then(|count| u32::try_from(count).ok()),
            condition: result.spectrum.condition.and_then(finite),
            regularized_condition: result.spectrum.regularized.condition.and_then(finite),
            bias_norm: finite(result.bias.norm),
            bias_sharp_bound: finite(result.bias.sharp_bound),
            rms: finite(result.residuals.rms),
            max_abs: result.residuals.max_abs.and_then(finite),
        }
    }

    /// The criterion of that name, as [`Figures::of`] writes it.
    pub fn criterion_named(name: &str) -> Option<&'static str> {
        let all = Criterion::every().map(ChosenBy::Criterion).chain([ChosenBy::Fixed]);
        all.map(ChosenBy::name).find(|known| *known == name)
    }

    /// The scheme of that name, as [`Figures::of`] writes it.
    pub fn scheme_named(name: &str) -> Option<&'static str> {
        [Scheme::FirstOrder, Scheme::Exact].into_iter().map(scheme_name).find(|known| *known == name)
    }
}

/// The contract's name.
pub fn scheme_name(scheme: Scheme) -> &'static str {
    match scheme {
        Scheme::FirstOrder => "first_order",
        Scheme::Exact => "exact",
    }
}
