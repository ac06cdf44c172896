//! The parts of a fit's answer. Names and meanings are the contract's.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::declare::{FieldsAs, ListAs, Name, Symmetric, WriteAs, answer, names};
use crate::api::{ENGINE, json::writer::Object};
use flankfit_engine::estimation::{
    result::{
        self, Arithmetic, BiasReport, Cause, Coefficient, CollinearityReport, ColumnCollinearity, IntervalKind,
        LambdaCurvePoint, NearDependency, Numerics, OrthonormalBasis, PerturbationBounds, PerturbationReport,
        RegularizedSpectrum, ResidualReport, SpectrumReport, TermKey,
    },
    spec::{Include, PolynomialBasis},
};

answer! {
    /// One coefficient; exactly one of `powers`, `index` and `column` is there.
    #[schema(as = Coefficient)]
    pub struct CoefficientBody from Coefficient {
        term, key, value, std_error, conditional_std_error, least_squares, least_squares_std_error, bias_bound,
        interval,
    } {
        /// Readable name.
        #[schema(example = "u^2*v")]
        term: String = term,
        /// Degrees of a polynomial term: one for a curve, two for a surface.
        #[schema(example = json!([2, 1]))]
        powers?: Vec<usize> = if let TermKey::Powers(powers) = key { Some(powers) } else { None },
        /// Indices of a B-spline, from 0: one for a curve, two for a surface.
        index?: Vec<usize> = if let TermKey::Index(index) = key { Some(index) } else { None },
        /// Column of a measurement matrix, from 0.
        column?: usize = if let TermKey::Column(column) = key { Some(column) } else { None },
        /// The regularised estimate Â_B (Eq. 29) by the chosen estimator. With a `prior` the mean
        /// of the posterior; with `constraints` the best estimate that meets them.
        value: f64 = value,
        /// Standard error of `value` where λ* was given or the fit is not regularised, and of
        /// `least_squares` where λ* was chosen from the nodes. In simulations of one flank the
        /// truth lay within one standard error of least squares in 66 to 70 % of the cases
        /// (docs/explanation/mathematics.md). Absent without degrees of freedom. With a `prior` the
        /// standard deviation of the posterior, by `prior.sigma`. With `constraints` that of least
        /// squares with the derivatives at the active places held at 0, as if these places had been
        /// known beforehand: too small (docs/explanation/constraints.md).
        std_error?: f64 = std_error,
        /// Standard error of `value` for the λ* used, as if λ* had not been chosen from the same
        /// nodes; present where it was. It is too small and excludes the bias: the truth lay within
        /// it in 23 to 44 % of the cases, not 68 %.
        conditional_std_error?: f64 = conditional_std_error,
        /// Plain least-squares estimate from the posted nodes, whatever the estimator.
        least_squares: f64 = least_squares,
        /// Standard error of `least_squares`.
        least_squares_std_error?: f64 = least_squares_std_error,
        /// Sharp bound on the bias |Â − Â_B| of this coefficient for norm limit r. With a `prior`
        /// that of the posterior mean, for coefficients as far from the prior mean as its
        /// covariance P implies on average (eᵀP⁻¹e ≤ n). With `constraints` √n standard errors of
        /// least squares, which bound the bias for every truth that meets the constraints.
        bias_bound: f64 = bias_bound,
        /// Confidence interval of the true coefficient at `level`, `[low, high]`. Coverage at 0.95
        /// is 0.94 to 0.96 on average for independent normal errors
        /// (docs/explanation/intervals.md); for other cases see docs/explanation/errors.md,
        /// docs/explanation/prior.md and docs/explanation/selection.md. The regularised `value` may
        /// lie outside. Absent without an estimate of the noise, and where the coefficient is not
        /// bounded.
        #[schema(min_items = 2, max_items = 2)]
        interval?: [f64; 2] = interval.as_ref().map(|interval| &interval.ends),
        interval_kind?: IntervalKindName = interval.as_ref().map(|interval| &interval.kind),
        /// Student's interval about `least_squares` by these nodes alone; there with an `interval`
        /// of kind `bias_aware` or `posterior`.
        #[schema(min_items = 2, max_items = 2)]
        least_squares_interval?: [f64; 2] = interval.as_ref().and_then(|interval| interval.least_squares.as_ref()),
        /// Effect of the given norm limit (`coefficient_norm_limit`) or `prior`: the width of
        /// `interval` divided by that of Student's interval about least squares, above 0. 0.6 is an
        /// interval shorter by 40 %; 1 is no gain, and above 1 the prior made it wider.
        interval_gain?: f64 = interval.as_ref().and_then(|interval| interval.gain),
    }
}

