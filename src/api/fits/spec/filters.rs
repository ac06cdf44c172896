//! Filters of a fit request as they are written.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::json::present::present;
use flankfit_engine::estimation::spec;

/// Default window and threshold of a Hampel filter.
pub const DEFAULT_WINDOW: usize = 7;
pub const DEFAULT_THRESHOLD: f64 = 3.0;
/// How many filters a request may have.
pub const MOST_FILTERS: usize = 16;

/// A filter of the heights, for curves and grids (`hampel` also for the rows of a matrix).
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = Filter, discriminator(property_name = "type", mapping(
    ("hampel" = "#/components/schemas/HampelFilter"),
    ("gaussian" = "#/components/schemas/GaussianFilter"),
    ("spline" = "#/components/schemas/SplineFilter")
)))]
pub enum FilterBody {
    Hampel(HampelFilter),
    Gaussian(GaussianFilter),
    Spline(SplineFilter),
}

/// Peaks: nodes further than `threshold` robust standard deviations (1.4826 MAD) from the median of
/// their window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct HampelFilter {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: HampelTag,
    /// Nodes of the window, odd; on a grid without `axis` those of each side of a square. Default
    /// 7.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 3, default = json!(DEFAULT_WINDOW))]
    pub window: Option<usize>,
    /// Default 3.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, default = json!(DEFAULT_THRESHOLD))]
    pub threshold: Option<f64>,
    /// Treatment of a peak. Default `replace`.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub action: Option<PeakAction>,
    /// On a grid, the axis along which windows lie; a square of both axes when not given.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub axis: Option<FilterAxisName>,
}

/// Gaussian profile filter, low-pass: linear (ISO 16610-21) or robust (ISO 16610-31).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct GaussianFilter {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: GaussianTag,
    /// Needed on a grid; a curve has `u` only.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub axis: Option<FilterAxisName>,
    /// Wavelength that is halved, in the unit of the axis; longer than twice the closest spacing.
    #[schema(exclusive_minimum = 0)]
    pub cutoff: f64,
    /// Default false.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub robust: Option<bool>,
    /// Order of the robust regression, 0 or 2; with `robust` only. Default 2, which keeps
    /// parabolas.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0, maximum = 2)]
    pub order: Option<u8>,
}

/// Spline profile filter (ISO 16610-22), low-pass, linear, with natural ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SplineFilter {
    #[serde(rename = "type")]
    #[schema(inline)]
    pub kind: SplineTag,
    /// Needed on a grid; a curve has `u` only.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    pub axis: Option<FilterAxisName>,
    /// Wavelength that is halved, in the unit of the axis; longer than twice the closest spacing.
    #[schema(exclusive_minimum = 0)]
    pub cutoff: f64,
}

/// Declares an enum of names.
macro_rules! names {
    ($($(#[$doc:meta])* $name:ident { $($value:ident),* $(,)? })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum $name { $($value),* }
    )*};
}

names! {
    /// The variant.
    HampelTag { Hampel }
    /// The variant.
    GaussianTag { Gaussian }
    /// The variant.
    SplineTag { Spline }
    /// A peak is replaced by the median of its window, or counts as missing.
    PeakAction { Replace, Remove }
    /// The axis along which something runs; the x of a curve is `u`.
    FilterAxisName { U, V }
    /// Which filter.
    FilterName { Hampel, Gaussian, Spline }
}

impl From<FilterAxisName> for spec::FilterAxis {
    fn from(name: FilterAxisName) -> Self {
        match name {
            FilterAxisName::U => spec::FilterAxis::U,
            FilterAxisName::V => spec::FilterAxis::V,
        }
    }
}

impl From<spec::FilterAxis> for FilterAxisName {
    fn from(axis: spec::FilterAxis) -> Self {
        match axis {
            spec::FilterAxis::U => FilterAxisName::U,
            spec::FilterAxis::V => FilterAxisName::V,
        }
    }
}

impl From<&spec::Filter> for FilterBody {
    /// Every default written out.
    fn from(filter: &spec::Filter) -> Self {
        let axis = |axis: Option<spec::FilterAxis>| axis.map(FilterAxisName::from);
        match filter {
            spec::Filter::Hampel(f) => FilterBody::Hampel(HampelFilter {
                kind: HampelTag::Hampel,
                window: Some(f.window),
                threshold: Some(f.threshold + 0.0),
                action: Some(match f.action {
                    spec::Action::Replace => PeakAction::Replace,
                    spec::Action::Remove => PeakAction::Remove,
                }),
                axis: axis(f.axis),
            }),
            spec::Filter::Gaussian(f) => FilterBody::Gaussian(GaussianFilter {
                kind: GaussianTag::Gaussian,
                axis: axis(f.axis),
                cutoff: f.cutoff,
                robust: Some(f.robust.is_some()),
                order: f.robust.map(|order| match order {
                    spec::Order::Zero => 0,
                    spec::Order::Two => 2,
                }),
            }),
            spec::Filter::Spline(f) => {
                FilterBody::Spline(SplineFilter { kind: SplineTag::Spline, axis: axis(f.axis), cutoff: f.cutoff })
            }
        }
    }
}
