//! Warnings about an answer.

use super::{
    checks::ResidualWarning,
    enclosure::NotEnclosed,
    outliers::Outliers,
    positions::HOLDING,
    words::{Probability, Times},
};
use flankfit_numerics::{
    warnings,
    words::{Shown, Size, counted, listed, rounded},
};

warnings! {
/// Something that the reader of an answer must know.
pub enum Warning {
    /// Degrees of freedom are 0: as many coefficients as nodes.
    #[error("there are as many coefficients as nodes: the noise cannot be estimated, so there are no standard errors")]
    "no_degrees_of_freedom" => NoDegreesOfFreedom,
    /// Columns that depend on each other.
    #[error(
        "the columns of {} are linearly dependent at these nodes (rank {rank} of {columns}): least-squares results \
         are those of the minimum-norm solution in the scaled columns", .terms.join(", ")
    )]
    "rank_deficient" => RankDeficient { terms: Vec<String>, rank: usize, columns: usize },
    /// Columns whose variance inflation factor is infinite.
    #[error("no variance inflation factor for {}: the column is an exact combination of others", .terms.join(", "))]
    "vif_infinite" => InfiniteInflation { terms: Vec<String> },
    /// Figures that are left out.
    #[error("omitted, because they exceed the range of double precision: {}", .figures.join(", "))]
    "exceeds_double" => ExceedsDouble { figures: Vec<&'static str> },
    /// Few digits of the posted numbers arrive in the coefficients.
    #[error("the posted numbers, rounded to doubles, determine the worst coefficient to about {digits:.0} digits only")]
    "few_digits" => FewDigits { digits: f64 },
    /// Perturbation bounds of an estimate that is made by no matrix X + B.
    #[error(
        "perturbation bounds need a matrix X + B, which this estimate does not have: they are given for least squares \
         only"
    )]
    "no_regularized_perturbation" => NoRegularizedPerturbation,
    /// Relative errors of coefficients that are all 0.
    #[error("the coefficients are all 0: there are no bounds on their relative error")]
    "no_relative_error" => NoRelativeError,
    /// A node uncertainty above the square bound.
    #[error("the node uncertainty times the condition number is 1 or more: there is no square bound")]
    "perturbation_unbounded" => PerturbationUnbounded,
    /// A limit r of the norm that the nodes contradict.
    #[error(
        "the nodes contradict coefficient_norm_limit {}: ‖Â‖ is {}, and coefficients within the limit have heights so \
         far from the fit with a probability of at most {}; bias-aware intervals and bands do not hold, and \
         bias_bound and sharp_bound may be exceeded",
        Shown(*.limit), rounded(*.norm, 6), Probability(*.p)
    )]
    "norm_limit_contradicted" => NormLimitContradicted {
        limit: f64,
        /// ‖Â‖.
        norm: f64,
        /// Greatest probability of such heights if the limit is true.
        p: f64,
    },
    /// r is the norm of an estimate that is not distinguishable from 0 where it matters most.
    #[error(
        "r = ‖Â‖ = {norm:.3e} is an estimate, and along the direction that the nodes determine worst it is not \
         distinguishable from 0 ({along_worst:.2e} with a standard error of {}): bias_bound and sharp_bound hold for \
         that r only; give coefficient_norm_limit", Size(*.std_error)
    )]
    "norm_limit_is_estimate" => NormLimitIsEstimate {
        /// ‖Â‖.
        norm: f64,
        /// V₁ᵀÂ.
        along_worst: f64,
        /// Its standard error.
        std_error: f64,
    },
    /// A curve over λ* of a fit without regularisation.
    #[error("there is no λ* without regularisation")]
    "no_lambda_curve" => NoLambda,
    /// A curve over λ* of a regularisation without it.
    #[error("a fit by `{regularization}` has no λ*, and so no curve over λ*")]
    "no_lambda_curve" => NoLambdaOf { regularization: &'static str },
    /// A matrix B of another regularisation.
    #[error("only spectral regularisation has a matrix B")]
    "no_matrix_b" => MatrixBIsSpectral,
    /// A matrix B of standardised columns.
    #[error("with standardised columns there is no matrix B for the posted columns")]
    "no_matrix_b" => MatrixBOfStandardized,
    /// A matrix B without nodes.
    #[error("the rows of B need the nodes themselves")]
    "no_matrix_b" => MatrixBNeedsNodes,
    /// A ridge trace of another regularisation.
    #[error("only ridge has a ridge trace")]
    "no_ridge_trace" => NoRidgeTrace,
    /// An estimate that is the target.
    #[error(
        "the distance to the target is within the noise: the target itself is returned, and the weight, which would \
         be infinite, is omitted"
    )]
    "attracted_entirely" => AttractedEntirely,
    /// A target's entry of a constant that is not penalised.
    #[error("standardised columns leave the constant unpenalised: its entry of the target is ignored")]
    "target_of_constant_unused" => TargetOfConstantUnused,
    /// A discrepancy that is not reached.
    #[error("the residuals stay below the noise for every {parameter}: the largest one is returned")]
    "discrepancy_not_reached" => DiscrepancyNotReached { parameter: &'static str },
    /// A criterion that has no minimum within the range that is searched.
    #[error(
        "the criterion has no minimum within the searched range of {parameter}: the end of the range is returned"
    )]
    "lambda_at_limit" => LambdaAtLimit { parameter: &'static str },
    /// A criterion without σ.
    #[error(
        "`{criterion}` needs σ, which cannot be estimated from as many nodes as coefficients: give `noise_sigma`; \
            least squares is returned"
    )]
    "criterion_unavailable" => SigmaMissing { criterion: &'static str },
    /// A choice that is predicted to be worse than none.
    #[error(
        "this choice is predicted to have {} the mean squared coefficient error of plain least squares: the surface \
         has a real component along the regularised directions; see `regularization.choices`", Times(*.factor)
    )]
    "worse_than_least_squares" => WorseThanLeastSquares { factor: f64 },
    /// M-estimation that did not converge.
    #[error(
        "after {iterations} iterations the last change was {change_scales:.1e} scales: the last estimate is returned; \
         allow more iterations or a larger tolerance"
    )]
    "not_converged" => WeightsNotConverged {
        iterations: usize,
        /// The last change, in scales.
        change_scales: f64,
    },
    /// Newton's method that did not converge.
    #[error("after {iterations} steps of Newton's method the last change was {relative_change:.1e} of the largest \
        residual")]
    "not_converged" => NewtonNotConverged {
        iterations: usize,
        /// The last change, relative to the largest residual.
        relative_change: f64,
    },
    /// A simplex of absolute deviations that was stopped.
    #[error("the simplex method was stopped after {steps} steps; see the certificate")]
    "not_converged" => SimplexStopped { steps: usize },
    /// A simplex of the rank dispersion that was stopped.
    #[error("the simplex method was stopped; the certificate shows the distance of the dispersion from its minimum")]
    "not_converged" => DispersionStopped,
    /// Absolute deviations with several solutions.
    #[error("other coefficients have the same least sum: one vertex is returned")]
    "not_unique" => SumNotUnique,
    /// A rank dispersion with several solutions.
    #[error("other coefficients have the same least dispersion: one vertex is returned")]
    "not_unique" => DispersionNotUnique,
    /// Nodes that a robust estimate passes through.
    #[error(
        "{on_surface} of {nodes} nodes lie on one surface to rounding: the scale is 0, the others have no weight, and \
         there are no standard errors"
    )]
    "exact_fit" => ExactFit { on_surface: usize, nodes: usize },
    /// Too few residuals for a scale.
    #[error(
        "too few nodes lie off the surface to estimate the scale of the residuals: scale and standard errors are \
         omitted"
    )]
    "no_scale" => NoScale,
    /// A low-pass filter before a fit.
    #[error(
        "a low-pass filter correlates the noise of neighbouring heights: σ, standard errors and the choice of λ* are \
         those of the filtered heights and assume independent noise"
    )]
    "filtered_noise" => FilteredNoise,
    /// A filter of peaks before a fit.
    #[error(
        "the filter of peaks changed {}, some of which may be noise and no peaks: σ and standard errors take the \
         others for all that was measured and are too small; compare a fit without the filter and with `m_estimator`",
        counted(*.changed, "node", "nodes")
    )]
    "filtered_noise" => PeaksChanged { changed: usize },
    /// A robust filter that did not converge.
    #[error(
        "filters/{filter}: the robust filter did not converge within {rounds} rounds on {lines} line(s); the result \
         is that of the last round"
    )]
    "filter_not_converged" => FilterNotConverged {
        /// Index of the filter, from 0.
        filter: usize,
        rounds: usize,
        /// Lines on which it moved.
        lines: usize,
    },
    /// Filtered columns that depend on each other.
    #[error(
        "after filtering, columns cannot be distinguished in double precision: condition, correlation and variance \
         inflation after filtering are omitted"
    )]
    "filtered_columns_dependent" => FilteredColumnsDependent,
    /// Columns that were not filtered.
    #[error(
        "the columns were not filtered, which takes too long for so many nodes: condition, correlation and variance \
         inflation after filtering are omitted"
    )]
    "filtered_columns_not_examined" => FilteredColumnsNotExamined,
    /// A condition that filtering raises.
    #[error(
        "filtering raises the condition of the columns from {condition_before:.3e} to {condition_after:.3e}: the \
         difference between terms is partly smoothed away"
    )]
    "filtering_raises_collinearity" => FilteringRaisesCollinearity { condition_before: f64, condition_after: f64 },
    /// The estimate of a stream.
    #[error(
        "a stream keeps only sums: the largest residual, single residuals, influences and the rows of B are given \
         when the stream is finished"
    )]
    "nodes_not_kept" => NodesNotKept,
    /// A stream that forgets.
    #[error(
        "with a forgetting factor of {} the {nodes} nodes count as {effective_count:.0}; intervals assume that the surface did not \
         move meanwhile, and that so many nodes lie all over it", Shown(*.forgetting_factor)
    )]
    "forgetting" => Forgetting {
        forgetting_factor: f64,
        /// Nodes so far.
        nodes: usize,
        /// Number of nodes of full weight that determine the coefficients as well.
        effective_count: f64,
    },
    /// The condition of a big surface that is not known.
    #[error("the extreme eigenvalues did not converge within the allowed iterations")]
    "condition_unknown" => ConditionUnknown,
    /// Cells without nodes.
    #[error("{empty} of {cells} cells have no node: the surface there follows from its neighbourhood")]
    "empty_spans" => EmptySpans { empty: usize, cells: usize },
    /// Standard errors that are too much work.
    #[error("standard errors of {coefficients} penalised coefficients take too long and are omitted")]
    "no_standard_errors" => NoStandardErrors { coefficients: usize },
    /// A study of dependent columns.
    #[error(
        "the columns are linearly dependent (rank {rank} of {columns}): spectral schemes divide by λ₁ = 0 and are \
         omitted, least squares is the minimum-norm solution"
    )]
    "rank_deficient" => NoSpectralSchemes { rank: usize, columns: usize },
    /// Levels of a study with dependent columns.
    #[error(
        "the columns are linearly dependent at the level(s) {}: results that do not exist there are omitted",
        listed(.levels.iter().map(|level| Shown(*level)))
    )]
    "dependent_columns" => DependentLevels { levels: Vec<f64> },
    /// A study without noise.
    #[error("without noise least squares is exact, and randomising cannot improve it: there is no optimum")]
    "no_noise" => NoNoise,
    /// Predictions and covariances of coefficients that the nodes leave free.
    #[error("the nodes do not determine every coefficient: there are no predictions and covariances")]
    "no_predictions" => NoPredictions,
    /// Influences of nodes over columns that depend on each other.
    #[error("the columns are linearly dependent: influences of single nodes are omitted")]
    "no_influence" => NoInfluence,
    /// Influences of an estimator that is no linear map of the heights.
    #[error(
        "influences are those of least squares, plain or regularised: a robust estimate is not linear in the heights; \
         its weights show which nodes it rejects"
    )]
    "no_influence" => NoInfluenceOfRobust,
    /// Results that were to be enclosed and are not.
    #[error("{reason}")]
    "no_enclosure" => NoEnclosure { reason: NotEnclosed },
    /// Positions that are off, and taken as exact.
    #[error(
        "the positions of the nodes are treated as exact, since this kind or size of fit does not support uncertain \
         positions: intervals include errors of the heights only, and only the perturbation bounds include those of \
         positions"
    )]
    "positions_as_exact" => PositionsAsExact,
    /// Positions that are measured so badly that what follows from small errors does not hold.
    #[error(
        "positions are so uncertain that the coverage of intervals may be below their level: {:.0} % of the \
         information about some sum of the coefficients comes from the scatter of positions (up to {:.0} % is \
         acceptable), the curvature of the fit within that scatter shifts coefficients by {bend_std_errors:.1} \
         standard errors (up to {:.1}), and weights are uncertain by {:.0} % (up to {:.0} %): measure positions \
         better, or fit a lower degree",
        100.0 * .share.min(1.0), 100.0 * HOLDING[0], HOLDING[1], 100.0 * .weight_std_error, 100.0 * HOLDING[2]
    )]
    "positions_uncertain" => PositionsUncertain {
        /// The share of the information along the direction that has most of it.
        share: f64,
        /// In standard errors.
        bend_std_errors: f64,
        /// Relative standard error.
        weight_std_error: f64,
    },
    /// Uncertainties of positions and heights that the residuals contradict.
    #[error(
        "the residuals are {} times as large as expected from the uncertainties of positions and heights, which with \
         {} is not due to chance: check that both are in the units of the nodes, {}",
        Size(*.sigma_ratio), counted(*.degrees_of_freedom, "degree of freedom", "degrees of freedom"),
        if *.sigma_ratio < 1.0 { "give smaller uncertainties" }
        else { "give larger uncertainties, or extend the model" }
    )]
    "uncertainty_contradicted" => UncertaintyContradicted {
        /// σ of the residuals over the given uncertainty of heights.
        sigma_ratio: f64,
        /// Degrees of freedom of σ.
        degrees_of_freedom: usize,
    },
    /// A limit of the norm that has no part in the intervals.
    #[error(
        "coefficient_norm_limit shortens intervals only for least squares with independent errors: here only \
         bias_bound and sharp_bound use it"
    )]
    "norm_limit_unused" => NormLimitUnused,
    /// A variance that was estimated from next to nothing.
    #[error(
        "the variance of group {group} has {} degrees of freedom only: join groups, or expect intervals several times \
         as wide as with known variances", rounded(*.degrees_of_freedom, 2)
    )]
    "group_variance_uncertain" => GroupVarianceUncertain {
        group: i64,
        /// Degrees of freedom in effect.
        degrees_of_freedom: f64,
    },
    /// Power that too few residuals determine.
    #[error(
        "{degrees_of_freedom} degrees of freedom do not determine the power of the standard deviation: the coverage \
         of intervals and bands is below their level; give the power, or measure {more_nodes} more nodes"
    )]
    "power_uncertain" => PowerUncertain { degrees_of_freedom: usize, more_nodes: usize },
    /// A correlation at an end of what is searched.
    #[error(
        "the most likely correlation of neighbours is {}, an end of the searched range: it is not an estimate, and \
         the coverage of intervals may be below their level; give the correlation, or extend the model",
        rounded(*.correlation, 3)
    )]
    "correlation_at_bound" => CorrelationAtBound { correlation: f64 },
    /// A predicted error that nothing corrects.
    #[error(
        "predicted_mse_corrected is not available here: it needs a spectral scheme, ridge or Tikhonov (up to 200 \
         coefficients) whose parameter is given or chosen by sums over the spectrum, and an estimate of the noise"
    )]
    "no_corrected_error" => NothingToCorrect,
    /// Influences of too many nodes.
    #[error(
        "influences of {nodes} nodes are omitted: with so many coefficients they are available for up to {most} nodes"
    )]
    "no_influence" => InfluenceOfMany { nodes: usize, most: usize },
    /// Places whose results exceed the range of double.
    #[error(
        "{} omitted from the predictions (number {}, from 0): results there exceed the range of double precision",
        counted(*.count, "place is", "places are"), first(.places, *.count)
    )]
    "exceeds_double" => PlacesExceedDouble { places: Vec<usize>, count: usize },
    /// A prior that there is no noise to weigh against.
    #[error(
        "the model fits the heights exactly, so the noise, which the prior needs, cannot be estimated: the prior is \
         not used, and least squares of these nodes is returned; give `noise_sigma`"
    )]
    "prior_unused" => PriorWithoutNoise,
    /// The estimated degrees of freedom of Student's distribution at their lower end.
    #[error(
        "the most likely ν is {}, the end of its range: it is not an estimate, and the errors probably have another \
         distribution", Shown(*.degrees_of_freedom)
    )]
    "shape_at_bound" => FreedomAtBound { degrees_of_freedom: f64 },
    /// The estimated exponent of the generalised normal distribution at an end of its range.
    #[error(
        "the most likely exponent is {}, an end of its range: it is not an estimate, and the errors probably have \
         another distribution", Shown(*.exponent)
    )]
    "shape_at_bound" => ExponentAtBound { exponent: f64 },
    /// Weights that leave a robust estimate too few nodes for standard errors.
    #[error(
        "{nodes} nodes are too few for standard errors of {coefficients} coefficients by this estimator: intervals \
         and bands are omitted; measure more nodes, or use Huber's `m_estimator`"
    )]
    "too_few_nodes" => FewNodesOfRobust { nodes: usize, coefficients: usize },
    /// Influences of nodes whose errors are not white.
    #[error(
        "influences need independent errors of one variance: with this model of the errors they are omitted"
    )]
    "no_influence" => NoInfluenceOfErrors,
    /// A correction by simulation of errors that are not simulated.
    #[error(
        "the correction of the predicted error simulates independent errors of one variance: with this model of the \
         errors it is omitted"
    )]
    "no_corrected_error" => NoCorrectedError,
    /// The interval of a further height of unknown variance.
    #[error(
        "variances differ between nodes, and that of a further height is not known: intervals of further heights are \
         omitted"
    )]
    "no_prediction_intervals" => NoPredictionIntervals,
    /// The interval of a further height about a quantile.
    #[error(
        "a quantile does not describe the spread of heights: intervals of further heights are omitted; fit the two \
         quantiles that bound them"
    )]
    "no_prediction_intervals" => NoPredictionOfQuantile,
    /// Nodes without which the others do not determine the fit.
    #[error(
        "{} of leverage 1 (node {}): the fit passes through every height measured there, and without it the others do \
         not determine the coefficients, so its deletion diagnostics do not exist",
        counted(*.count, "node is", "nodes are"), first(.nodes, *.count)
    )]
    "full_leverage" => FullLeverage {
        /// The posted nodes, ten at most.
        nodes: Vec<usize>,
        /// Their number.
        count: usize,
    },
    /// Nodes without which nothing is left of the noise.
    #[error(
        "without {} (node {}) the others are fitted exactly: its externally studentised residual and DFFITS do not \
         exist",
        counted(*.count, "node", "nodes in turn"), first(.nodes, *.count)
    )]
    "no_noise_without" => NoNoiseWithout { nodes: Vec<usize>, count: usize },
    /// Nodes that are all fitted exactly.
    #[error(
        "every height is fitted exactly: studentised residuals, Cook's distances and DFFITS do not exist"
    )]
    "no_noise_without" => AllExact { nodes: Vec<usize>, count: usize },
    /// A shape of a measurement matrix.
    #[error("a measurement matrix is not a curve or surface: there is no shape")]
    "no_shape" => NoShapeOfMatrix,
    /// A shape of a higher degree than shapes have.
    #[error("curves and surfaces have degrees up to {most}: there is no shape of degree {degree}")]
    "no_shape" => NoShapeOfDegree {
        /// The highest degree of the fit.
        degree: usize,
        /// The highest of shapes.
        most: usize,
    },
    /// A shape over a domain without width, or with numbers above the range of double.
    #[error("the domain is a single point, or control points exceed the range of double precision: there is no shape")]
    "no_shape" => NoShapeOfPoint,
    /// Places outside the domain.
    #[error(
        "{} outside the domain: nothing was measured there, and the bands hold only if the model does",
        counted(*.count, "place lies", "places lie")
    )]
    "outside_domain" => OutsideDomain { count: usize },
    /// Residuals that contradict the assumptions.
    #[error("{warning}")]
    in warning => Residuals {
        /// The warning.
        #[cfg_attr(feature = "contract", serde(flatten))]
        warning: ResidualWarning,
    },
    /// Nodes that are suspected of gross errors.
    #[error("{0}")]
    "outliers_suspected" => OutliersSuspected(Outliers),
    /// Nodes that contradict the prior.
    #[error(
        "the nodes contradict the prior: e'S⁻¹e/n is {}, which has a probability of {} if the prior is right; it is \
         not used, and least squares of these nodes is returned", Size(*.statistic), Probability(*.p)
    )]
    "prior_conflict" => PriorConflict { statistic: f64, p: f64 },
    /// A prior of iterations whose noise is another: σ of these nodes and of all earlier ones,
    /// and the probability of so different ones by chance.
    #[error(
        "σ of these nodes is {}, that of the earlier iterations {} (in heights of weight 1): the prior assumes that \
         they are equal; compare the set-ups and the weights", Size(*.now), Size(*.earlier)
    )]
    "prior_noise_differs" => UnequalNoise { now: f64, earlier: f64, p: f64 },
    /// A model that was chosen by the nodes it is fitted to.
    #[error(
        "the model was chosen among {count} by the nodes that it is fitted to: intervals and standard errors ignore \
         this choice, and their coverage is below the level"
    )]
    "post_selection" => PostSelection { count: usize },
    /// A prior of iterations without any.
    #[error("there is no earlier iteration of this flank and tooth: least squares of these nodes is returned")]
    "no_earlier_iterations" => NoEarlierIterations,
    /// A representative piece whose directions are others.
    #[error(
        "the directions of the representative piece differ from those of these nodes (alignment {alignment:.3}): much \
         of the error along the smallest eigenvalues remains; measure at the places of the piece, or compute B from \
         these nodes"
    )]
    "representative_misaligned" => PieceMisaligned { alignment: f64 },
    /// A fit that has nothing to give to others.
    #[error("no eigenvalue is raised by a matrix B here: this fit has no data for others")]
    "no_representative" => NoPieceToGive,
    /// Constraints that hold the function back.
    #[error(
        "constraints are active at {}: standard errors hold the derivatives there at 0; intervals are those of least \
         squares, and the estimate may lie outside of them",
        counted(*.count, "place", "places")
    )]
    "constraints_active" => ConstraintsActive { count: usize },
}
}

/// Up to ten numbers of `count`.
fn first(numbers: &[usize], count: usize) -> String {
    format!("{}{}", listed(numbers), if numbers.len() < count { ", …" } else { "" })
}
