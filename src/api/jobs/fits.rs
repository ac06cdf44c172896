//! Fits of jobs: computed and written down once, and computed again for a replay.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::{
    api::{
        faults::pointer_of,
        fits::{
            reader,
            service::{self, Written},
            spec::include,
        },
        gears::fit_figures::{Asked, OfFlank},
        json::merge,
        problem::Problem,
    },
    jobs::{Computed, Difference, Figures, FitRecord, Replay},
};
use flankfit_engine::estimation::{
    FitSpec, Nodes, Plans, fit,
    spec::{Earlier, Include, Piece, Regularization, Scaling},
};

/// The request of a replay, which is empty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ReplayRequest {}

/// Comparison of a stored fit with the same fit computed again from the stored nodes.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Replay, example = json!({"identical": true}))]
pub struct ReplayBody {
    /// True if the two results are identical bit by bit.
    pub identical: bool,
    /// Largest relative difference over all numbers of the two results; absent if they are
    /// identical, or differ in structure.
    pub max_relative_difference: Option<f64>,
    /// Engine of the stored result; absent if the results are identical.
    pub stored_engine: Option<String>,
    /// Engine of the new result; absent if the results are identical.
    pub replay_engine: Option<String>,
}

impl From<Replay> for ReplayBody {
    fn from(replay: Replay) -> Self {
        match replay {
            Replay::Identical => {
                ReplayBody { identical: true, max_relative_difference: None, stored_engine: None, replay_engine: None }
            }
            Replay::Different(Difference { max_relative_difference, stored_engine, replay_engine }) => {
                ReplayBody { identical: false, max_relative_difference, stored_engine, replay_engine }
            }
        }
    }
}

/// Fits and writes down what is stored of it. Processor work.
pub fn compute(nodes: &Nodes, spec: &FitSpec, plans: &Plans) -> Result<Computed, Problem> {
    compute_at(nodes, spec, plans, None, pointer_of)
}

/// The same with the figures of the flank that the nodes are on, if they are said to be on one.
pub fn compute_on(nodes: &Nodes, spec: &FitSpec, plans: &Plans, on: Option<&OfFlank>) -> Result<Computed, Problem> {
    compute_at(nodes, spec, plans, on, pointer_of)
}

/// The same where a request is more than one for a fit: `place` makes pointers into it of the paths
/// of a refused fit.
pub fn compute_at(
    nodes: &Nodes,
    spec: &FitSpec,
    plans: &Plans,
    on: Option<&OfFlank>,
    place: impl Fn(&str) -> String,
) -> Result<Computed, Problem> {
    let asked = on.and_then(|on| on.ask(nodes, spec));
    let asking = asked.as_ref().and_then(Asked::sums).map(|sums| FitSpec { sums: Some(sums), ..spec.clone() });
    let Written { result, spec, text } = service::write(nodes, asking.as_ref().unwrap_or(spec), plans, false, place)?;
    let text = String::from_utf8(text).map_err(Problem::internal)?;
    let flank = asked.map(|asked| asked.answer(&result).into());
    Ok(Computed { spec: spec.into(), result: text.into(), figures: Figures::of(&result), flank })
}

/// Returns the response of a stored fit with the requested additional parts, which are computed
/// from the stored nodes, and their warnings; the stored part is not changed. CPU-bound.
pub fn with_include(
    nodes: &Nodes,
    stored: &FitRecord,
    earlier: Option<Arc<[Earlier]>>,
    requested: Include,
    plans: &Plans,
) -> Result<Arc<str>, Problem> {
    let mut spec = stored_spec(stored, earlier)?;
    let include = include::both(spec.include, requested);
    if include == spec.include {
        return Ok(stored.result.clone());
    }
    spec.include = include;
    let more = compute(nodes, &spec, plans)?;
    merge::added(&stored.result, &more.result, &["warnings"]).map(Arc::from).map_err(Problem::internal)
}

/// Repeats a stored fit with the figures of its flank from the current measurand, gear and
/// requirements. CPU-bound.
pub fn again(
    nodes: &Nodes,
    stored: &FitRecord,
    earlier: Option<Arc<[Earlier]>>,
    plans: &Plans,
    on: &OfFlank,
) -> Result<Computed, Problem> {
    compute_on(nodes, &stored_spec(stored, earlier)?, plans, Some(on))
}

