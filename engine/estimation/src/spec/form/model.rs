use flankfit_numerics::{alternatives, check::Fault, words::counted};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{fault, list, number};
use crate::spec::{Degree, Knots, PolynomialBasis, Spans, Terms};

/// The basis functions of the fit.
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub(in crate::spec) enum Model {
    /// Polynomials.
    Polynomial {
        degree: Degree,
        /// Functions that the coefficients belong to.
        #[serde(default)]
        basis: PolynomialBasis,
        #[serde(default)]
        terms: Terms,
    },
    /// B-splines, or NURBS with `weights`; either `knots` or `spans`.
    BSpline {
        degree: Degree,
        /// Full knot vectors, ascending; the last span is closed on the right.
        #[serde(skip_serializing_if = "Option::is_none")]
        knots: Option<KnotVectors>,
        /// Equal spans over the domain.
        #[serde(skip_serializing_if = "Option::is_none")]
        spans: Option<Spans>,
        /// For NURBS: one weight above 0 for each control point, for a surface in rows along u.
        /// They are given, not fitted.
        #[serde(skip_serializing_if = "Option::is_none")]
        weights: Option<Weights>,
    },
    /// The columns of a measurement matrix as they are; for nodes of type `matrix`.
    Linear {},
}

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
pub(in crate::spec) enum KnotVectors {
    Curve(Vec<f64>),
    Surface([Vec<f64>; 2]),
}

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
pub(in crate::spec) enum Weights {
    Curve(Vec<f64>),
    Surface(Vec<Vec<f64>>),
}

alternatives!(
    KnotVectors,
    "Full knot vectors, ascending: one for a curve, `[knots of u, knots of v]` for a surface.",
    list(number(), None),
    list(list(number(), None), Some((2, 2))),
);
alternatives!(
    Weights,
    "Weights of control points: numbers for a curve, rows of numbers for a surface.",
    list(number(), None),
    list(list(number(), None), None),
);

impl TryFrom<Model> for super::super::Model {
    type Error = Fault;

    fn try_from(model: Model) -> Result<Self, Fault> {
        Ok(match model {
            Model::Polynomial { degree, basis, terms } => Self::Polynomial { degree, basis, terms },
            Model::BSpline { degree, knots, spans, weights } => Self::BSpline {
                degree,
                knots: match (knots, spans) {
                    (Some(KnotVectors::Curve(knots)), None) => Knots::Curve(knots),
                    (Some(KnotVectors::Surface([u, v])), None) => Knots::Surface(u, v),
                    (None, Some(Spans::Both(n))) => Knots::Spans(n),
                    (None, Some(Spans::Each(a, b))) => Knots::SpansEach(a, b),
                    (Some(_), Some(_)) => return Err(fault("spans", "give either `knots` or `spans`, not both")),
                    (None, None) => return Err(fault("", "give `knots` or `spans`")),
                },
                weights: match weights {
                    None => None,
                    Some(Weights::Curve(weights)) => Some(weights),
                    Some(Weights::Surface(rows)) => Some(flat(&rows)?),
                },
            },
            Model::Linear {} => Self::Linear,
        })
    }
}

/// Returns rows of one length, end to end.
fn flat(rows: &[Vec<f64>]) -> Result<Vec<f64>, Fault> {
    let columns = rows.first().map_or(0, Vec::len);
    match rows.iter().enumerate().find(|(_, row)| row.len() != columns) {
        None => Ok(rows.concat()),
        Some((i, row)) => Err(fault(
            &format!("weights[{i}]"),
            format_args!("{}, where the first row has {columns}", counted(row.len(), "weight", "weights")),
        )),
    }
}

impl From<super::super::Model> for Model {
    fn from(model: super::super::Model) -> Self {
        match model {
            super::super::Model::Polynomial { degree, basis, terms } => Model::Polynomial { degree, basis, terms },
            super::super::Model::BSpline { degree, knots, weights } => {
                let weights = weights.map(|weights| match columns(degree, &knots) {
                    // Without knots the curve and the surface of one row look alike; both are read
                    // as the same weights.
                    None => Weights::Curve(weights),
                    Some(columns) => Weights::Surface(weights.chunks(columns).map(<[f64]>::to_vec).collect()),
                });
                let (knots, spans) = match knots {
                    Knots::Curve(knots) => (Some(KnotVectors::Curve(knots)), None),
                    Knots::Surface(u, v) => (Some(KnotVectors::Surface([u, v])), None),
                    Knots::Spans(n) => (None, Some(Spans::Both(n))),
                    Knots::SpansEach(a, b) => (None, Some(Spans::Each(a, b))),
                };
                Model::BSpline { degree, knots, spans, weights }
            }
            super::super::Model::Linear => Model::Linear {},
        }
    }
}

/// Returns the number of functions along v, if the knots show that there is a v.
fn columns(degree: Degree, knots: &Knots) -> Option<usize> {
    let (Degree::Both(q) | Degree::Each(_, q)) = degree;
    match knots {
        Knots::Surface(_, v) => v.len().checked_sub(q.saturating_add(1)).filter(|columns| *columns > 0),
        Knots::SpansEach(_, spans) => spans.checked_add(q),
        Knots::Curve(_) | Knots::Spans(_) => None,
    }
}