names! {
    /// Basis of an interval. `student`: Student's t about the estimate. `least_squares`: Student's
    /// t about the unregularised estimate (least squares, or the robust estimate), where the bias
    /// of the regularised one is unbounded. (With `noise_sigma`, t is the normal quantile in all of
    /// these.) `bias_aware`: the shortest interval about a filtered estimate that holds for all
    /// coefficients within the given norm limit, and for no others. `posterior`: Student's t about
    /// the mean of the posterior, if the prior is given; if moves are estimated, an interval that
    /// is shorter where the earlier iterations predict well. With a known σ its coverage holds for
    /// any flank, and it is the same after a prior is dropped (docs/explanation/prior.md).
    #[schema(as = IntervalKind)]
    pub enum IntervalKindName from IntervalKind {
        Student = "student",
        LeastSquares = "least_squares",
        BiasAware = "bias_aware",
        Posterior = "posterior",
    }
}

impl From<IntervalKind> for IntervalKindName {
    fn from(kind: IntervalKind) -> Self {
        match kind {
            IntervalKind::Student => IntervalKindName::Student,
            IntervalKind::LeastSquares => IntervalKindName::LeastSquares,
            IntervalKind::BiasAware => IntervalKindName::BiasAware,
            IntervalKind::Posterior => IntervalKindName::Posterior,
        }
    }
}

answer! {
    /// Eigenvalues of the scaled Fisher information matrix.
    #[schema(as = Spectrum)]
    pub struct SpectrumBody from SpectrumReport {
        eigenvalues, condition, log10_condition, log10_determinant, rank, regularized,
    } {
        /// Ascending.
        eigenvalues: Vec<f64> = eigenvalues,
        /// λₙ/λ₁; absent when the rank is not full.
        condition?: f64 = condition,
        /// Decimal logarithm of the condition number.
        log10_condition?: f64 = log10_condition,
        /// Sum of the decimal logarithms of the eigenvalues; left out where one is 0.
        log10_determinant?: f64 = log10_determinant,
        /// Number of singular values above rounding error.
        rank: usize = rank,
        regularized: RegularizedSpectrumBody = regularized,
    }
}

answer! {
    /// After regularisation, in the order of the directions that the eigenvalues came from.
    #[schema(as = RegularizedSpectrum)]
    pub struct RegularizedSpectrumBody from RegularizedSpectrum { eigenvalues, condition, log10_determinant } {
        /// Eigenvalues after the regularisation.
        eigenvalues: Vec<f64> = eigenvalues,
        /// Greatest over least; left out where it is infinite.
        condition?: f64 = condition,
        /// Sum of the decimal logarithms of the eigenvalues; left out where one is 0.
        log10_determinant?: f64 = log10_determinant,
    }
}

answer! {
    /// Bias of the regularised estimate; norms are in the scaled columns.
    #[schema(as = Bias)]
    pub struct BiasBody from BiasReport {
        norm, sharp_bound, paper_bound, coefficient_norm_limit, coefficient_norm_limit_source, upper_confidence, e,
    } {
        /// Observed ‖Â − Â_B‖.
        norm: f64 = norm,
        /// The smallest bound that holds for every coefficient vector within the norm limit.
        sharp_bound: f64 = sharp_bound,
        /// Bound by Ineq. 51, where it holds.
        paper_bound?: f64 = paper_bound,
        /// r, the norm of the coefficients that the bounds allow for, in the scaled columns; with a
        /// prior the root mean square distance from its mean.
        coefficient_norm_limit: f64 = coefficient_norm_limit,
        coefficient_norm_limit_source: NormLimitSource = coefficient_norm_limit_source,
        /// Upper confidence limit of the norm of the true coefficients, by least squares and its
        /// errors. A first-order expansion, with a coverage below `level` (at 0.95 at worst 86 % of
        /// the draws of simulations). Present where r is the norm of the estimate and the fit is
        /// regularised; no bound uses it.
        upper_confidence?: f64 = upper_confidence,
        /// The small number e of Ineq. 51.
        e?: f64 = e,
    }
}

