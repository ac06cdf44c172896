//! The answer to a fit: the engine's result, with shape and provenance.
//!
//! A value that does not exist is left out: there is no `null` and no invented number. The fit has
//! already checked that numbers are finite (`estimation::diagnostics::finite`).

use std::{borrow::Cow, ops::Deref};

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::spec::request::FitSpecBody;
use crate::api::{
    ENGINE,
    json::{
        raw::Raw,
        writer::{NotFinite, whole},
    },
    warning::WarningBody,
};
use flankfit_engine::{
    estimation::{FitResult, near::Shape},
    geometry::{curve::CurveShape, surface::SurfaceShape},
};

/// The result of a fit.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FitResult)]
pub struct FitResultBody<'a> {
    #[serde(flatten)]
    #[schema(inline)]
    pub result: Cow<'a, FitResult>,
    /// The fitted curve for nodes of type `curve`: for the model `b_spline`, with the coefficients
    /// as control points; for `polynomial` if `shape` was included, in Bernstein pieces over
    /// `domain` (several for a high degree with large oscillations). It reproduces the fitted
    /// heights to about 1e-14 of the largest.
    pub curve: Option<CurveShape>,
    /// The fitted surface for nodes with u and v: for the model `b_spline`, with the coefficients
    /// as control points; for `polynomial` if `shape` was included, as `curve`.
    pub surface: Option<SurfaceShape>,
    /// Warnings about the result.
    pub warnings: Vec<WarningBody>,
    pub provenance: ProvenanceBody,
    /// The fit request without nodes, with every default filled in. For `POST /v1/fits`; a
    /// stored fit has it next to its result.
    #[schema(value_type = Option<FitSpecBody>)]
    pub spec: Option<Raw<FitSpecBody>>,
}

/// Program and digest of the input.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = Provenance)]
pub struct ProvenanceBody {
    /// Program and version that computed the result.
    #[schema(value_type = String, example = "flankfit 0.1.0")]
    pub engine: Cow<'static, str>,
    /// SHA-256 of the canonical form of nodes and spec, independent of white space and key
    /// order.
    #[schema(min_length = 64, max_length = 64)]
    pub input_sha256: String,
}

impl<'a> FitResultBody<'a> {
    /// Creates the answer without spec; `input_sha256` is the digest of
    /// [`crate::api::fits::canonical`].
    pub fn new(result: &'a FitResult, shape: Option<&Shape>, input_sha256: String) -> Self {
        FitResultBody {
            result: Cow::Borrowed(result),
            curve: if let Some(Shape::Curve(curve)) = shape { Some(curve.clone()) } else { None },
            surface: if let Some(Shape::Surface(surface)) = shape { Some(surface.clone()) } else { None },
            warnings: result.warnings.iter().map(WarningBody::from).collect(),
            provenance: ProvenanceBody { engine: ENGINE.into(), input_sha256 },
            spec: None,
        }
    }

    /// Returns the JSON text.
    pub fn text(&self) -> Result<Vec<u8>, NotFinite> {
        whole(self)
    }
}

impl Deref for FitResultBody<'_> {
    type Target = FitResult;

    fn deref(&self) -> &FitResult {
        &self.result
    }
}
