//! The regularisation in a fit's answer. Names and meanings are the contract's.

use super::declare::{FieldsAs, ListAs, Name, WriteAs, answer, names};
use super::representative::RepresentativeResultBody;
use crate::{
    api::{
        fits::spec::criteria::{ChosenBy, FIXED, LEAST_SQUARES},
        json::writer::Object,
    },
    jobs::scheme_name,
};
use flankfit_engine::estimation::{
    result::{Choice, RegularizationKind, RegularizationReport, RidgeTracePoint},
    spec::{Criterion, Include, Scheme},
};

names! {
    /// Type of the regularisation.
    pub enum RegularizationName from RegularizationKind {
        None = "none",
        Spectral = "spectral",
        Ridge = "ridge",
        Tikhonov = "tikhonov",
        TruncatedSvd = "truncated_svd",
        JamesStein = "james_stein",
        Attraction = "attraction",
        Representative = "representative",
    }
}

answer! {
    /// The applied regularisation, and the choices of all criteria.
    pub struct RegularizationResult from RegularizationReport {
        kind, scheme, count, lambda_star, rank, shrinkage_factor, lambda_star_interval, gamma, criterion, fixed,
        filter_factors, matrix_norm_squared, largest_eigenvalue_bound, predicted_mse_corrected, representative,
        choices,
    } {
        kind as "type": RegularizationName = kind,
        scheme?: Scheme = scheme.map(|scheme| Name(scheme_name(scheme))),
        /// L: how many of the smallest eigenvalues were regularised.
        count?: usize = count,
        /// λ* of the spectral schemes, k of ridge and attraction, λ of Tikhonov; absent without
        /// regularisation and for methods without such a parameter (truncated SVD, James–Stein, an
        /// attraction of infinite weight).
        lambda_star?: f64 = lambda_star,
        /// Directions that a truncated singular value decomposition keeps.
        rank?: usize = rank,
        /// c of James–Stein and attraction: the factor of Â − T.
        shrinkage_factor?: f64 = shrinkage_factor,
        /// The plateau of minimisers of Eq. 49, where there is one: [lo, hi].
        #[schema(value_type = Option<Vec<f64>>, min_items = 2, max_items = 2)]
        lambda_star_interval?: [f64; 2] = lambda_star_interval,
        /// λ* − λ₁.
        gamma?: f64 = gamma,
        criterion?: ChosenBy = if *fixed { Some(FIXED) } else { criterion.map(Criterion::name) }.map(Name),
        /// Factor of each direction: 1 is not regularised. In the order of `spectrum.eigenvalues`;
        /// for Tikhonov the directions are those of matrix and penalty together, the most penalised
        /// first. With a `prior` the share of the nodes in the information along each direction in
        /// which nodes and prior are independent, the smallest first; the rest is the prior's. With
        /// `constraints` first a 0 for each direction that active places hold, then 1 for the
        /// others.
        filter_factors: Vec<f64> = filter_factors,
        /// ‖B‖² (Eq. 41).
        matrix_norm_squared?: f64 = matrix_norm_squared,
        /// Ineq. 48.
        largest_eigenvalue_bound?: f64 = largest_eigenvalue_bound,
        /// Mean squared error of the coefficients in the scaled columns: `predicted_mse` of the
        /// applied choice, corrected by simulation for having been chosen from the same nodes. With
        /// `min_mse` of the matrix B and ridge its mean is 0.78 to 1.22 times the true error in 144
        /// simulated cases with three degrees of freedom or more; the uncorrected figure is 0.28 to
        /// 1.03 times it (docs/explanation/choosing-lambda.md). A single figure scatters by once to
        /// twice its size; other criteria, and Tikhonov, were not simulated. Present with `include`
        /// of `predicted_mse`; not with `press`, `blocked_cv`, truncated SVD, James–Stein and
        /// attraction.
        predicted_mse_corrected?: f64 = predicted_mse_corrected,
        /// Present for `representative`.
        representative?: RepresentativeResultBody = representative,
        /// Least squares, the requested criterion and the criteria that are cheap to compute, for
        /// comparison. For Tikhonov with more than 64 coefficients `min_condition` is included only
        /// on request, or with `lambda_curve`.
        choices: Vec<ChoiceBody> = choices,
    }
}

answer! {
    /// The choice of one criterion.
    #[schema(as = Choice)]
    pub struct ChoiceBody from Choice { criterion, lambda_star, condition, bias_norm, predicted_mse, rms } {
        criterion: ChosenBy = Name(criterion.map_or(LEAST_SQUARES, Criterion::name)),
        /// The λ* that the criterion would choose, as an eigenvalue of the scaled Fisher
        /// information matrix.
        lambda_star?: f64 = lambda_star,
        /// Condition number of the regularised matrix; left out where it is infinite.
        condition?: f64 = condition,
        /// ‖Â − Â_B‖ in the scaled columns.
        bias_norm: f64 = bias_norm,
        /// Predicted mean squared error of the coefficients in the scaled columns: good for
        /// comparing criteria on the same nodes. That of the chosen one is mostly too small: 0.42
        /// of the true error in simulations of one flank (docs/explanation/mathematics.md), 0.28 to
        /// 1.03 over other cases (docs/explanation/choosing-lambda.md).
        predicted_mse?: f64 = predicted_mse,
        /// Root mean square of the residuals, in the unit of the heights.
        rms: f64 = rms,
    }
}

answer! {
    /// The coefficients of ridge at one k.
    #[schema(as = RidgeTracePoint)]
    pub struct RidgeTracePointBody from RidgeTracePoint { k, coefficients } {
        /// The constant added to the eigenvalues of the scaled Fisher information matrix.
        k: f64 = k,
        /// In the terms of the request, in the order of the answer's `coefficients`.
        coefficients: Vec<f64> = coefficients,
    }
}
