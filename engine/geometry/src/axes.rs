//! Degrees, spans and intervals of the parameters u and v.

#[cfg(feature = "contract")]
use flankfit_numerics::contract::{list, whole};

/// One degree for every axis, or one for each (`[p, q]`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize), serde(untagged))]
pub enum Degree {
    /// The same degree on every axis.
    Both(usize),
    /// Degree along u and along v.
    Each(usize, usize),
}

impl Degree {
    /// Returns the degrees along u and v.
    pub fn each(self) -> [usize; 2] {
        match self {
            Degree::Both(degree) => [degree; 2],
            Degree::Each(u, v) => [u, v],
        }
    }
}

/// Equal spans over the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize), serde(untagged))]
pub enum Spans {
    /// The same number on every axis.
    Both(usize),
    /// A number for each axis.
    Each(usize, usize),
}

impl Spans {
    /// Returns the spans along u and v.
    pub fn each(self) -> [usize; 2] {
        match self {
            Spans::Both(spans) => [spans; 2],
            Spans::Each(u, v) => [u, v],
        }
    }
}

/// Intervals of the parameters. A curve has `u` only.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(deny_unknown_fields)
)]
pub struct Domain {
    /// Interval of u (of x for a curve): [min, max]; by default that of the counted nodes.
    #[cfg_attr(
        feature = "contract",
        serde(skip_serializing_if = "Option::is_none"),
        schema(value_type = Option<Vec<f64>>, min_items = 2, max_items = 2, example = json!([0.0, 1.0]))
    )]
    pub u: Option<[f64; 2]>,
    /// Interval of v: [min, max]; by default that of the counted nodes.
    #[cfg_attr(
        feature = "contract",
        serde(skip_serializing_if = "Option::is_none"),
        schema(value_type = Option<Vec<f64>>, min_items = 2, max_items = 2, example = json!([0.0, 1.0]))
    )]
    pub v: Option<[f64; 2]>,
}

#[cfg(feature = "contract")]
flankfit_numerics::alternatives!(
    Degree,
    "Degree of a curve. Of a surface one for each direction, `[p, q]`; `2` is `[2, 2]`, the tensor degree in both \
     directions (terms up to u²v²), and not a total degree, unless `terms` is `total`.",
    whole(0),
    list(whole(0), Some((2, 2))),
);

#[cfg(feature = "contract")]
flankfit_numerics::alternatives!(
    Spans,
    "Equal spans over the domain, the same number on every axis or one for each: `8` or `[a, b]`.",
    whole(1),
    list(whole(1), Some((2, 2))),
);
