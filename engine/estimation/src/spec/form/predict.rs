use flankfit_numerics::{alternatives, check::Fault};
use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::{fault, list, number};
use crate::spec::{Kinds, Places};

/// Heights, slopes and bands of the fitted curve or surface at places of its domain.
#[skip_serializing_none]
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"at": {"grid": {"u": [0, 10, 20], "v": [0, 5]}}, "kinds": ["confidence", "simultaneous"]}))]
pub(in crate::spec) struct Predict {
    /// The places.
    at: At,
    /// Level of the bands; by default that of the fit's intervals.
    #[schema(exclusive_minimum = 0.5, exclusive_maximum = 1)]
    level: Option<f64>,
    /// Kinds of bands. Default `["confidence"]`.
    #[serde(default = "confidence")]
    kinds: Vec<Band>,
    /// If true, slopes with their intervals are included.
    #[serde(default)]
    slopes: bool,
}

fn confidence() -> Vec<Band> {
    vec![Band::Confidence]
}

/// Places in the unit of the nodes: `x` for a curve or, as rows, for a linear model; `u` and `v`
/// (one pair for each point) or `grid` for a surface.
#[skip_serializing_none]
#[derive(Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Places)]
pub(in crate::spec) struct At {
    x: Option<PlacesX>,
    /// u of each point of a surface.
    #[schema(min_items = 1)]
    u: Option<Vec<f64>>,
    /// v of each point, as many as u.
    #[schema(min_items = 1)]
    v: Option<Vec<f64>>,
    grid: Option<PlacesGrid>,
}

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
pub(in crate::spec) enum PlacesX {
    Curve(Vec<f64>),
    Rows(Vec<Vec<f64>>),
}

alternatives!(
    PlacesX,
    "Abscissae of a curve, or rows with a number for each column of a measurement matrix.",
    list(number(), None).min_items(Some(1)),
    list(list(number(), None), None).min_items(Some(1)),
);

/// Every combination of the axes, v running fastest.
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::spec) struct PlacesGrid {
    /// Abscissae along u.
    #[schema(min_items = 1)]
    u: Vec<f64>,
    /// Abscissae along v.
    #[schema(min_items = 1)]
    v: Vec<f64>,
}

/// A band: `confidence` holds for the true height at each single place, `prediction` for a further
/// measurement of weight 1, `simultaneous` for the true heights of the whole domain at once (with a
/// linear model: of all requested rows). Coverage is documented in docs/explanation/intervals.md. A
/// fit of n coefficients allows 2,000,000/n places, at most 100,000; with a norm limit a sixteenth
/// of that.
#[derive(PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::spec) enum Band {
    Confidence,
    Prediction,
    Simultaneous,
}

impl TryFrom<Predict> for super::super::Predict {
    type Error = Fault;

    fn try_from(Predict { at, level, kinds, slopes }: Predict) -> Result<Self, Fault> {
        let at = match at {
            At { x: Some(PlacesX::Curve(x)), u: None, v: None, grid: None } => Places::Curve(x),
            At { x: Some(PlacesX::Rows(rows)), u: None, v: None, grid: None } => Places::Rows(rows),
            At { x: None, u: Some(u), v: Some(v), grid: None } => Places::Points { u, v },
            At { x: None, u: None, v: None, grid: Some(PlacesGrid { u, v }) } => Places::Grid { u, v },
            _ => {
                let forms = "give either `x` (of a curve or a linear model), or `u` and `v`, or `grid` (of a surface)";
                return Err(fault("at", forms));
            }
        };
        let kinds = Kinds {
            confidence: kinds.contains(&Band::Confidence),
            prediction: kinds.contains(&Band::Prediction),
            simultaneous: kinds.contains(&Band::Simultaneous),
        };
        Ok(Self { at, level, kinds, slopes })
    }
}

impl From<super::super::Predict> for Predict {
    fn from(super::super::Predict { at, level, kinds, slopes }: super::super::Predict) -> Self {
        let at = match at {
            Places::Curve(x) => At { x: Some(PlacesX::Curve(x)), ..At::default() },
            Places::Rows(x) => At { x: Some(PlacesX::Rows(x)), ..At::default() },
            Places::Points { u, v } => At { u: Some(u), v: Some(v), ..At::default() },
            Places::Grid { u, v } => At { grid: Some(PlacesGrid { u, v }), ..At::default() },
        };
        let bands = [
            (kinds.confidence, Band::Confidence),
            (kinds.prediction, Band::Prediction),
            (kinds.simultaneous, Band::Simultaneous),
        ];
        Predict { at, level, kinds: bands.into_iter().filter_map(|(is, band)| is.then_some(band)).collect(), slopes }
    }
}
