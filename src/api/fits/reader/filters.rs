//! The filters of a request: wire parts to checked values, with the contract's defaults and ranges.

use crate::api::{
    faults::Faults,
    fits::spec::filters::{
        DEFAULT_THRESHOLD, DEFAULT_WINDOW, FilterAxisName, GaussianFilter, HampelFilter, MOST_FILTERS, PeakAction,
        SplineFilter,
    },
    json::{
        slice::Slice,
        tags::{read_tag, unknown_type},
        value::read_value,
    },
};
use flankfit_engine::{
    estimation::spec::{Action, Filter, FilterAxis, Gaussian, Hampel, Order, Spline},
    words::Shown,
};

/// The filters that there are.
const FILTERS: &str = "hampel, gaussian and spline are";

/// The filters, when none of them has a fault.
pub fn read(slice: &[u8], faults: &mut Faults) -> Option<Vec<Filter>> {
    let parts: Vec<Slice> = read_value(slice, "/filters", faults)?;
    if parts.len() > MOST_FILTERS {
        faults.push("/filters", format!("{} filters; at most {MOST_FILTERS}", parts.len()));
        return None;
    }
    let read: Vec<Option<Filter>> =
        parts.iter().enumerate().map(|(k, part)| read_one(part.0, &format!("/filters/{k}"), faults)).collect();
    read.into_iter().collect()
}

fn read_one(slice: &[u8], at: &str, faults: &mut Faults) -> Option<Filter> {
    let axis = |name: Option<FilterAxisName>| name.map(FilterAxis::from);
    match read_tag(slice, at, FILTERS, faults)?.as_str() {
        "hampel" => {
            let body: HampelFilter = read_value(slice, at, faults)?;
            let window = body.window.unwrap_or(DEFAULT_WINDOW);
            if window < 3 || window.is_multiple_of(2) {
                faults.push(format!("{at}/window"), format!("{window} is not an odd number from 3 on"));
            }
            let threshold = body.threshold.unwrap_or(DEFAULT_THRESHOLD);
            if threshold < 0.0 {
                faults.push(format!("{at}/threshold"), format!("{} is negative", Shown(threshold)));
            }
            let action = match body.action {
                None | Some(PeakAction::Replace) => Action::Replace,
                Some(PeakAction::Remove) => Action::Remove,
            };
            Some(Filter::Hampel(Hampel { window, threshold: threshold + 0.0, action, axis: axis(body.axis) }))
        }
        "gaussian" => {
            let body: GaussianFilter = read_value(slice, at, faults)?;
            positive(body.cutoff, at, faults);
            let order = match body.order {
                None | Some(2) => Order::Two,
                Some(0) => Order::Zero,
                Some(other) => {
                    faults.push(format!("{at}/order"), format!("{other} is not offered; 0 and 2 are"));
                    return None;
                }
            };
            let robust = body.robust.unwrap_or(false);
            if body.order.is_some() && !robust {
                faults.push(format!("{at}/order"), "only the robust filter has an order; ask for `\"robust\": true`");
            }
            let robust = robust.then_some(order);
            Some(Filter::Gaussian(Gaussian { axis: axis(body.axis), cutoff: body.cutoff, robust }))
        }
        "spline" => {
            let body: SplineFilter = read_value(slice, at, faults)?;
            positive(body.cutoff, at, faults);
            Some(Filter::Spline(Spline { axis: axis(body.axis), cutoff: body.cutoff }))
        }
        other => {
            unknown_type(at, other, FILTERS, faults);
            None
        }
    }
}

fn positive(cutoff: f64, at: &str, faults: &mut Faults) {
    if cutoff <= 0.0 {
        faults.push(format!("{at}/cutoff"), format!("{} is not greater than 0", Shown(cutoff)));
    }
}
