//! Warnings about an answer: data, a stable code and a sentence.

use super::{
    outliers::Outliers,
    positions::HOLDING,
    prior::{PriorConflict, UnequalNoise},
    warning_parts::{Contradiction, ExactWithout, NeedsSigma, Probability, Regularized, ShapeBound, Times},
};
use crate::spec::Along;
use flankfit_numerics::words::{Shown, Size, counted, listed, rounded};

/// Something that the reader of an answer must know.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// Degrees of freedom are 0: as many coefficients as nodes.
    #[error("as many coefficients as nodes: there is no estimate of the noise, so no standard errors")]
    NoDegreesOfFreedom,
    /// Columns that depend on each other.
    #[error(
        "the columns of {} depend on each other over these nodes (rank {rank} of {columns}): the least-squares \
         figures are those of the minimum-norm solution in the scaled columns", .terms.join(", ")
    )]
    RankDeficient {
        /// Their terms.
        terms: Vec<String>,
        /// Numerically nonzero singular values.
        rank: usize,
        /// Columns of X.
        columns: usize,
    },
    /// Columns whose variance inflation factor is infinite.
    #[error("no variance inflation factor for {}: the column depends on others exactly", .0.join(", "))]
    InfiniteInflation(Vec<String>),
    /// Figures that are left out.
    #[error("left out because they leave the range of double precision: {}", .0.join(", "))]
    BeyondDouble(Vec<&'static str>),
    /// Few digits of the posted numbers arrive in the coefficients.
    #[error("the posted numbers, rounded to doubles, determine the worst coefficient to about {0:.0} digits only")]
    FewDigits(f64),
    /// Perturbation bounds of an estimate that is made by no matrix X + B.
    #[error(
        "perturbation bounds are those of one matrix X + B; this estimate is not made by one, so only least squares \
         has them"
    )]
    NoRegularizedPerturbation,
    /// Relative errors of coefficients that are all 0.
    #[error("the coefficients are all 0: bounds on their relative error divide by their length, so there are none")]
    NoRelativeError,
    /// A node uncertainty above the square bound.
    #[error("the node uncertainty times the condition reaches 1: the square bound does not exist there")]
    PerturbationUnbounded,
    /// A limit below the norm of the estimate.
    #[error(
        "the limit {} of the norm is below ‖Â‖ = {} of this fit: if the true norm is above the limit too, bias-aware \
         intervals and bands do not hold and the bounds of the bias may be exceeded", Shown(*.limit), Shown(*.norm)
    )]
    NormLimitBelowEstimate {
        /// r of the request.
        limit: f64,
        /// ‖Â‖.
        norm: f64,
    },
    /// r is the norm of an estimate that is not distinguishable from 0 where it matters most.
    #[error(
        "r = ‖Â‖ = {norm:.3e} is an estimate, and along the direction that the nodes determine worst it is not \
         distinguishable from 0 ({along:.2e} with a standard error of {}): the bounds of the bias hold for that r \
         only; give the limit of the norm", Size(*.error)
    )]
    NormLimitIsEstimate {
        /// ‖Â‖.
        norm: f64,
        /// V₁ᵀÂ.
        along: f64,
        /// Its standard error.
        error: f64,
    },
    /// A curve over λ* of a fit without regularisation.
    #[error("there is no λ* without regularisation")]
    NoLambda,
    /// A curve over λ* of a regularisation without it.
    #[error("{0} has no λ* to run along")]
    NoLambdaOf(Regularized),
    /// A matrix B of another regularisation.
    #[error("only spectral regularisation has a matrix B")]
    MatrixBIsSpectral,
    /// A matrix B of standardised columns.
    #[error("of standardised columns there is no B to be added to the posted ones")]
    MatrixBOfStandardized,
    /// A matrix B without nodes.
    #[error("the rows of B need the nodes themselves")]
    MatrixBNeedsNodes,
    /// A ridge trace of another regularisation.
    #[error("only ridge has a ridge trace")]
    NoRidgeTrace,
    /// An estimate that is the target.
    #[error(
        "nothing of the distance to the target stands out of the noise: the target itself is answered, and the \
         weight, which would be infinite, is left out"
    )]
    AttractedEntirely,
    /// A target's entry of a constant that is not penalised.
    #[error("standardised columns leave the constant unpenalised: its entry of the target takes no part")]
    TargetOfConstantUnused,
    /// A discrepancy that is not reached.
    #[error("the residuals stay below the noise for every {0}: the largest one is answered")]
    DiscrepancyNotReached(&'static str),
    /// A criterion that has no minimum within the range that is searched.
    #[error(
        "what is asked for is not met within the range that is searched for {0}, or the criterion still falls at its \
         end: that end is answered"
    )]
    LambdaAtLimit(&'static str),
    /// A criterion without σ.
    #[error("{0} needs σ: there are as many coefficients as nodes, so give its value; least squares is answered")]
    SigmaMissing(NeedsSigma),
    /// A choice that is predicted to be worse than none.
    #[error(
        "this choice is predicted to have {} the mean squared coefficient error of plain least squares: the surface \
         has a real component along the regularised directions; see the choices of the regularisation", Times(*.0)
    )]
    WorseThanLeastSquares(f64),
    /// M-estimation that did not converge.
    #[error(
        "{iterations} iterations left a change of {reached:.1e} scales: the estimate is the last one; allow more \
         iterations or another tolerance"
    )]
    WeightsNotConverged {
        /// Iterations.
        iterations: usize,
        /// The last change, in scales.
        reached: f64,
    },
    /// Newton's method that did not converge.
    #[error("{iterations} steps of Newton's method left a change of {reached:.1e} of the largest residual")]
    NewtonNotConverged {
        /// Steps.
        iterations: usize,
        /// The last change, relative to the largest residual.
        reached: f64,
    },
    /// A simplex of absolute deviations that was stopped.
    #[error("the walk over vertices was stopped after {0} steps; see the certificate")]
    SimplexStopped(usize),
    /// A simplex of the rank dispersion that was stopped.
    #[error("the walk over vertices was stopped; the certificate says how far the dispersion is from its least")]
    DispersionStopped,
    /// Absolute deviations with several solutions.
    #[error("other coefficients have the same least sum: one vertex of them is answered")]
    SumNotUnique,
    /// A rank dispersion with several solutions.
    #[error("other coefficients have the same least dispersion: one vertex of them is answered")]
    DispersionNotUnique,
    /// Nodes that a robust estimate passes through.
    #[error(
        "{on} of {nodes} nodes lie on one surface to rounding: the scale is 0, the others weigh nothing beside them, \
         and there are no standard errors"
    )]
    ExactFit {
        /// Nodes on the surface.
        on: usize,
        /// All nodes.
        nodes: usize,
    },
    /// Too few residuals for a scale.
    #[error(
        "too few nodes lie off the surface to tell the scale of the residuals: it is left out, and so are standard \
         errors"
    )]
    NoScale,
    /// A low-pass filter before a fit.
    #[error(
        "a low-pass filter leaves neighbouring heights with common noise: σ, standard errors and the choice of λ* are \
         those of the filtered heights and take their noise for independent"
    )]
    FilteredNoise,
    /// A robust filter that did not converge.
    #[error(
        "filter {filter}: the robust filter still moved after {rounds} rounds on {lines} line(s); its last round \
         stands"
    )]
    FilterNotConverged {
        /// Index of the filter, from 0.
        filter: usize,
        /// Rounds.
        rounds: usize,
        /// Lines on which it moved.
        lines: usize,
    },
    /// Filtered columns that depend on each other.
    #[error(
        "the filters leave columns that double precision cannot tell apart: condition, correlation and variance \
         inflation after filtering are left out"
    )]
    FilteredColumnsDependent,
    /// Columns that were not filtered.
    #[error(
        "the columns were not filtered too, because that is too much work for so many nodes: condition, correlation \
         and variance inflation after filtering are left out"
    )]
    FilteredColumnsNotExamined,
    /// A condition that filtering raises.
    #[error(
        "filtering raises the condition of the columns from {before:.3e} to {after:.3e}: what tells the terms apart \
         is partly smoothed away"
    )]
    FilteringRaisesCollinearity {
        /// Condition of the columns.
        before: f64,
        /// Condition of the filtered columns.
        after: f64,
    },
    /// The estimate of a stream.
    #[error(
        "an estimate of a stream keeps sums only: the largest residual, single residuals, influences and the rows of B \
         are given when the stream is finished"
    )]
    NodesNotKept,
    /// A stream that forgets.
    #[error(
        "with a forgetting factor of {} the weights of all {nodes} nodes add up to {weight:.6}; weights are relative \
         1/σ², so sigma is that of the newest node, older ones counting as noisier", Shown(*.factor)
    )]
    Forgetting {
        /// φ.
        factor: f64,
        /// Nodes so far.
        nodes: usize,
        /// Their weights together.
        weight: f64,
    },
    /// The condition of a big surface that is not known.
    #[error("the extreme eigenvalues did not settle within the limit of the iteration")]
    ConditionUnknown,
    /// Cells without nodes.
    #[error("{empty} of {cells} cells hold no node: the surface there follows its neighbours")]
    EmptySpans {
        /// Number of empty cells.
        empty: usize,
        /// All.
        cells: usize,
    },
    /// Standard errors that are too much work.
    #[error("standard errors of {0} penalised coefficients ask for as many solutions: too many")]
    NoStandardErrors(usize),
    /// A study of dependent columns.
    #[error(
        "the columns depend on each other (rank {rank} of {columns}): the spectral schemes divide by λ₁ = 0 and are \
         left out, least squares is the minimum-norm solution"
    )]
    NoSpectralSchemes {
        /// Numerically nonzero singular values.
        rank: usize,
        /// Columns of X.
        columns: usize,
    },
    /// Levels of a study with dependent columns.
    #[error(
        "the columns depend on each other at the level(s) {}: figures that do not exist there are left out",
        listed(.0.iter().map(|level| Shown(*level)))
    )]
    DependentLevels(Vec<f64>),
    /// A study without noise.
    #[error("without noise least squares is exact, and randomising cannot improve it: there is no optimum")]
    NoNoise,
    /// Predictions and covariances of coefficients that the nodes leave free.
    #[error("the nodes do not determine every coefficient, so that heights elsewhere and covariances have no limit")]
    NoPredictions,
    /// Influences of nodes over columns that depend on each other.
    #[error("the columns depend on each other: influences of single nodes need independent ones, and are left out")]
    NoInfluence,
    /// Influences of an estimator that is no linear map of the heights.
    #[error(
        "influences are those of least squares, plain or regularised: a robust estimate is no linear map of the \
         heights, and its weights say which nodes it does not trust"
    )]
    NoInfluenceOfRobust,
    /// Positions that are off, and taken as exact.
    #[error(
        "the positions of the nodes are taken as exact, as this kind of fit or its size has no way to count them: \
         intervals count the errors of the heights alone, and only the perturbation bounds know of the positions"
    )]
    PositionsAsExact,
    /// Positions that are measured so badly that what follows from small errors does not hold.
    #[error(
        "positions are so uncertain that intervals may hold less often than they say: {:.0} % of what the nodes tell \
         of some sum of the coefficients is scatter of the positions (up to {:.0} % intervals hold), the bend of the \
         fit within that scatter shifts coefficients by {bend:.1} standard errors (up to {:.1}), and weights are \
         uncertain by {:.0} % (up to {:.0} %): measure positions better, or fit a lower degree",
        100.0 * .share.min(1.0), 100.0 * HOLDING[0], HOLDING[1], 100.0 * .weights, 100.0 * HOLDING[2]
    )]
    PositionsUncertain {
        /// The share of the information along the direction that has most of it.
        share: f64,
        /// In standard errors.
        bend: f64,
        /// Relative standard error.
        weights: f64,
    },
    /// Uncertainties of positions and heights that the residuals do not bear out.
    #[error("{0}")]
    UncertaintyContradicted(Contradiction),
    /// A limit of the norm that has no part in the intervals.
    #[error(
        "the limit of the norm shortens intervals of least squares with independent errors only: those of this fit do \
         not use it, bounds on the bias do"
    )]
    NormLimitUnused,
    /// A variance that was estimated from next to nothing.
    #[error(
        "the variance of group {group} rests on {} degrees of freedom: join groups, or expect intervals that are \
         several times as wide as with known variances", rounded(*.freedom, 2)
    )]
    GroupVarianceUncertain {
        /// The group.
        group: i64,
        /// Degrees of freedom in effect.
        freedom: f64,
    },
    /// Power that too few residuals determine.
    #[error(
        "{freedom} degrees of freedom do not fix a power of the standard deviation: intervals and bands hold less \
         often than they say; give the power, or measure at {more} nodes more"
    )]
    PowerUncertain {
        /// Nodes less coefficients.
        freedom: usize,
        /// Nodes that are missing.
        more: usize,
    },
    /// A correlation at an end of what is searched.
    #[error(
        "the likeliest correlation of neighbours is {}, an end of what is searched: it is no estimate, and intervals \
         may hold less often than they say; tell the correlation, or look for what the model lacks", rounded(*.0, 3)
    )]
    CorrelationAtBound(f64),
    /// A predicted error that nothing corrects.
    #[error(
        "there is no corrected predicted error here: it is that of a matrix B, ridge or Tikhonov (up to 200 \
         coefficients) whose parameter is given or chosen by sums over the spectrum, with an estimate of the noise"
    )]
    NothingToCorrect,
    /// Influences of too many nodes.
    #[error(
        "influences of {nodes} nodes are left out: a fit with so many coefficients has them for up to {most} nodes"
    )]
    InfluenceOfMany {
        /// Counted nodes.
        nodes: usize,
        /// Nodes at most.
        most: usize,
    },
    /// Places whose results exceed the range of double.
    #[error(
        "{} left out of the predictions (number {}{}, from 0): figures there leave the range of double precision",
        counted(*.count, "place is", "places are"),
        .places.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
        if .places.len() < *.count { ", …" } else { "" }
    )]
    PlacesBeyondDouble {
        /// The places in the requested order, ten at most.
        places: Vec<usize>,
        /// Their number.
        count: usize,
    },
    /// A prior that there is no noise to weigh against.
    #[error(
        "the heights lie on the model without any noise, against which the prior would be weighed: it was left aside, \
         and least squares of these nodes is answered; give the noise, σ"
    )]
    PriorWithoutNoise,
    /// The estimated shape of a distribution at an end of its range.
    #[error("the likeliest {0}: it is no estimate, and the errors are probably of another distribution")]
    ShapeAtBound(ShapeBound),
    /// Influences of nodes whose errors are not white.
    #[error(
        "leverages and residuals without a node are those of independent errors of one variance: with this model of \
         the errors influences are left out"
    )]
    NoInfluenceOfErrors,
    /// A correction by simulation of errors that are not simulated.
    #[error(
        "the predicted error is corrected by simulating independent errors of one variance: with this model of the \
         errors the correction is left out"
    )]
    NoCorrectedError,
    /// The interval of a further height of unknown variance.
    #[error(
        "variances differ from node to node, and nothing says which a further height would have: intervals of \
         further heights are left out"
    )]
    NoPredictionIntervals,
    /// The interval of a further height about a quantile.
    #[error(
        "a quantile says how many heights lie below it, not how they spread: intervals of further heights are left \
         out; fit the quantiles that are to hold them"
    )]
    NoPredictionOfQuantile,
    /// Nodes without which the others do not determine the fit.
    #[error(
        "{} of leverage 1 (node {}{}): the fit passes through whatever is measured there, and without it the others \
         do not determine the coefficients, so its deletion figures do not exist",
        counted(*.count, "node is", "nodes are"), .nodes.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
        if .nodes.len() < *.count { ", …" } else { "" }
    )]
    FullLeverage {
        /// The posted nodes, ten at most.
        nodes: Vec<usize>,
        /// Their number.
        count: usize,
    },
    /// Nodes without which nothing is left of the noise.
    #[error("{0}")]
    NoNoiseWithout(ExactWithout),
    /// A shape of a measurement matrix.
    #[error("the columns of a measurement matrix are no curve or surface: there is no shape")]
    NoShapeOfMatrix,
    /// A shape of a higher degree than shapes have.
    #[error("curves and surfaces have degrees up to {most}: there is no shape of degree {degree}")]
    NoShapeOfDegree {
        /// The highest degree of the fit.
        degree: usize,
        /// The highest of shapes.
        most: usize,
    },
    /// A shape over a domain without width, or with numbers above the range of double.
    #[error("the domain is a single place, or control points leave the range of double: there is no shape")]
    NoShapeOfPoint,
    /// Places outside the domain.
    #[error(
        "{} outside the domain: nothing was measured there, and the bands hold only if the model does",
        counted(*.0, "place lies", "places lie")
    )]
    OutsideDomain(usize),
    /// Residuals that are correlated with their neighbours.
    #[error(
        "the residuals are correlated along {}: {correlation:.2} between neighbours, which independent errors have \
         with a probability of {}. Either the model lacks something that the nodes show, or the errors are correlated, \
         and standard errors that take them for independent are too small by a factor of about {factor:.1}",
        .along.name(), Probability(*.p)
    )]
    CorrelatedResiduals {
        /// Direction of the scan lines.
        along: Along,
        /// `Σ rᵢrᵢ₊₁ / Σ r²` over neighbours.
        correlation: f64,
        /// The probability that residuals of independent errors are so correlated.
        p: f64,
        /// Factor by which the standard errors are too small.
        factor: f64,
    },
    /// Nodes that are suspected of gross errors.
    #[error("{0}")]
    OutliersSuspected(Outliers),
    /// Nodes that contradict the prior.
    #[error(
        "the nodes contradict the prior: e'S⁻¹e/n is {}, which has a probability of {} where it holds; it was \
         let go, and least squares of these nodes is answered", Size(.0.statistic), Probability(.0.p)
    )]
    PriorConflict(PriorConflict),
    /// A prior of iterations whose noise is another.
    #[error(
        "σ of these nodes is {}, that of the earlier iterations {} (in heights of weight 1): the prior is weighed as if \
         they were the same; compare the set-ups and the weights", Size(.0.now), Size(.0.earlier)
    )]
    UnequalNoise(UnequalNoise),
    /// A model that was chosen by the nodes it is fitted to.
    #[error(
        "the model was chosen out of {0} by the nodes that it is fitted to: intervals and standard errors take it for \
         given, and hold less often than they say"
    )]
    PostSelection(usize),
    /// A prior of iterations without any.
    #[error("there is no earlier iteration of this flank and tooth: least squares of these nodes is answered")]
    NoEarlierIterations,
    /// A representative piece whose directions are others.
    #[error(
        "the directions of the representative piece lie off those of these nodes (alignment {0:.3}): much of the error \
         along the smallest eigenvalues stays; measure at the places of the piece, or let the nodes make their own B"
    )]
    PieceMisaligned(f64),
    /// A fit that has nothing to give to others.
    #[error("no eigenvalue is raised by a matrix B here: there is nothing of this fit for others to use")]
    NoPieceToGive,
    /// Constraints that hold the function back.
    #[error(
        "constraints hold the function back at {}: standard errors are those with the derivatives there held at 0, \
         intervals are those of least squares, which the estimate may lie outside of",
        counted(*.0, "place", "places")
    )]
    ConstraintsActive(usize),
}
