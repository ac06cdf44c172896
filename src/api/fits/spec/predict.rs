//! Places at which a fit is asked for heights, as they are written.

use serde::{Deserialize, Deserializer, Serialize};
use utoipa::ToSchema;

use crate::api::{
    fits::spec::knots::{NumbersOrRows, numbers_or_rows},
    json::{
        present::present,
        union_schema::{documented, list},
    },
};
use flankfit_engine::estimation::spec;

/// Heights, slopes and bands of the fitted curve or surface at places of its domain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Predict, example = json!({"at": {"grid": {"u": [0, 10, 20], "v": [0, 5]}}, "kinds": ["confidence", "simultaneous"]}))]
pub struct PredictBody {
    /// The places.
    pub at: PlacesBody,
    /// Level of the bands; by default that of the fit's intervals.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0.5, exclusive_maximum = 1)]
    pub level: Option<f64>,
    /// Which bands; default `["confidence"]`.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub kinds: Option<Vec<BandName>>,
    /// If true, slopes with their intervals are included; default false.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub slopes: Option<bool>,
}

/// Places in the unit of the nodes: `x` for a curve or, as rows, for a linear model; `u` and `v`
/// (one pair for each point) or `grid` for a surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Places)]
pub struct PlacesBody {
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub x: Option<PlacesXBody>,
    /// u of each point of a surface.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1)]
    pub u: Option<Vec<f64>>,
    /// v of each point, as many as u.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1)]
    pub v: Option<Vec<f64>>,
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub grid: Option<PlacesGridBody>,
}

/// Numbers for a curve, rows of numbers for a linear model.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum PlacesXBody {
    Curve(Vec<f64>),
    Rows(Vec<Vec<f64>>),
}

documented!(
    PlacesXBody,
    "PlacesX",
    "Abscissae of a curve, or rows with a number for each column of a measurement matrix.",
    list(f64::schema(), None).min_items(Some(1)),
    list(list(f64::schema(), None), None).min_items(Some(1)),
);

impl<'de> Deserialize<'de> for PlacesXBody {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match numbers_or_rows(deserializer, "an array of numbers (curve) or rows of numbers (linear model)")? {
            NumbersOrRows::Numbers(x) => PlacesXBody::Curve(x),
            NumbersOrRows::Rows(rows) => PlacesXBody::Rows(rows),
        })
    }
}

/// Every combination of the axes, v running fastest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = PlacesGrid)]
pub struct PlacesGridBody {
    /// Abscissae along u.
    #[schema(min_items = 1)]
    pub u: Vec<f64>,
    /// Abscissae along v.
    #[schema(min_items = 1)]
    pub v: Vec<f64>,
}

/// A band: `confidence` holds for the true height at each single place, `prediction` for a further
/// measurement of weight 1, `simultaneous` for the true heights of the whole domain at once (with a
/// linear model: of all requested rows). Coverage is documented in docs/intervals.md. A fit of n
/// coefficients takes 2,000,000/n places, at most 100,000; with a norm limit a sixteenth of that.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = Band)]
pub enum BandName {
    Confidence,
    Prediction,
    Simultaneous,
}

impl From<&spec::Predict> for PredictBody {
    fn from(predict: &spec::Predict) -> Self {
        let spec::Predict { at, level, kinds, slopes } = predict;
        let names = [
            (kinds.confidence, BandName::Confidence),
            (kinds.prediction, BandName::Prediction),
            (kinds.simultaneous, BandName::Simultaneous),
        ];
        PredictBody {
            at: match at.clone() {
                spec::Places::Curve(x) => PlacesBody { x: Some(PlacesXBody::Curve(x)), ..PlacesBody::default() },
                spec::Places::Rows(x) => PlacesBody { x: Some(PlacesXBody::Rows(x)), ..PlacesBody::default() },
                spec::Places::Points { u, v } => PlacesBody { u: Some(u), v: Some(v), ..PlacesBody::default() },
                spec::Places::Grid { u, v } => {
                    PlacesBody { grid: Some(PlacesGridBody { u, v }), ..PlacesBody::default() }
                }
            },
            level: *level,
            kinds: Some(names.into_iter().filter_map(|(wanted, name)| wanted.then_some(name)).collect()),
            slopes: Some(*slopes),
        }
    }
}
