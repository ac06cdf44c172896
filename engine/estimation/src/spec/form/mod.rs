//! Wire forms of the parts of a specification: unions with `type`, fields that exclude each other,
//! defaults. Each form becomes its part, or an error names the field that prevents it.

mod errors;
mod estimator;
mod filter;
mod folds;
mod model;
mod parameter;
mod predict;
mod prior;
mod regularization;
mod select;

pub(super) use errors::{Errors, Variance};
pub(super) use estimator::Estimator;
pub(super) use filter::Filter;
pub(super) use folds::Folds;
pub(super) use model::Model;
pub(super) use parameter::Parameter;
pub(super) use predict::Predict;
pub(super) use prior::Prior;
pub(super) use regularization::Regularization;
pub(super) use select::Select;

use flankfit_numerics::{
    check::Fault,
    contract::{list, number},
    written_as,
};

written_as!(super::ErrorModel, Errors);
written_as!(super::Estimator, Estimator);
written_as!(super::Filter, Filter);
written_as!(super::Folds, Folds);
written_as!(super::Model, Model);
written_as!(super::Parameter, Parameter);
written_as!(super::Predict, Predict);
written_as!(super::Prior, Prior);
written_as!(super::Regularization, Regularization);
written_as!(super::Select, Select);
written_as!(super::Variance, Variance);

/// Returns the fault of a field.
fn fault(path: &str, message: impl ToString) -> Fault {
    Fault { path: path.to_owned(), message: message.to_string() }
}
