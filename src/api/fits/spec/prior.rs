//! What was known of the coefficients before, as it is written.

use std::fmt;

use serde::{
    Deserialize, Deserializer, Serialize,
    de::{self, SeqAccess, Visitor},
};
use utoipa::{
    ToSchema,
    openapi::schema::{ObjectBuilder, Type},
};

use super::zeros::unsigned_zeros;
use crate::api::json::{
    present::present,
    union_schema::{documented, list, whole},
};
use flankfit_engine::estimation::spec::{Moves, Prior, PriorSpread, Which};

/// Prior knowledge of the coefficients: `mean` with `std_error` or `covariance`; or, for iterations
/// and their further fits, `iterations`. `value` of a coefficient is then the mean of the posterior
/// and `std_error` its standard deviation; `regularization` must be `none`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Prior, example = json!({"iterations": "previous", "move": "estimated", "correction": true}))]
pub struct PriorBody {
    /// One number for each coefficient, in the order and unit of the answer.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1)]
    pub mean: Option<Vec<f64>>,
    /// Standard deviations of independent coefficients about `mean`, each above 0.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1)]
    pub std_error: Option<Vec<f64>>,
    /// Covariance matrix of the coefficients about `mean`: its lower triangle by rows, as
    /// `covariance.coefficients` of an answer, or all of it. It has to be positive definite.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1)]
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Which earlier iterations of the job.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub iterations: Option<PriorIterationsBody>,
    /// Standard deviation of the flank's change from one iteration to the next. Default
    /// `estimated`.
    #[serde(default, rename = "move", deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub moves: Option<MoveBody>,
    /// If true, the change predicted by a correction of an earlier iteration is added to the prior.
    /// Default true.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub correction: Option<bool>,
}

/// `previous`, all earlier iterations of the same flank and tooth (the last 100 of them); or their
/// numbers, ascending. Flanks and teeth that are not given count as equal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum PriorIterationsBody {
    Previous(PreviousName),
    Listed(Vec<u32>),
}

/// `previous`
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PreviousName {
    Previous,
}

/// `estimated`, by how far the iterations lie from each other; or the standard deviation of the
/// move of each coefficient, above 0, in the order and unit of the answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum MoveBody {
    Estimated(EstimatedName),
    StdError(Vec<f64>),
}

/// `estimated`
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EstimatedName {
    Estimated,
}

documented!(
    PriorIterationsBody,
    "PriorIterations",
    "`previous`, all earlier iterations of the same flank and tooth (the last 100 of them); or their numbers, \
     ascending. Flanks and teeth that are not given count as equal.",
    ObjectBuilder::new().schema_type(Type::String).enum_values(Some(["previous"])),
    list(whole(1), Some((1, 100))),
);
documented!(
    MoveBody,
    "PriorMove",
    "`estimated` from the differences between the iterations; or the standard deviation of the move of each \
        coefficient, above 0, in the order and unit of the answer.",
    ObjectBuilder::new().schema_type(Type::String).enum_values(Some(["estimated"])),
    list(ObjectBuilder::new().schema_type(Type::Number), None).min_items(Some(1)),
);

/// A name or a list.
enum NameOrList<T> {
    Name,
    List(Vec<T>),
}

/// Reads one: the only name, and what is said where there is neither.
struct Read<T> {
    name: &'static str,
    expected: &'static str,
    entries: std::marker::PhantomData<T>,
}

impl<T> Read<T> {
    fn new(name: &'static str, expected: &'static str) -> Self {
        Read { name, expected, entries: std::marker::PhantomData }
    }
}

impl<'de, T: Deserialize<'de>> Visitor<'de> for Read<T> {
    type Value = NameOrList<T>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.expected)
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<NameOrList<T>, E> {
        if text == self.name {
            return Ok(NameOrList::Name);
        }
        Err(E::invalid_value(de::Unexpected::Str(text), &self))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<NameOrList<T>, A::Error> {
        let mut list = Vec::new();
        while let Some(entry) = entries.next_element()? {
            list.push(entry);
        }
        Ok(NameOrList::List(list))
    }
}

impl<'de> Deserialize<'de> for PriorIterationsBody {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let read = Read::new("previous", "\"previous\" or an array of numbers of iterations");
        deserializer.deserialize_any(read).map(|value| match value {
            NameOrList::Name => PriorIterationsBody::Previous(PreviousName::Previous),
            NameOrList::List(numbers) => PriorIterationsBody::Listed(numbers),
        })
    }
}

impl<'de> Deserialize<'de> for MoveBody {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let read = Read::new("estimated", "\"estimated\" or an array of numbers, one for each coefficient");
        deserializer.deserialize_any(read).map(|value| match value {
            NameOrList::Name => MoveBody::Estimated(EstimatedName::Estimated),
            NameOrList::List(deviations) => MoveBody::StdError(deviations),
        })
    }
}

/// With the iterations that were found, where somebody has looked for them.
impl From<&Prior> for PriorBody {
    fn from(prior: &Prior) -> Self {
        match prior {
            Prior::Given { mean, spread } => {
                let (std_error, covariance) = match spread.clone() {
                    PriorSpread::StdError(deviations) => (Some(deviations), None),
                    PriorSpread::Covariance(triangle) => (None, Some(triangle)),
                };
                PriorBody { mean: Some(unsigned_zeros(mean)), std_error, covariance, ..PriorBody::default() }
            }
            Prior::Iterations(chain) => {
                let found = chain.earlier.as_deref().filter(|earlier| !earlier.is_empty());
                let numbers = found.map(|earlier| earlier.iter().map(|one| one.number).collect());
                let iterations = match (numbers, &chain.which) {
                    (Some(numbers), _) => PriorIterationsBody::Listed(numbers),
                    (None, Which::Previous) => PriorIterationsBody::Previous(PreviousName::Previous),
                    (None, Which::Listed(numbers)) => PriorIterationsBody::Listed(numbers.clone()),
                };
                PriorBody {
                    iterations: Some(iterations),
                    moves: Some(match &chain.moves {
                        Moves::Estimated => MoveBody::Estimated(EstimatedName::Estimated),
                        Moves::StdError(deviations) => MoveBody::StdError(deviations.clone()),
                    }),
                    correction: Some(chain.correction),
                    ..PriorBody::default()
                }
            }
        }
    }
}
