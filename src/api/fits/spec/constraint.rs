//! Conditions on the shape of the fitted function, as they are written.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{filters::FilterAxisName, zeros::unsigned_zero};
use crate::api::{json::present::present, shapes::domain::DomainBody};
use flankfit_engine::estimation::spec::{Constraint, ConstraintKind, Domain};

/// How many constraints a request may have.
pub const MOST_CONSTRAINTS: usize = 16;

/// A condition on the shape of the fitted curve or surface. It holds everywhere in its domain, not
/// only at the nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Constraint, example = json!({"kind": "concave", "along": "v"}))]
pub struct ConstraintBody {
    pub kind: ConstraintName,
    /// The axis along which the function rises, falls or bends. A surface needs it; a curve has
    /// only `u`, its x.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub along: Option<FilterAxisName>,
    /// Where the constraint applies, within the domain of the fit; default the whole domain.
    /// Opposite constraints along an axis must not touch.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub domain: Option<DomainBody>,
}

/// Shape along the axis: `increasing` and `decreasing` limit the first derivative, which may be 0;
/// `convex` and `concave` limit the second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ConstraintKind)]
pub enum ConstraintName {
    Increasing,
    Decreasing,
    Convex,
    Concave,
}

impl From<ConstraintName> for ConstraintKind {
    fn from(name: ConstraintName) -> Self {
        match name {
            ConstraintName::Increasing => ConstraintKind::Increasing,
            ConstraintName::Decreasing => ConstraintKind::Decreasing,
            ConstraintName::Convex => ConstraintKind::Convex,
            ConstraintName::Concave => ConstraintKind::Concave,
        }
    }
}

impl From<ConstraintKind> for ConstraintName {
    fn from(kind: ConstraintKind) -> Self {
        match kind {
            ConstraintKind::Increasing => ConstraintName::Increasing,
            ConstraintKind::Decreasing => ConstraintName::Decreasing,
            ConstraintKind::Convex => ConstraintName::Convex,
            ConstraintKind::Concave => ConstraintName::Concave,
        }
    }
}

impl From<ConstraintBody> for Constraint {
    fn from(body: ConstraintBody) -> Self {
        let interval = |ends: [f64; 2]| ends.map(unsigned_zero);
        Constraint {
            kind: body.kind.into(),
            along: body.along.map(Into::into),
            domain: body.domain.map(|domain| Domain { u: domain.u.map(interval), v: domain.v.map(interval) }),
        }
    }
}

impl From<&Constraint> for ConstraintBody {
    fn from(constraint: &Constraint) -> Self {
        ConstraintBody {
            kind: constraint.kind.into(),
            along: constraint.along.map(FilterAxisName::from),
            domain: constraint.domain.map(|domain| DomainBody { u: domain.u, v: domain.v }),
        }
    }
}
