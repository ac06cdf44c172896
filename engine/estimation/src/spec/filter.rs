//! Filters as plain values; ranges are checked on reading a request, the rest is checked against
//! the nodes.

#[cfg(feature = "contract")]
use super::form;

/// One filter; filters are applied in the requested order.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{
///         Action, Degree, Filter, Gaussian, Hampel, Include, Model, PolynomialBasis, Spline,
///         Terms,
///     },
/// };
/// use std::f64::consts::TAU;
///
/// let x: Vec<f64> = (0..=400).map(|k| 0.05 * f64::from(k)).collect();
/// let model = Model::Polynomial {
///     degree: Degree::Both(1),
///     basis: PolynomialBasis::Legendre,
///     terms: Terms::Tensor,
/// };
/// let filtered = |y: Vec<f64>, filter: Filter| {
///     let nodes = Nodes::curve(x.clone(), y, None)?;
///     let include = Include { peaks: true, ..Include::default() };
///     let filters = vec![filter];
///     let found = fit(&nodes, &FitSpec { filters, include, ..FitSpec::new(model.clone()) })?;
///     Ok::<_, Box<dyn std::error::Error>>(found.filters.expect("there is a filter").remove(0))
/// };
/// // A peak lies far from the median of its window.
/// let mut flat: Vec<f64> = x.iter().map(|x| 0.01 * (9.0 * x).sin()).collect();
/// flat[123] = 5.0;
/// let hampel = Hampel { window: 11, threshold: 6.0, action: Action::Remove, axis: None };
/// assert_eq!(filtered(flat, Filter::Hampel(hampel))?.node_indices, Some(vec![123]));
///
/// // A wave of the length of the cut-off is halved, by either low-pass filter.
/// let wave: Vec<f64> = x.iter().map(|x| (TAU * x / 0.8).sin()).collect();
/// let gaussian = Gaussian { axis: None, cutoff: 0.8, robust: None };
/// for filter in [Filter::Gaussian(gaussian), Filter::Spline(Spline { axis: None, cutoff: 0.8 })] {
///     let change = filtered(wave.clone(), filter)?.rms_change;
///     assert!((change - 0.5 / 2f64.sqrt()).abs() < 0.01, "{change}");
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "form::Filter", into = "form::Filter")
)]
pub enum Filter {
    /// Peaks are found by the distance from the median of a window.
    Hampel(Hampel),
    /// Low-pass with a Gaussian weighting function.
    Gaussian(Gaussian),
    /// Low-pass by a smoothing spline.
    Spline(Spline),
}

impl Filter {
    /// Stable name.
    pub fn name(&self) -> &'static str {
        match self {
            Filter::Hampel(_) => "hampel",
            Filter::Gaussian(_) => "gaussian",
            Filter::Spline(_) => "spline",
        }
    }
}

/// A node is a peak when it differs from the median of its window by more than `threshold · S`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hampel {
    /// Nodes of the window, odd and at least 3; on a grid without `axis`, of each side of a square.
    pub window: usize,
    /// Threshold in robust standard deviations, not negative.
    pub threshold: f64,
    /// Treatment of a peak.
    pub action: Action,
    /// On a grid, the axis along which windows lie; a square of both when not given.
    pub axis: Option<FilterAxis>,
}

/// A peak is replaced by the median of its window, or counts as missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = PeakAction)
)]
pub enum Action {
    /// It takes the median of its window.
    #[default]
    Replace,
    /// It counts as missing from there on.
    Remove,
}

/// Gaussian profile filter: linear (ISO 16610-21) or robust (ISO 16610-31).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian {
    /// Needed on a grid; a curve has `u` only.
    pub axis: Option<FilterAxis>,
    /// λc, in the unit of the axis: a wave of this length is halved.
    pub cutoff: f64,
    /// The order of the robust regression; `None` for the linear filter.
    pub robust: Option<Order>,
}

/// Order of the polynomial that is fitted under the window of the robust filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// A constant: a weighted mean.
    Zero,
    /// A parabola, which follows form better towards the ends.
    #[default]
    Two,
}

/// Spline profile filter (ISO 16610-22).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spline {
    /// Needed on a grid; a curve has `u` only.
    pub axis: Option<FilterAxis>,
    /// λc, in the unit of the axis: a wave of this length is halved.
    pub cutoff: f64,
}

/// The axis along which something runs; the x of a curve is `u`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum FilterAxis {
    /// Along u, or along the abscissae of a curve.
    U,
    /// Along v.
    V,
}
