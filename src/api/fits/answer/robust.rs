//! How a robust estimate was reached, as it is answered.

use super::declare::{FieldsAs, ListAs, Serialized, WriteAs, answer, names};
use crate::api::json::writer::Object;
use flankfit_engine::estimation::{
    result::{LikelihoodReport, LocalSolution, MinimaxReport, RobustReport},
    spec::{Include, Start},
};

answer! {
    /// Report on a robust estimate. Lengths are in the unit of the heights (times √weight, where
    /// nodes have weights).
    ///
    /// With `m_estimator`, `least_trimmed_squares` and `trimmed` the spectrum, regularisation, bias
    /// and collinearity of the answer are those of the matrix weighted with node weights times
    /// `weights`; with the other estimators those of the matrix with node weights alone.
    #[schema(as = Robust)]
    pub struct RobustBody from RobustReport {
        converged, iterations, tolerance_reached, scale, dispersion, objective, weights, rejected, certificate,
        unique, vertex, subset_size, start, solution, minimax, likelihood, coefficients,
    } with include {
        /// True if the iteration met its own criterion.
        converged: bool = converged,
        /// Reweightings (`m_estimator`, `student`), Newton's steps (`lp`), fits of subsets
        /// (`least_trimmed_squares`), changes of the vertex (the others).
        iterations: usize = iterations,
        /// Last change of residuals and scale, in scales (`m_estimator`), or of residuals, relative
        /// to the largest (`lp`).
        tolerance_reached?: f64 = tolerance_reached,
        /// Scale of the residuals (`m_estimator`, `least_trimmed_squares`; s, b or a of
        /// `maximum_likelihood`; MAD for `lp`), or `dispersion` (the others); 0 for an exact fit of
        /// most nodes, absent where too few nodes have a residual.
        scale?: f64 = scale,
        /// τ: without regularisation std_error² is τ² times the diagonal of (XᵀX)⁻¹, X with the
        /// node weights. Absent where it does not exist.
        dispersion?: f64 = dispersion,
        /// Minimum of the objective: Σρ(r/s), Σ|r|, Σ|r|^p, Σρ_τ(r), the sum of the h smallest r²,
        /// Jaeckel's dispersion, the squares of trimmed or winsorized nodes, or −ln L.
        objective: f64 = objective,
        /// One per counted node, in the order posted. `m_estimator`: ψ(u)/u.
        /// `least_trimmed_squares`: 1 in the sum, 0 not. The others: influence per unit of
        /// residual, relative to what a residual of one scale has, at most 1 (these do not enter
        /// the matrix). Present when `robust_weights` was included.
        weights?: Vec<f64> = include.robust_weights.then_some(weights),
        /// Number of nodes with weight 0.
        rejected_count: usize = rejected.len(),
        /// Posted nodes (from 0, grids row by row) that were given no weight. Present when
        /// `robust_weights` was included.
        rejected?: Vec<usize> = include.robust_weights.then_some(rejected),
        /// Largest dual on the vertex; at most 1 (but for rounding) proves that nothing does
        /// better.
        certificate?: f64 = certificate,
        /// True if the minimum has no other coefficients; present where this is known.
        unique?: bool = unique,
        /// Posted nodes that determine the surface, which passes through them.
        vertex?: Vec<usize> = vertex,
        /// h, the number of nodes in the trimmed sum.
        subset_size?: usize = subset_size,
        /// Start of the iteration.
        start?: Start = start.map(Serialized),
        /// Which solution was reached.
        solution: SolutionName = solution,
        /// The tuning constant that follows from a share of gross errors.
        minimax?: MinimaxBody = minimax,
        /// The distribution of the errors (`maximum_likelihood`); absent for an exact fit.
        likelihood?: LikelihoodBody = likelihood,
        /// The estimate before regularisation, in the order of `coefficients`.
        coefficients: Vec<f64> = coefficients,
    }
}

answer! {
    /// Huber's k against a share ε of gross errors (Eq. 10).
    #[schema(as = Minimax)]
    pub struct MinimaxBody from MinimaxReport { contamination, estimated, k, variance } {
        /// ε.
        contamination: f64 = contamination,
        /// True if ε was estimated.
        estimated: bool = estimated,
        /// Residuals up to k scales count by their squares.
        k: f64 = k,
        /// The greatest asymptotic variance that the estimator has with any symmetric gross errors,
        /// in squares of the scale; without them it is 1 at least.
        variance: f64 = variance,
    }
}

answer! {
    /// The distribution of the errors.
    #[schema(as = Likelihood)]
    pub struct LikelihoodBody from LikelihoodReport { shape, shape_std_error, log_likelihood, distribution: _ } {
        /// ν of Student's distribution, p of the generalised normal, given or estimated; absent for
        /// Laplace's.
        shape?: f64 = shape,
        /// Asymptotic standard error of an estimated shape; absent at an end of its range.
        shape_std_error?: f64 = shape_std_error,
        /// ln L of the unregularised estimate, with every constant.
        log_likelihood: f64 = log_likelihood,
    }
}

names! {
    /// Nothing does better (`global`); the one reached from the start (`from_start`), there may be
    /// others; the best of many random starts.
    pub enum SolutionName from LocalSolution {
        Global = "global",
        FromStart = "from_start",
        BestOfMany = "best_of_many",
    }
}
