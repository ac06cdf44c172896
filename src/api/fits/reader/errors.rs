//! Models of the errors of a request: wire form to checked values. What suits the nodes is the
//! engine's to say.

use crate::api::{
    faults::Faults,
    fits::spec::{errors::*, zeros::unsigned_zero},
    json::{
        tags::{read_tag, unknown_type},
        value::read_value,
    },
};
use flankfit_engine::{
    estimation::spec::{Along, Correlation, Errors, Matern, Variance},
    words::Shown,
};

const AT: &str = "/errors";
/// What there is.
const KINDS: &str = "independent, ar1, ar2 and matern are";

/// Correlated errors; `None` for independent ones, and where there is a fault.
pub fn read(slice: &[u8], faults: &mut Faults) -> Option<Errors> {
    match read_tag(slice, AT, KINDS, faults)?.as_str() {
        "independent" => {
            let _checked: IndependentErrors = read_value(slice, AT, faults)?;
            None
        }
        "ar1" => {
            let Ar1Errors { along, line, estimate, parameters, .. } = read_value(slice, AT, faults)?;
            let rho = parameters.map(|told| unsigned_zero(told.rho));
            told(estimate, rho.is_some(), faults)?;
            Some(errors(Correlation::Ar1 { rho }, along, line))
        }
        "ar2" => {
            let Ar2Errors { along, line, estimate, parameters, .. } = read_value(slice, AT, faults)?;
            let phi = parameters.map(|told| told.phi.map(unsigned_zero));
            told(estimate, phi.is_some(), faults)?;
            Some(errors(Correlation::Ar2 { phi }, along, line))
        }
        "matern" => {
            let MaternErrors { along, line, estimate, parameters, .. } = read_value(slice, AT, faults)?;
            let parameters = parameters
                .map(|told| Matern { length: told.length, nugget: unsigned_zero(told.nugget.unwrap_or(0.0)) });
            told(estimate, parameters.is_some(), faults)?;
            Some(errors(Correlation::Matern { parameters }, along, line))
        }
        other => {
            unknown_type(AT, other, KINDS, faults);
            None
        }
    }
}

fn errors(correlation: Correlation, along: Option<AlongName>, lines: Option<Vec<i64>>) -> Errors {
    Errors { correlation, along: along.map_or(Along::Order, Along::from), lines }
}

/// Parameters are either told or estimated.
fn told(estimate: Option<bool>, given: bool, faults: &mut Faults) -> Option<()> {
    match (estimate, given) {
        (Some(true), true) => faults.push(
            format!("{AT}/estimate"),
            "`parameters` are given: leave out either \
            `estimate` or `parameters`",
        ),
        (Some(false), false) => faults.push(
            format!("{AT}/parameters"),
            "missing: with `estimate` false the parameters \
            are required",
        ),
        _ => return Some(()),
    }
    None
}

/// Variances.
pub fn variance(slice: &[u8], faults: &mut Faults) -> Option<Variance> {
    const AT: &str = "/variance";
    if slice.first() == Some(&b'"') {
        let name: VarianceName = read_value(slice, AT, faults)?;
        return Some(match name {
            VarianceName::Constant => Variance::Constant,
            VarianceName::Hc3 => Variance::Hc3,
        });
    }
    if slice.first() != Some(&b'{') {
        faults.push(AT, "give `constant`, `hc3`, or an object with either `groups` or `power_of`");
        return None;
    }
    match read_value(slice, AT, faults)? {
        EstimatedVariance { groups: Some(groups), power_of: None, exponent: None } => Some(Variance::Groups(groups)),
        EstimatedVariance { groups: None, power_of: Some(name), exponent } => {
            if let Some(power) = exponent.filter(|power| power.abs() > 6.0) {
                faults.push(format!("{AT}/exponent"), format!("{} is not between -6 and 6", Shown(power)));
                return None;
            }
            let of = if name == CoordinateName::V { Along::V } else { Along::U };
            Some(Variance::Power { of, exponent: exponent.map(unsigned_zero) })
        }
        _ => {
            faults.push(AT, "give `constant`, `hc3`, or an object with either `groups` or `power_of`");
            None
        }
    }
}
