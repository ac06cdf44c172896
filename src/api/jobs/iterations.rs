//! Iterations of a job and their fits. Stored results are returned byte for byte.

use std::sync::Arc;

use jiff::Timestamp;
use serde::{
    Deserialize, Serialize,
    de::{DeserializeOwned, IntoDeserializer, value::Error},
};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;
use uuid::Uuid;

use super::amendments::KnownMeasurandBody;
use crate::{
    api::{
        fits::{answer::FitResultBody, spec::request::FitSpecBody},
        gears::fit_figures::FitFiguresBody,
        json::{
            gather::{gathered, listed},
            raw::Raw,
            text::Moment,
            writer::text_of,
        },
        warning::WarningBody,
    },
    jobs::{
        Computed, Decision, Event, FitRecord, FitSummary, Iteration, Measurand, MeasurementDetails, NewFit,
        NewIteration, Stored,
    },
};
use flankfit_engine::estimation::spec::{ChosenBy, Scheme};

/// Number and measurement of an iteration.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MeasuredIterationBody {
    /// 1, 2, 3 … within the job.
    pub number: u32,
    /// UUIDv7.
    pub id: Uuid,
    #[serde(flatten)]
    #[schema(inline)]
    pub measurand: KnownMeasurandBody,
    /// Time of the measurement, as posted.
    #[schema(value_type = Option<String>, format = DateTime)]
    pub measured_at: Option<Moment>,
    /// Measuring instrument.
    pub instrument: Option<String>,
    /// Operator who measured the nodes.
    pub operator: Option<String>,
    /// Time when it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
}

/// A stored measurement of a job.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PostedIterationBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub measured: MeasuredIterationBody,
    /// The job that it belongs to.
    pub job_id: Uuid,
    /// Note on the measurement.
    pub note: Option<String>,
    /// Nodes posted, missing ones included.
    pub node_count: u64,
}

/// A new iteration of a job, with its fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = NewIteration)]
pub struct NewIterationBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub posted: PostedIterationBody,
    /// One, which is chosen until another one is.
    pub fits: Vec<IterationFitBody>,
    /// Warnings of the fit and its figures, each with `at`.
    #[schema(value_type = Vec<WarningBody>)]
    pub warnings: Raw<Vec<WarningBody>>,
}

/// An iteration of a job, with the figures of the fits of its nodes.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Iteration)]
pub struct IterationBody {
    #[serde(flatten)]
    #[schema(inline)]
    pub posted: PostedIterationBody,
    /// The latest decision; absent before the first.
    pub decision: Option<Decision>,
    /// Actor of the caller who decided; absent where no key was required.
    pub decided_by: Option<String>,
    /// The last hundred fits in the order in which they were made; `GET …/fits/{fit_id}` has each
    /// in full.
    pub fits: Vec<FitSummaryBody>,
    /// Number of fits before the listed ones; `GET …/fits` lists all.
    pub earlier_fits: Option<u64>,
    /// Time of the purge of its nodes, results, texts and names; absent without a purge.
    #[schema(value_type = Option<String>, format = DateTime)]
    pub purged_at: Option<Moment>,
    /// Warnings of the chosen fit's figures, each with `at`.
    pub warnings: Vec<WarningBody>,
}

/// A fit of an iteration's nodes.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = IterationFit)]
pub struct IterationFitBody {
    /// UUIDv7.
    pub id: Uuid,
    /// True for the chosen fit.
    pub chosen: bool,
    /// Time when it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// Actor of the caller who made it; absent where no key was required.
    pub by: Option<String>,
    /// Reason of the fit, as posted.
    pub reason: Option<String>,
    /// The fit request without nodes, with every default filled in. It can be sent as a refit, or
    /// with nodes as a new fit.
    #[schema(value_type = FitSpecBody)]
    pub spec: Raw<FitSpecBody>,
    /// Slopes, crownings and twist, or the reason why there are none; absent for curves and
    /// matrices, for jobs without gear and requirements, and for fits older than these figures.
    #[schema(value_type = Option<FitFiguresBody>)]
    pub figures: Option<Raw<FitFiguresBody>>,
    #[schema(value_type = FitResultBody<'static>)]
    pub result: Raw<FitResultBody<'static>>,
    /// Warnings of result and figures, each with `at`; in the response for a single fit.
    #[schema(value_type = Option<Vec<WarningBody>>)]
    pub warnings: Option<Raw<Vec<WarningBody>>>,
}

