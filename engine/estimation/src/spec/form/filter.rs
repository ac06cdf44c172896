use flankfit_numerics::check::Fault;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::fault;
use crate::spec::{Action, FilterAxis, Gaussian, Hampel, Order, Spline};

const DEFAULT_WINDOW: usize = 7;
const DEFAULT_THRESHOLD: f64 = 3.0;

/// A filter of the heights, for curves and grids (`hampel` also for the rows of a matrix).
#[derive(Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub(in crate::spec) enum Filter {
    /// Peaks: nodes further than `threshold` robust standard deviations (1.4826 MAD) from the
    /// median of their window.
    Hampel {
        /// Nodes of the window, odd; on a grid without `axis` those of each side of a square.
        #[serde(default = "window")]
        #[schema(minimum = 3, default = json!(DEFAULT_WINDOW))]
        window: usize,
        /// Distance from the median, in robust standard deviations.
        #[serde(default = "threshold")]
        #[schema(minimum = 0, default = json!(DEFAULT_THRESHOLD))]
        threshold: f64,
        /// Treatment of a peak. Default `replace`.
        #[serde(default)]
        action: Action,
        /// On a grid, the axis along which windows lie; a square of both axes when not given.
        #[serde(skip_serializing_if = "Option::is_none")]
        axis: Option<FilterAxis>,
    },
    /// Gaussian profile filter, low-pass: linear (ISO 16610-21) or robust (ISO 16610-31).
    Gaussian {
        /// Needed on a grid; a curve has `u` only.
        #[serde(skip_serializing_if = "Option::is_none")]
        axis: Option<FilterAxis>,
        /// Wavelength that is halved, in the unit of the axis; longer than twice the closest
        /// spacing.
        #[schema(exclusive_minimum = 0)]
        cutoff: f64,
        /// True for the robust filter. Default false.
        #[serde(default)]
        robust: bool,
        /// Order of the robust regression, 0 or 2; with `robust` only. Default 2, which keeps
        /// parabolas.
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schema(minimum = 0, maximum = 2)]
        order: Option<u8>,
    },
    /// Spline profile filter (ISO 16610-22), low-pass, linear, with natural ends.
    Spline {
        /// Needed on a grid; a curve has `u` only.
        #[serde(skip_serializing_if = "Option::is_none")]
        axis: Option<FilterAxis>,
        /// Wavelength that is halved, in the unit of the axis; longer than twice the closest
        /// spacing.
        #[schema(exclusive_minimum = 0)]
        cutoff: f64,
    },
}

fn window() -> usize {
    DEFAULT_WINDOW
}

fn threshold() -> f64 {
    DEFAULT_THRESHOLD
}

impl TryFrom<Filter> for super::super::Filter {
    type Error = Fault;

    fn try_from(filter: Filter) -> Result<Self, Fault> {
        Ok(match filter {
            Filter::Hampel { window, threshold, action, axis } => {
                if window < 3 || window.is_multiple_of(2) {
                    return Err(fault("window", format_args!("{window} is not an odd number from 3 on")));
                }
                Self::Hampel(Hampel { window, threshold, action, axis })
            }
            Filter::Gaussian { axis, cutoff, robust, order } => {
                let order = match (order, robust) {
                    (Some(_), false) => {
                        let message = "only the robust filter has an order; ask for `\"robust\": true`";
                        return Err(fault("order", message));
                    }
                    (None | Some(2), _) => Order::Two,
                    (Some(0), _) => Order::Zero,
                    (Some(other), _) => {
                        return Err(fault("order", format_args!("{other} is not offered; 0 and 2 are")));
                    }
                };
                Self::Gaussian(Gaussian { axis, cutoff, robust: robust.then_some(order) })
            }
            Filter::Spline { axis, cutoff } => Self::Spline(Spline { axis, cutoff }),
        })
    }
}

impl From<super::super::Filter> for Filter {
    fn from(filter: super::super::Filter) -> Self {
        match filter {
            super::super::Filter::Hampel(Hampel { window, threshold, action, axis }) => {
                Filter::Hampel { window, threshold, action, axis }
            }
            super::super::Filter::Gaussian(Gaussian { axis, cutoff, robust }) => {
                let order = robust.map(|order| if order == Order::Zero { 0 } else { 2 });
                Filter::Gaussian { axis, cutoff, robust: robust.is_some(), order }
            }
            super::super::Filter::Spline(Spline { axis, cutoff }) => Filter::Spline { axis, cutoff },
        }
    }
}