names! {
    /// Source of r.
    pub enum NormLimitSource from result::NormLimitSource {
        /// The norm of the least-squares estimate.
        Estimate = "estimate",
        Request = "request",
        /// What the heights speak for in every direction alike: √n τ with τ² = ‖P y‖²/Σλᵢ, or the
        /// norm of the regularised estimate, if greater.
        Heights = "heights",
        /// The limits of the coefficients, or the norm of the regularised estimate, if greater.
        Limits = "limits",
        /// The spread of the prior: the root of its total variance in the scaled columns.
        Prior = "prior",
    }
}

/// Source of the limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LimitSource {
    Estimate,
    Request,
}

answer! {
    /// Linear dependence of the columns.
    #[schema(as = Collinearity)]
    pub struct CollinearityBody from CollinearityReport {
        basis, columns, correlation, variance_proportions, near_dependencies,
    } with include {
        /// Each column against all others, in the order of the coefficients.
        columns: Vec<ColumnBody> = columns,
        /// Pearson correlation of the columns, in coefficient order. Present when `collinearity`
        /// was included.
        correlation?: Vec<Vec<f64>> = correlation.as_deref().filter(|_| include.collinearity).map(Symmetric),
        /// Per term, the share of its variance that belongs to each eigenvalue (ascending). Present
        /// when `collinearity` was included.
        variance_proportions?: Vec<Vec<f64>> = variance_proportions.as_ref().filter(|_| include.collinearity),
        /// The same columns in an orthonormal polynomial basis: whether a dependency is the nodes'
        /// or the basis's. Absent for models that are not made of polynomials.
        basis?: CollinearityBasisBody = basis,
        /// One for each small eigenvalue, the smallest first.
        near_dependencies: Vec<NearDependencyBody> = near_dependencies,
    }
}

answer! {
    /// The space of the columns in Legendre's basis over the domain, which is orthonormal there.
    #[schema(as = CollinearityBasis)]
    pub struct CollinearityBasisBody from OrthonormalBasis { condition } {
        /// `legendre`.
        kind as "type": PolynomialBasis = Name("legendre"),
        /// Condition of the Fisher information matrix of these columns at unit length, as
        /// `spectrum.condition` is of those asked for; left out where the nodes leave some function
        /// undetermined.
        condition?: f64 = condition,
    }
}

names! {
    /// Cause of a near dependency: `basis`, the columns are independent in Legendre's basis over
    /// the domain; `nodes`, the nodes cannot separate them in any basis, or there is no other
    /// basis.
    #[schema(as = DependencyCause)]
    pub enum CauseName from Cause {
        Basis = "basis",
        Nodes = "nodes",
    }
}

answer! {
    /// Collinearity of one column.
    #[schema(as = ColumnCollinearity)]
    pub struct ColumnBody from ColumnCollinearity { term, vif } {
        /// The column, named as its coefficient.
        term: String = term,
        /// Variance inflation factor 1/(1−R²), centred; absent for the constant.
        vif?: f64 = vif,
    }
}

answer! {
    /// A near linear dependency of columns.
    #[schema(as = NearDependency)]
    pub struct NearDependencyBody from NearDependency {
        eigenvalue, condition_index, weights, terms, cosine, weight_ratio, r_squared, cause, sentence,
    } with include {
        /// Eigenvalue of the scaled Fisher information matrix.
        eigenvalue: f64 = eigenvalue,
        /// √(greatest eigenvalue / this one); 30 and more are a matter of concern. Left out where
        /// it is infinite.
        condition_index?: f64 = condition_index,
        /// The eigenvector, with one entry for each column. Present with `include` of
        /// `collinearity`.
        weights?: Vec<f64> = include.collinearity.then_some(weights),
        /// The terms in the dependency.
        terms: Vec<String> = terms,
        /// Cosine of the angle between the two columns, where there are two terms.
        cosine?: f64 = cosine,
        /// For two terms: the limit of the cosine by Eq. 26.
        weight_ratio?: f64 = weight_ratio,
        /// R² of the leading term on the others, where there are more than two.
        r_squared?: f64 = r_squared,
        cause: CauseName = cause,
        /// The same in words.
        sentence: String = sentence,
    }
}

answer! {
    /// Bounds on the relative error of the coefficients that the nodes' uncertainty causes.
    #[schema(as = Perturbation)]
    pub struct PerturbationBody from PerturbationReport { least_squares, regularized } {
        least_squares: PerturbationBoundsBody = least_squares,
        regularized: PerturbationBoundsBody = regularized,
    }
}