/// Figures of a fit for comparing λ* choices. A figure that does not exist is absent.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FitSummary)]
pub struct FitSummaryBody {
    /// UUIDv7.
    pub id: Uuid,
    /// True for the chosen fit.
    pub chosen: bool,
    /// For the chosen fit: actor of the caller who chose it; absent where no key was required.
    pub chosen_by: Option<String>,
    /// The λ* of the fit; left out without regularisation.
    pub lambda_star: Option<f64>,
    pub criterion: Option<ChosenBy>,
    pub scheme: Option<Scheme>,
    /// L: how many of the smallest eigenvalues were regularised.
    pub count: Option<u32>,
    /// Condition number of the scaled Fisher information matrix; absent where it is infinite.
    pub condition: Option<f64>,
    /// The same after regularisation.
    pub regularized_condition: Option<f64>,
    /// Observed ‖Â − Â_B‖ in the scaled columns.
    pub bias_norm: Option<f64>,
    /// The smallest bias bound that holds within the norm limit.
    pub bias_sharp_bound: Option<f64>,
    /// Root mean square of the residuals, in the unit of the heights.
    pub rms: Option<f64>,
    /// Largest |residual|.
    pub max_abs: Option<f64>,
    /// Slopes, crownings and twist of the chosen fit (a fit that is returned in full has its own);
    /// absent where `axes` do not give u, v and z, and for fits that are older than these figures.
    pub figures: Option<FitFiguresBody>,
    /// Time when it was stored.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Moment,
    /// Actor of the caller who made it; absent where no key was required.
    pub by: Option<String>,
    /// Reason of the fit, as posted.
    pub reason: Option<String>,
}

impl MeasuredIterationBody {
    pub fn new(
        (number, id): (u32, Uuid),
        measurand: &Measurand,
        (measured_at, instrument, operator): (Option<Timestamp>, &Option<String>, &Option<String>),
        created_at: Timestamp,
    ) -> Self {
        MeasuredIterationBody {
            number,
            id,
            measurand: measurand.into(),
            measured_at: measured_at.map(Moment),
            instrument: instrument.clone(),
            operator: operator.clone(),
            created_at: Moment(created_at),
        }
    }

    fn with_details(key: (u32, Uuid), of: &Measurand, details: &MeasurementDetails, created_at: Timestamp) -> Self {
        let MeasurementDetails { measured_at, instrument, operator, .. } = details;
        Self::new(key, of, (*measured_at, instrument, operator), created_at)
    }
}

impl NewIterationBody {
    /// Returns a new iteration as JSON.
    pub fn text(new: &NewIteration, stored: Stored) -> Vec<u8> {
        let key = (stored.number, new.id);
        let posted = PostedIterationBody {
            measured: MeasuredIterationBody::with_details(key, &new.measurand, &new.details, new.created_at),
            job_id: new.job_id,
            note: new.details.note.clone(),
            node_count: new.nodes.posted() as u64,
        };
        let fit = IterationFitBody::of(&new.fit, true);
        let warnings = fit.warnings(["/fits/0/figures", "/fits/0/result"]).into();
        text_of(&NewIterationBody { posted, fits: vec![fit], warnings }).into_bytes()
    }
}

