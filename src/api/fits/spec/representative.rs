//! The matrix B of a representative piece, as it is written.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use super::{model::ModelBody, model_json::model, scheme::SchemeName, zeros::unsigned_zero};
use crate::api::{
    json::{id::id, present::present, slice::Slice, tags::tags},
    shapes::domain::DomainBody,
};
use flankfit_engine::estimation::spec::{Domain, Piece, Representative, Scheme};

/// The matrix B that measurements on a representative piece gave, for others in the same directions
/// (section 6.3 of the paper): V, λ* and L are those of the piece, X is that of these nodes. Give
/// `iteration`, of iterations of a job and their further fits, or `piece`. The model has to be that
/// of the piece, and so has the domain where its functions depend on it.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct RepresentativeRegularization {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: RepresentativeTag,
    /// Number of the iteration of the job that the piece is.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1)]
    pub iteration: Option<u32>,
    /// Fit of the iteration; default its chosen fit. It must be regularised by `spectral`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fit_id: Option<Uuid>,
    /// Data of the piece, as answered with `include: ["representative"]`. Looked up, and stored
    /// with the fit, where `iteration` is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub piece: Option<PieceBody>,
}

/// The same as it is read.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawRepresentative<'a> {
    #[serde(rename = "type")]
    pub _kind: RepresentativeTag,
    #[serde(default, deserialize_with = "present")]
    pub iteration: Option<u32>,
    #[serde(default)]
    pub fit_id: Option<Id>,
    #[serde(borrow, default)]
    pub piece: Option<Slice<'a>>,
}

/// An id.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(transparent)]
pub struct Id(#[serde(deserialize_with = "id")] pub Uuid);

tags! {
    RepresentativeTag = Representative,
}

/// The data of a regularised fit that other fits use.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = RepresentativePiece)]
pub struct PieceBody {
    /// The model that was fitted.
    pub model: ModelBody,
    /// Domain of the fit; absent for a measurement matrix.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub domain: Option<DomainBody>,
    /// Default `first_order`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scheme: Option<SchemeName>,
    /// λ*.
    #[schema(exclusive_minimum = 0)]
    pub lambda_star: f64,
    /// λ₁ … λ_L of the piece.
    #[schema(min_items = 1)]
    pub eigenvalues: Vec<f64>,
    /// V₁ … V_L, orthonormal, each with an entry for each coefficient, in the piece's scaled
    /// columns.
    #[schema(min_items = 1)]
    pub directions: Vec<Vec<f64>>,
    /// Divisor of each column of the piece, above 0.
    #[schema(min_items = 1)]
    pub scale: Vec<f64>,
}

/// The same as it is read.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawPiece<'a> {
    #[serde(borrow)]
    pub model: Slice<'a>,
    #[serde(default, deserialize_with = "present")]
    pub domain: Option<DomainBody>,
    #[serde(default, deserialize_with = "present")]
    pub scheme: Option<SchemeName>,
    pub lambda_star: f64,
    pub eigenvalues: Vec<f64>,
    pub directions: Vec<Vec<f64>>,
    pub scale: Vec<f64>,
}

impl From<&Piece> for PieceBody {
    fn from(piece: &Piece) -> Self {
        let interval = |ends: [f64; 2]| ends.map(unsigned_zero);
        PieceBody {
            model: model(&piece.model),
            domain: piece.domain.map(|Domain { u, v }| DomainBody { u: u.map(interval), v: v.map(interval) }),
            scheme: Some(piece.scheme.into()),
            lambda_star: piece.lambda_star,
            eigenvalues: piece.eigenvalues.clone(),
            directions: piece.directions.iter().map(|v| v.iter().copied().map(unsigned_zero).collect()).collect(),
            scale: piece.scale.clone(),
        }
    }
}

impl From<&Representative> for RepresentativeRegularization {
    fn from(asked: &Representative) -> Self {
        RepresentativeRegularization {
            kind: RepresentativeTag::Representative,
            iteration: asked.of.iteration,
            fit_id: asked.of.fit_id.as_deref().and_then(|id| Uuid::try_parse(id).ok()),
            piece: asked.piece.as_deref().map(PieceBody::from),
        }
    }
}

impl RawPiece<'_> {
    /// The piece of a model that has been read.
    pub fn piece(self, model: flankfit_engine::estimation::spec::Model) -> Piece {
        let interval = |ends: [f64; 2]| ends.map(unsigned_zero);
        Piece {
            model,
            domain: self.domain.map(|domain| Domain { u: domain.u.map(interval), v: domain.v.map(interval) }),
            scheme: self.scheme.map_or_else(Scheme::default, Scheme::from),
            lambda_star: self.lambda_star,
            eigenvalues: self.eigenvalues,
            directions: self.directions,
            scale: self.scale,
        }
    }
}