answer! {
    /// Bounds on the relative error of the coefficients, in the scaled columns.
    #[schema(as = PerturbationBounds)]
    pub struct PerturbationBoundsBody from PerturbationBounds { square_bound, first_order_bound } {
        /// Bound by Ineq. 22; absent where the inequality does not apply.
        square_bound?: f64 = square_bound,
        /// First-order bound with the residual term.
        first_order_bound?: f64 = first_order_bound,
    }
}

answer! {
    /// Residuals Y − X Â_B.
    #[schema(as = Residuals)]
    pub struct ResidualsBody from ResidualReport {
        count, degrees_of_freedom, rss, sigma, rms, max_abs, r_squared, least_squares_rss, values, fitted, heights,
        node_indices,
    } {
        /// Nodes counted.
        count: usize = count,
        /// Nodes counted less coefficients.
        degrees_of_freedom: usize = degrees_of_freedom,
        /// Σ w r² of the regularised estimate.
        rss: f64 = rss,
        /// σ̂ of the plain least-squares fit; absent without degrees of freedom.
        sigma?: f64 = sigma,
        /// √(Σ w r² / Σ w), in the unit of the heights.
        rms: f64 = rms,
        /// Largest |residual|; absent in the answers of a stream, which keeps no nodes.
        max_abs?: f64 = max_abs,
        /// About the mean when the constant lies in the span of the columns, about 0 otherwise.
        r_squared?: f64 = r_squared,
        /// Σ w r² of the plain least-squares fit.
        least_squares_rss: f64 = least_squares_rss,
        /// One per counted node, in the order posted; present when `residuals` was included.
        values?: Vec<f64> = values,
        /// The fitted function at each counted node, in the order posted; present when `fitted` was
        /// included.
        fitted?: Vec<f64> = fitted,
        /// The height that was fitted of each counted node; present with `fitted` where filters
        /// changed some height.
        heights?: Vec<f64> = heights,
        /// The posted node (from 0, grids row by row) of each number of the lists above; present
        /// with them when some node was left out.
        node_indices?: Vec<usize> = node_indices,
    }
}

answer! {
    /// Figures for one value of λ*.
    #[schema(as = LambdaCurvePoint)]
    pub struct LambdaCurvePointBody from LambdaCurvePoint {
        lambda_star, condition, bias_norm, predicted_mse, rms, gcv, coefficient_norm,
    } {
        /// λ*, as an eigenvalue of the scaled Fisher information matrix.
        lambda_star: f64 = lambda_star,
        /// Condition number of the regularised matrix.
        condition?: f64 = condition,
        /// ‖Â − Â_B‖ in the scaled columns.
        bias_norm: f64 = bias_norm,
        /// Same as in `choices`.
        predicted_mse?: f64 = predicted_mse,
        /// Root mean square of the residuals.
        rms: f64 = rms,
        /// The function that generalised cross-validation makes least.
        gcv?: f64 = gcv,
        /// ‖Â_B‖ in the scaled columns.
        coefficient_norm: f64 = coefficient_norm,
    }
}

names! {
    /// Arithmetic of the decisive steps.
    pub enum ArithmeticName from Arithmetic {
        Double = "double",
        DoubleDouble = "double_double",
    }
}

answer! {
    /// Numerical accuracy of the answer.
    #[schema(as = Numerics)]
    pub struct NumericsBody from Numerics { arithmetic, correct_digits } {
        arithmetic: ArithmeticName = arithmetic,
        /// Estimated correct decimal digits of the worst least-squares coefficient; errs on the low
        /// side.
        correct_digits: f64 = correct_digits,
    }
}

/// What the answer's provenance is written from.
pub struct Provenance<'a> {
    pub input_sha256: &'a str,
}

answer! {
    /// Engine, versions and digest of the input of the answer.
    #[derive(Eq)]
    #[schema(as = Provenance)]
    pub struct ProvenanceBody from Provenance<'a> { input_sha256 } {
        /// Program and version that computed the answer.
        #[schema(value_type = String, example = "flankfit 0.1.0")]
        engine: Cow<'static, str> = ENGINE,
        /// SHA-256 of the canonical form of nodes and spec, independent of white space and key
        /// order.
        #[schema(min_length = 64, max_length = 64)]
        input_sha256: String = input_sha256,
    }
}