impl IterationBody {
    /// Returns a stored iteration as JSON.
    pub fn text(stored: &Iteration) -> Vec<u8> {
        let Iteration { number, id, measurand, details, created_at, .. } = stored;
        let posted = PostedIterationBody {
            measured: MeasuredIterationBody::with_details((*number, *id), measurand, details, *created_at),
            job_id: stored.job_id,
            note: details.note.clone(),
            node_count: stored.node_count,
        };
        let decision = stored.decision.as_ref();
        let body = IterationBody {
            posted,
            decision: decision.map(|decision| decision.decision),
            decided_by: decision.and_then(|decision| decision.event.by.as_deref()).map(str::to_owned),
            fits: stored.fits.iter().map(FitSummaryBody::from).collect(),
            earlier_fits: Some(stored.earlier_fits).filter(|count| *count > 0),
            purged_at: stored.purged_at.map(Moment),
            warnings: Vec::new(),
        };
        gathered(text_of(&body).into_bytes())
    }
}

impl IterationFitBody {
    /// Creates a new fit of stored nodes.
    pub fn of(new: &NewFit, chosen: bool) -> Self {
        let Computed { spec, result, flank, .. } = &new.computed;
        Self::new((new.id, chosen), &new.event, (spec, flank.as_ref(), result.text()))
    }

    /// Creates a stored fit with its result, which may have more than was requested at first.
    pub fn stored(fit: &FitRecord, result: &Arc<str>) -> Self {
        Self::new((fit.id, fit.chosen), &fit.event, (&fit.spec, fit.flank.as_ref(), result))
    }

    fn new(
        (id, chosen): (Uuid, bool),
        event: &Event,
        (spec, figures, result): (&Arc<str>, Option<&Arc<str>>, &Arc<str>),
    ) -> Self {
        IterationFitBody {
            id,
            chosen,
            created_at: Moment(event.created_at),
            by: event.by.as_deref().map(str::to_owned),
            reason: event.reason.clone(),
            spec: Arc::clone(spec).into(),
            figures: figures.cloned().map(Raw::from),
            result: Arc::clone(result).into(),
            warnings: None,
        }
    }

    /// Returns the list of warnings of figures and result, whose pointers are given.
    fn warnings(&self, [figures, result]: [&str; 2]) -> String {
        let parts = self.figures.iter().map(|part| (figures, part.text()));
        listed(parts.chain([(result, self.result.text())]))
    }

    /// Returns the JSON text, with the warnings of figures and result.
    pub fn text(mut self) -> Vec<u8> {
        let warnings = self.warnings(["/figures", "/result"]);
        self.warnings = (warnings != "[]").then(|| warnings.into());
        text_of(&self).into_bytes()
    }
}

/// Returns the value of a name.
fn named<T: DeserializeOwned>(name: &str) -> Option<T> {
    T::deserialize(IntoDeserializer::<Error>::into_deserializer(name)).ok()
}

impl From<&FitSummary> for FitSummaryBody {
    fn from(fit: &FitSummary) -> Self {
        let (figures, event) = (&fit.figures, &fit.event);
        FitSummaryBody {
            id: fit.id,
            chosen: fit.chosen,
            chosen_by: fit.chosen_by.as_deref().map(str::to_owned),
            lambda_star: figures.lambda_star,
            criterion: figures.criterion.and_then(named),
            scheme: figures.scheme.and_then(named),
            count: figures.count,
            condition: figures.condition,
            regularized_condition: figures.regularized_condition,
            bias_norm: figures.bias_norm,
            bias_sharp_bound: figures.bias_sharp_bound,
            rms: figures.rms,
            max_abs: figures.max_abs,
            figures: fit.flank.as_deref().filter(|_| fit.chosen).and_then(|text| serde_json::from_str(text).ok()),
            created_at: Moment(event.created_at),
            by: event.by.as_deref().map(str::to_owned),
            reason: event.reason.clone(),
        }
    }
}

impl From<FitSummary> for FitSummaryBody {
    fn from(fit: FitSummary) -> Self {
        (&fit).into()
    }
}