/// The spec of a stored fit, with the earlier iterations that it stood on.
fn stored_spec(stored: &FitRecord, earlier: Option<Arc<[Earlier]>>) -> Result<FitSpec, Problem> {
    let spec = reader::read_stored(&stored.spec).map_err(Problem::internal)?;
    Ok(match earlier {
        Some(earlier) => spec.with_earlier(earlier),
        None => spec,
    })
}

/// Data of a stored fit that other fits use.
pub enum Given {
    Piece(Box<Piece>),
    /// It is regularised otherwise, or not at all.
    NotSpectral,
    /// Its B is that of standardised columns, and none for the posted ones.
    Standardized,
    /// It raised no eigenvalue: its B is 0.
    NothingRaised,
}

/// Returns the data of a stored fit that other fits use. CPU-bound.
pub fn piece(nodes: &Nodes, stored: &FitRecord) -> Result<Given, Problem> {
    let spec = stored_spec(stored, None)?;
    if !matches!(spec.regularization, Regularization::Spectral { .. }) {
        return Ok(Given::NotSpectral);
    }
    if spec.scaling == Scaling::Standardized {
        return Ok(Given::Standardized);
    }
    let spec = FitSpec { include: Include { representative: true, ..Include::default() }, predict: None, ..spec };
    let found = fit(nodes, &spec).map_err(Problem::internal)?.representative;
    Ok(found.map_or(Given::NothingRaised, |piece| Given::Piece(Box::new(piece))))
}

/// Computes a stored fit again and compares. Processor work.
pub fn replay(nodes: &Nodes, stored: &FitRecord, earlier: Option<Arc<[Earlier]>>) -> Result<Replay, Problem> {
    let spec = stored_spec(stored, earlier)?;
    // all of it anew, plans too
    let computed = compute(nodes, &spec, &Plans::default())?;
    Replay::of(&stored.result, &computed.result, difference).map_err(Problem::internal)
}

fn difference(stored: &str, replayed: &str) -> Result<Difference, serde_json::Error> {
    let (stored, replayed): (Value, Value) = (serde_json::from_str(stored)?, serde_json::from_str(replayed)?);
    let engine = |answer: &Value| answer["provenance"]["engine"].as_str().map(str::to_owned);
    Ok(Difference {
        max_relative_difference: largest_difference(&stored, &replayed),
        stored_engine: engine(&stored),
        replay_engine: engine(&replayed),
    })
}

/// Returns it over all numbers at the same places; `None` if the responses differ in structure.
fn largest_difference(a: &Value, b: &Value) -> Option<f64> {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64()?, b.as_f64()?);
            let size = a.abs().max(b.abs());
            Some(if a == b { 0.0 } else { (a - b).abs() / size })
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).try_fold(0.0, |most: f64, (a, b)| Some(most.max(largest_difference(a, b)?)))
        }
        (Value::Object(a), Value::Object(b)) if a.len() == b.len() => {
            a.iter().try_fold(0.0, |most: f64, (key, a)| Some(most.max(largest_difference(a, b.get(key)?)?)))
        }
        (Value::String(_), Value::String(_)) | (Value::Null, Value::Null) => Some(0.0),
        (Value::Bool(a), Value::Bool(b)) if a == b => Some(0.0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_relative_and_need_the_same_places() {
        let stored = r#"{"a":[1.0,2.0],"b":{"c":-4.0},"provenance":{"engine":"old 1"}}"#;
        let found = difference(stored, r#"{"a":[1.0,2.0],"b":{"c":-4.5},"provenance":{"engine":"new 2"}}"#).unwrap();
        assert_eq!(found.max_relative_difference, Some(0.5 / 4.5));
        assert_eq!((found.stored_engine.as_deref(), found.replay_engine.as_deref()), (Some("old 1"), Some("new 2")));
        assert_eq!(difference(stored, r#"{"a":[1.0],"b":{},"provenance":{}}"#).unwrap().max_relative_difference, None);
    }

    #[test]
    fn a_replay_of_the_same_text_does_not_look_further() {
        let replay = Replay::of("{}", "{}", |_, _| Err("they are the same")).unwrap();
        assert_eq!(serde_json::to_string(&ReplayBody::from(replay)).unwrap(), r#"{"identical":true}"#);
    }
}
