//! The result of a fit. A value that does not exist is `None`.

mod accuracy;
mod collinearity;
mod constraints;
mod enclosure;
mod errors;
mod estimable;
mod filtering;
mod fit_result;
mod influence;
mod interval;
mod matrix_b;
mod outliers;
mod positions;
mod prediction;
mod prior;
mod regularization;
mod representative;
mod residuals;
mod robust;
mod selection;
mod shape;
mod spectrum;
mod sums;
mod term;
mod warning;
mod words;

pub use crate::spec::regularization::RegularizationKind;
pub use accuracy::{Arithmetic, Numerics, PerturbationBounds, PerturbationReport};
pub use collinearity::{Cause, CollinearityReport, ColumnCollinearity, NearDependency, OrthonormalBasis};
pub use constraints::{ActivePlace, ConstraintReport, ConstraintsReport};
pub use enclosure::{Enclosure, NotEnclosed};
pub use errors::{CorrelationKind, ErrorParameters, ErrorsReport, GroupSigma, VarianceReport, Whiteness};
pub use estimable::EstimableSum;
pub use filtering::{ColumnResults, FilterCollinearity, FilterKind, FilterReport, IterationReport};
pub use fit_result::FitResult;
pub use influence::Influence;
pub use interval::{Interval, IntervalKind};
pub use matrix_b::{MatrixBFactors, ProductOfB};
pub use outliers::{MovedCoefficient, Outliers, SuspectedNode};
pub(crate) use positions::HOLDING;
pub use positions::PositionsReport;
pub use prediction::{Covariance, Predictions, Simultaneous, Slopes};
pub use prior::{PriorConflict, PriorReport, UsedCorrection};
pub use regularization::{
    BiasReport, Choice, LambdaCurvePoint, NormLimitSource, RegularizationReport, RidgeTracePoint,
};
pub use representative::RepresentativeReport;
pub use residuals::ResidualReport;
pub use robust::{LikelihoodReport, LocalSolution, MinimaxReport, RobustReport};
pub use selection::{Candidate, Selection};
pub use shape::Shape;
pub use spectrum::{RegularizedSpectrum, SpectrumReport};
pub use sums::WeightedSum;
pub use term::{Coefficient, TermKey};
pub use warning::Warning;
