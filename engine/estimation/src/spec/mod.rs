//! Specification of a fit: model, scaling, regularisation, estimator, filters. Plain values; a fit
//! checks them against the nodes.

mod constraint;
mod contamination;
mod criterion;
mod errors;
mod estimator;
mod filter;
mod fit_spec;
mod folds;
#[cfg(feature = "contract")]
mod form;
mod l_estimator;
mod likelihood;
mod loss;
mod model;
mod node_at;
mod predict;
mod prior;
pub(crate) mod regularization;
mod representative;
mod scheme;
mod select;
mod shrinkage;
mod sums;
mod tikhonov;

pub use constraint::{Constraint, ConstraintKind};
pub use contamination::{Contamination, minimax_k};
pub use criterion::{ChosenBy, Criterion, Parameter};
#[cfg(feature = "contract")]
pub use errors::ErrorModel;
pub use errors::{Along, Correlation, Errors, Matern, Variance};
pub use estimator::{DEFAULT_COVERAGE, DEFAULT_K2, Estimator, MEstimator, ScaleRule, Start};
pub use filter::{Action, Filter, FilterAxis, Gaussian, Hampel, Order, Spline};
pub use fit_spec::{DEFAULT_LEVEL, ExpectedSize, FitSpec, Include, NodeUncertainty, PositionKind};
pub use folds::{Folds, FoldsBy};
pub use l_estimator::{DEFAULT_SHARE, LEstimator, QuantileWeights};
pub use likelihood::Distribution;
pub use loss::Loss;
pub use model::{Degree, Domain, Knots, Model, PolynomialBasis, Scaling, Spans, Terms};
pub use node_at::NodeAt;
pub use predict::{Kinds, Places, Predict};
pub use prior::{Chain, Corrected, Earlier, Moves, Prior, PriorSpread, Which};
pub use regularization::{Count, DEFAULT_CONDITION_LIMIT, Regularization};
pub use representative::{Piece, PieceOf, Representative};
pub use scheme::Scheme;
pub use select::{Candidates, ModelCriterion, Select, TermSearch};
pub use shrinkage::{Attraction, JamesStein, ShrinkageFactor};
pub use sums::WeightedSums;
pub use tikhonov::{HIGHEST_ORDER, Tikhonov};
