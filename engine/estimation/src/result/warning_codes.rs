//! The stable codes of warnings.

use super::warning::Warning;

impl Warning {
    /// The stable code.
    pub fn code(&self) -> &'static str {
        use Warning::*;
        match self {
            NoDegreesOfFreedom => "no_degrees_of_freedom",
            RankDeficient { .. } | NoSpectralSchemes { .. } => "rank_deficient",
            InfiniteInflation(_) => "vif_infinite",
            BeyondDouble(_) | PlacesBeyondDouble { .. } => "beyond_double",
            FewDigits(_) => "few_digits",
            NoRegularizedPerturbation => "no_regularized_perturbation",
            NoRelativeError => "no_relative_error",
            PerturbationUnbounded => "perturbation_unbounded",
            NormLimitBelowEstimate { .. } => "norm_limit_below_estimate",
            NormLimitIsEstimate { .. } => "norm_limit_is_estimate",
            NoLambda | NoLambdaOf(_) => "no_lambda_curve",
            MatrixBIsSpectral | MatrixBOfStandardized | MatrixBNeedsNodes => "no_matrix_b",
            NoRidgeTrace => "no_ridge_trace",
            AttractedEntirely => "attracted_entirely",
            TargetOfConstantUnused => "target_of_constant_unused",
            DiscrepancyNotReached(_) => "discrepancy_not_reached",
            LambdaAtLimit(_) => "lambda_at_limit",
            SigmaMissing(_) => "criterion_unavailable",
            WorseThanLeastSquares(_) => "worse_than_least_squares",
            WeightsNotConverged { .. } | NewtonNotConverged { .. } | SimplexStopped(_) | DispersionStopped => {
                "not_converged"
            }
            SumNotUnique | DispersionNotUnique => "not_unique",
            ExactFit { .. } => "exact_fit",
            NoScale => "no_scale",
            FilteredNoise => "filtered_noise",
            FilterNotConverged { .. } => "filter_not_converged",
            FilteredColumnsDependent => "filtered_columns_dependent",
            FilteredColumnsNotExamined => "filtered_columns_not_examined",
            FilteringRaisesCollinearity { .. } => "filtering_raises_collinearity",
            NodesNotKept => "nodes_not_kept",
            Forgetting { .. } => "forgetting",
            ConditionUnknown => "condition_unknown",
            EmptySpans { .. } => "empty_spans",
            NoStandardErrors(_) => "no_standard_errors",
            DependentLevels(_) => "dependent_columns",
            NoNoise => "no_noise",
            NoPredictions => "no_predictions",
            NoInfluence | NoInfluenceOfRobust | NoInfluenceOfErrors | InfluenceOfMany { .. } => "no_influence",
            PositionsAsExact => "positions_as_exact",
            PositionsUncertain { .. } => "positions_uncertain",
            UncertaintyContradicted(_) => "uncertainty_contradicted",
            GroupVarianceUncertain { .. } => "group_variance_uncertain",
            PowerUncertain { .. } => "power_uncertain",
            NormLimitUnused => "norm_limit_unused",
            PriorWithoutNoise => "prior_unused",
            CorrelationAtBound(_) => "correlation_at_bound",
            ShapeAtBound(_) => "shape_at_bound",
            NoCorrectedError | NothingToCorrect => "no_corrected_error",
            NoPredictionIntervals | NoPredictionOfQuantile => "no_prediction_intervals",
            FullLeverage { .. } => "full_leverage",
            NoNoiseWithout(_) => "no_noise_without",
            NoShapeOfMatrix | NoShapeOfDegree { .. } | NoShapeOfPoint => "no_shape",
            OutsideDomain(_) => "outside_domain",
            CorrelatedResiduals { .. } => "correlated_residuals",
            OutliersSuspected(_) => "outliers_suspected",
            PriorConflict(_) => "prior_conflict",
            UnequalNoise(_) => "prior_noise_differs",
            PostSelection(_) => "post_selection",
            NoEarlierIterations => "no_earlier_iterations",
            PieceMisaligned(_) => "representative_misaligned",
            NoPieceToGive => "no_representative",
            ConstraintsActive(_) => "constraints_active",
        }
    }
}
