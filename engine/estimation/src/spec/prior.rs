//! Prior of the coefficients.

use std::sync::Arc;

#[cfg(feature = "contract")]
use flankfit_numerics::contract::{list, name, number, whole};

#[cfg(feature = "contract")]
use super::form;
use crate::data::Nodes;

/// Prior knowledge of the coefficients before the nodes were measured. The estimate is then the
/// mean of the posterior, without other regularisation.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Model, Prior, PriorSpread, Regularization},
/// };
///
/// // A mean of four heights with standard error σ/2, and the same known before as well.
/// let nodes = Nodes::matrix(vec![1.0; 4], 1, vec![2.0, 4.0, 2.0, 4.0], None, None)?;
/// let known = Prior::Given { mean: vec![7.0], spread: PriorSpread::StdError(vec![0.5]) };
/// let spec = FitSpec {
///     regularization: Regularization::None,
///     noise_sigma: Some(1.0),
///     prior: Some(known),
///     ..FitSpec::new(Model::Linear)
/// };
/// let found = fit(&nodes, &spec)?;
/// // They conflict: 3 against 7, with a standard error of 0.7 between them. The prior is let go.
/// let conflict = found.prior.expect("there is one").conflict.expect("it is looked at");
/// assert!(conflict.dropped && conflict.p < 1e-7);
/// assert_eq!(found.coefficients[0].value, 3.0);
///
/// // Half-way between 3 and 4, and better known than either.
/// let known = Prior::Given { mean: vec![4.0], spread: PriorSpread::StdError(vec![0.5]) };
/// let found = fit(&nodes, &FitSpec { prior: Some(known), ..spec })?;
/// assert!((found.coefficients[0].value - 3.5).abs() < 1e-14);
/// assert!((found.coefficients[0].std_error.expect("σ is given") - 0.125f64.sqrt()).abs() < 1e-14);
/// assert!((found.prior.expect("there is one").share[0] - 0.5).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "form::Prior", into = "form::Prior")
)]
pub enum Prior {
    /// Mean and spread, in the caller's terms.
    Given {
        /// One number for each coefficient.
        mean: Vec<f64>,
        /// Spread of the coefficients about the mean.
        spread: PriorSpread,
    },
    /// Earlier iterations of the same flank.
    Iterations(Chain),
}

/// Spread of the coefficients about the mean of a prior.
#[derive(Clone, Debug, PartialEq)]
pub enum PriorSpread {
    /// Standard deviations of independent coefficients.
    StdError(Vec<f64>),
    /// A covariance matrix: its lower triangle by rows, row j having j + 1 numbers.
    Covariance(Vec<Vec<f64>>),
}

/// Earlier measurements of a flank that moved in between.
///
/// ```
/// use std::sync::Arc;
///
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Chain, Earlier, Model, Moves, Prior, Regularization, Which},
/// };
///
/// // A length, measured four times in each of three iterations; nothing moves.
/// let measured = |shift: f64| {
///     let heights = vec![5.0 + shift, 5.3 - shift, 4.9 + shift, 5.2 - shift];
///     Nodes::matrix(vec![1.0; 4], 1, heights, None, None)
/// };
/// let earlier = |number: u32, shift: f64| {
///     Ok::<_, Box<dyn std::error::Error>>(Earlier {
///         number,
///         fit_id: format!("fit {number}"),
///         nodes: Arc::new(measured(shift)?),
///         corrections: vec![],
///     })
/// };
/// let chain = Chain {
///     which: Which::Previous,
///     moves: Moves::StdError(vec![1e-9]),
///     correction: true,
///     earlier: Some(Arc::new([earlier(1, 0.02)?, earlier(2, -0.01)?])),
/// };
/// let spec = FitSpec {
///     regularization: Regularization::None,
///     prior: Some(Prior::Iterations(chain)),
///     ..FitSpec::new(Model::Linear)
/// };
/// let found = fit(&measured(0.05)?, &spec)?;
/// // As if all twelve heights had been fitted together: two thirds of what is known are older.
/// let prior = found.prior.expect("there is one");
/// assert!((found.coefficients[0].value - 5.1).abs() < 1e-12);
/// assert!((prior.share[0] - 2.0 / 3.0).abs() < 1e-6);
/// assert_eq!(prior.iterations, Some(vec![1, 2]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// Requested iterations.
    pub which: Which,
    /// Size of the moves of the flank from one iteration to the next.
    pub moves: Moves,
    /// True if the changes that kept corrections predict are taken to have come.
    pub correction: bool,
    /// The iterations themselves, oldest first; `None` before they are looked up, and then
    /// there is no fit.
    pub earlier: Option<Arc<[Earlier]>>,
}

/// Earlier iterations.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize), serde(untagged))]
pub enum Which {
    /// All of the same flank and tooth.
    #[cfg_attr(feature = "contract", serde(with = "previous"))]
    Previous,
    /// These, by number, ascending.
    Listed(Vec<u32>),
}

impl Which {
    /// Iterations at most.
    pub const MOST: usize = 100;
}

/// Size of the moves of a flank between two iterations, in addition to those that corrections
/// predict.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize), serde(untagged))]
pub enum Moves {
    /// Size estimated from the iterations themselves.
    #[cfg_attr(feature = "contract", serde(with = "estimated"))]
    Estimated,
    /// The standard deviation of the move of each coefficient, in the caller's terms.
    StdError(Vec<f64>),
}

/// An earlier iteration. How it is called is passed through to the report.
#[derive(Clone, Debug, PartialEq)]
pub struct Earlier {
    /// Its number.
    pub number: u32,
    /// The chosen fit of the iteration.
    pub fit_id: String,
    /// Measured nodes.
    pub nodes: Arc<Nodes>,
    /// Corrections between it and the next iteration, in order.
    pub corrections: Vec<Corrected>,
}

/// A correction of the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Corrected {
    /// The iteration that it was kept with.
    pub iteration: u32,
    /// The record that holds it.
    pub record_id: String,
    /// The changes of the settings that were entered in place of the proposed ones.
    pub entered: Option<Vec<f64>>,
    /// The change that they predict, as heights of nodes.
    pub change: Arc<Nodes>,
}

#[cfg(feature = "contract")]
flankfit_numerics::constant!(previous = "previous");
#[cfg(feature = "contract")]
flankfit_numerics::constant!(estimated = "estimated");

#[cfg(feature = "contract")]
flankfit_numerics::alternatives!(
    Which,
    "`previous`, all earlier iterations of the same flank and tooth (the last 100 of them); or their numbers, \
     ascending. Flanks and teeth that are not given count as equal.",
    name("previous"),
    list(whole(1).maximum(Some(u32::MAX)), Some((1, Which::MOST))),
);

#[cfg(feature = "contract")]
flankfit_numerics::alternatives!(
    Moves,
    "`estimated` from the differences between the iterations; or the standard deviation of the move of each \
     coefficient, above 0, in the order and unit of the answer.",
    name("estimated"),
    list(number(), None).min_items(Some(1)),
);
