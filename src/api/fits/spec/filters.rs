//! Filters of a fit request as they are written, and what an answer says of them.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::json::{present::present, writer::Object};
use flankfit_engine::estimation::{
    result::{ColumnFigures, FilterReport, FilteringReport, IterationReport},
    spec,
};

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
    /// What becomes of a peak. Default `replace`.
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
    /// A peak takes the median of its window, or counts as missing from there on.
    PeakAction { Replace, Remove }
    /// The axis along which a filter runs; the x of a curve is `u`.
    FilterAxisName { U, V }
    /// Which filter.
    FilterName { Hampel, Gaussian, Spline }
}

/// What one filter changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FilterResult {
    #[serde(rename = "type")]
    pub kind: FilterName,
    /// Nodes whose height is another one now, or that were removed.
    pub changed: usize,
    /// Of them, those that count no more.
    pub removed: usize,
    /// Largest change of a height; of a removed node its distance from the median of its window.
    pub max_change: f64,
    /// Root mean square of the changes, over the nodes that counted before this filter.
    pub rms_change: f64,
    /// Posted nodes (from 0, grids row by row) that were taken for peaks; of `hampel` only, present
    /// when `peaks` was included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node_indices: Option<Vec<usize>>,
    /// Rounds of the line that took the most; of a robust filter only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub iterations: Option<usize>,
    /// Whether every line came to rest; of a robust filter only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub converged: Option<bool>,
}

/// How the columns depend on each other before and after the filters, which smooth away what tells
/// terms apart. `after` is of the matrix that the filters make of X, removed nodes left out, with
/// peaks and robustness weights as the heights decided them; the fit itself is of the filtered
/// heights to X.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FilterCollinearity {
    pub before: ColumnFiguresBody,
    pub after: ColumnFiguresBody,
}

/// Figures of a measurement matrix.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ColumnFigures)]
pub struct ColumnFiguresBody {
    /// Counted nodes.
    pub count: usize,
    /// λₙ/λ₁ on columns of unit length; absent when it cannot be given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// Largest |Pearson correlation| of two columns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_correlation: Option<f64>,
    /// Largest variance inflation factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_vif: Option<f64>,
}

impl From<FilterAxisName> for spec::FilterAxis {
    fn from(name: FilterAxisName) -> Self {
        match name {
            FilterAxisName::U => spec::FilterAxis::U,
            FilterAxisName::V => spec::FilterAxis::V,
        }
    }
}

impl From<&spec::Filter> for FilterBody {
    /// Every default written out.
    fn from(filter: &spec::Filter) -> Self {
        let axis = |axis: Option<spec::FilterAxis>| {
            axis.map(|axis| match axis {
                spec::FilterAxis::U => FilterAxisName::U,
                spec::FilterAxis::V => FilterAxisName::V,
            })
        };
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

/// Writes the fields `filters` and `filter_collinearity` of the answer.
pub(in crate::api) fn write(object: &mut Object<'_>, report: &FilteringReport, peaks: bool) {
    let FilteringReport { filters, before, after } = report;
    object.list("filters", filters, |object, filter| write_filter(object, filter, peaks)).object(
        "filter_collinearity",
        |object| {
            object
                .object("before", |object| write_figures(object, before))
                .object("after", |object| write_figures(object, after));
        },
    );
}

fn write_filter(object: &mut Object<'_>, report: &FilterReport, by_node: bool) {
    let FilterReport { filter, changed, max_change, rms_change, peaks, iteration } = report;
    let name = match filter {
        spec::Filter::Hampel(_) => "hampel",
        spec::Filter::Gaussian(_) => "gaussian",
        spec::Filter::Spline(_) => "spline",
    };
    object
        .string("type", name)
        .count("changed", *changed)
        .count("removed", report.removed())
        .number("max_change", *max_change)
        .number("rms_change", *rms_change);
    if let Some(peaks) = peaks.as_ref().filter(|_| by_node) {
        object.counts("node_indices", peaks);
    }
    if let Some(IterationReport { iterations, converged }) = iteration {
        object.count("iterations", *iterations).field("converged", converged);
    }
}

fn write_figures(object: &mut Object<'_>, figures: &ColumnFigures) {
    let ColumnFigures { nodes, condition, largest_correlation, largest_vif } = figures;
    object
        .count("count", *nodes)
        .maybe_number("condition", *condition)
        .maybe_number("largest_correlation", *largest_correlation)
        .maybe_number("largest_vif", *largest_vif);
}
