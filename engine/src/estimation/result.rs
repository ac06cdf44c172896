//! The answer to a fit. Field names and meanings are the contract's; a value that does not exist is
//! `None`.

use std::sync::{Arc, OnceLock};

use super::{
    estimator::Start,
    filtering::report::FilteringReport,
    spec::{Criterion, Domain, Scheme},
};

#[derive(Clone, Debug, PartialEq)]
pub struct FitResult {
    pub coefficients: Vec<Coefficient>,
    /// The box on which mapped bases live; `None` for a measurement matrix.
    pub domain: Option<Domain>,
    pub spectrum: SpectrumReport,
    pub regularization: RegularizationReport,
    pub bias: BiasReport,
    pub collinearity: Arc<CollinearityReport>,
    pub perturbation: Option<PerturbationReport>,
    pub residuals: ResidualReport,
    /// Present for every estimator but least squares.
    pub robust: Option<RobustReport>,
    /// Present when `lambda_curve` was included.
    pub lambda_curve: Option<Vec<LambdaCurvePoint>>,
    /// Present when `ridge_trace` was included.
    pub ridge_trace: Option<Vec<RidgeTracePoint>>,
    /// Rows of B (m×n, in the caller's columns), present when `matrix_b` was included.
    pub matrix_b: Option<Vec<Vec<f64>>>,
    /// Present when filters were asked for.
    pub filtering: Option<FilteringReport>,
    pub numerics: Numerics,
    pub warnings: Vec<Warning>,
}

/// How a coefficient is addressed: exactly one of the three.
#[derive(Clone, Debug, PartialEq)]
pub enum TermKey {
    /// Polynomial degrees: `[p]` for a curve, `[p, q]` for a surface.
    Powers(Vec<usize>),
    /// B-spline indices, from 0.
    Index(Vec<usize>),
    /// Column of a measurement matrix, from 0.
    Column(usize),
}

#[derive(Clone, Debug, PartialEq)]
pub struct Coefficient {
    /// Readable name: `u^2*v`, `T2(u)*T1(v)`, `B3(u)*B0(v)`, or the column's name.
    pub term: String,
    pub key: TermKey,
    /// Regularised estimate Â_B (Eq. 29).
    pub value: f64,
    pub std_error: Option<f64>,
    pub least_squares: f64,
    pub least_squares_std_error: Option<f64>,
    /// Sharp bound on |Â − Â_B| of this coefficient, given r.
    pub bias_bound: f64,
}

#[derive(Clone, Debug, PartialEq)]
pub struct SpectrumReport {
    /// Of the scaled Fisher information matrix, ascending.
    pub eigenvalues: Vec<f64>,
    pub condition: Option<f64>,
    pub log10_condition: Option<f64>,
    pub log10_determinant: Option<f64>,
    pub rank: usize,
    /// In the order of the directions that the eigenvalues came from.
    pub regularized: RegularizedSpectrum,
}

#[derive(Clone, Debug, PartialEq)]
pub struct RegularizedSpectrum {
    pub eigenvalues: Vec<f64>,
    pub condition: Option<f64>,
    pub log10_determinant: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegularizationKind {
    None,
    Spectral,
    Ridge,
    Tikhonov,
    TruncatedSvd,
    JamesStein,
    Attraction,
}

#[derive(Clone, Debug, PartialEq)]
pub struct RegularizationReport {
    pub kind: RegularizationKind,
    pub scheme: Option<Scheme>,
    /// L.
    pub count: Option<usize>,
    /// λ* of the spectral schemes, k of ridge, the weight of the penalty of Tikhonov, the weight of
    /// an attraction.
    pub lambda_star: Option<f64>,
    /// Directions kept by a truncated singular value decomposition.
    pub rank: Option<usize>,
    /// What James–Stein or an attraction leaves of Â − target.
    pub shrinkage_factor: Option<f64>,
    /// The plateau of minimisers of Eq. 49, where there is one.
    pub lambda_star_interval: Option<[f64; 2]>,
    /// λ* − λ₁.
    pub gamma: Option<f64>,
    /// `None` with `fixed == true` for a caller's value, and for no regularisation.
    pub criterion: Option<Criterion>,
    pub fixed: bool,
    pub filter_factors: Vec<f64>,
    /// Eq. 41.
    pub matrix_norm_squared: Option<f64>,
    /// Ineq. 48.
    pub largest_eigenvalue_bound: Option<f64>,
    pub choices: Vec<Choice>,
}

/// What one criterion would choose.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// `None` is plain least squares.
    pub criterion: Option<Criterion>,
    pub lambda_star: Option<f64>,
    pub condition: Option<f64>,
    pub bias_norm: f64,
    pub predicted_mse: Option<f64>,
    pub rms: f64,
}

/// Where r came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NormLimitSource {
    Request,
    /// ‖Â‖.
    Estimate,
    /// What the heights speak for ([`super::spec::ExpectedSize::OfHeights`]).
    Heights,
    /// Limits of the coefficients ([`super::spec::ExpectedSize::Within`]).
    Limits,
}

impl NormLimitSource {
    /// As the interface writes it.
    pub fn name(self) -> &'static str {
        match self {
            NormLimitSource::Request => "request",
            NormLimitSource::Estimate => "estimate",
            NormLimitSource::Heights => "heights",
            NormLimitSource::Limits => "limits",
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct BiasReport {
    /// Observed ‖Â − Â_B‖ in the scaled columns.
    pub norm: f64,
    pub sharp_bound: f64,
    /// Ineq. 51; `None` for ridge and for n = 1, where it does not hold.
    pub paper_bound: Option<f64>,
    pub coefficient_norm_limit: f64,
    pub coefficient_norm_limit_source: NormLimitSource,
    /// The small number e of Ineq. 51, read as max cᵢ.
    pub e: Option<f64>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct CollinearityReport {
    /// Its text, once somebody has written it: a report may be shared by many results.
    pub written: Written,
    pub columns: Vec<ColumnCollinearity>,
    /// Pearson correlation of the columns, in coefficient order; `None` beyond the size limit
    /// unless included.
    pub correlation: Option<Vec<Vec<f64>>>,
    /// Per term, the share of its variance that belongs to each eigenvalue (ascending).
    pub variance_proportions: Option<Vec<Vec<f64>>>,
    pub near_dependencies: Vec<NearDependency>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct ColumnCollinearity {
    pub term: String,
    /// 1/(1−R²), centred; `None` for the constant.
    pub vif: Option<f64>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct NearDependency {
    pub eigenvalue: f64,
    pub condition_index: Option<f64>,
    /// The eigenvector: how much of each unit-length column takes part.
    pub weights: Vec<f64>,
    pub terms: Vec<String>,
    /// cos of the angle between the two columns, where there are two terms.
    pub cosine: Option<f64>,
    /// −v_i/v_j, which Eq. 26 says the cosine tends to, where there are two terms.
    pub weight_ratio: Option<f64>,
    /// R² of the leading term on the others, where there are more than two.
    pub r_squared: Option<f64>,
    pub sentence: String,
}

#[derive(Clone, Debug, PartialEq)]
pub struct PerturbationReport {
    pub least_squares: PerturbationBounds,
    pub regularized: PerturbationBounds,
}

/// Bounds on the relative error of the coefficients in the scaled columns.
#[derive(Clone, Debug, PartialEq)]
pub struct PerturbationBounds {
    /// Ineq. 22, mended; `None` where κ·ε ≥ 1.
    pub square_bound: Option<f64>,
    /// Wedin's first-order bound, with the residual term.
    pub first_order_bound: Option<f64>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct ResidualReport {
    /// Nodes counted (missing ones and those of weight 0 are not).
    pub count: usize,
    pub degrees_of_freedom: usize,
    /// Σ w r² of the regularised estimate.
    pub rss: f64,
    /// σ̂ of the least-squares residuals; `None` without degrees of freedom.
    pub sigma: Option<f64>,
    /// √(Σ w r² / Σ w).
    pub rms: f64,
    /// `None` where the nodes are gone (a stream keeps sums only).
    pub max_abs: Option<f64>,
    pub r_squared: Option<f64>,
    pub least_squares_rss: f64,
    /// One per counted node, in the order posted (grids row by row); present when included.
    pub values: Option<Vec<f64>>,
    /// Which posted node each value belongs to; present with `values` when some node was left out.
    pub node_indices: Option<Vec<usize>>,
}

/// How a robust estimate was reached. Lengths are in the unit of the heights (times √weight, where
/// nodes carry weights).
#[derive(Clone, Debug, PartialEq)]
pub struct RobustReport {
    pub converged: bool,
    /// Reweightings, Newton's steps, concentration steps or changes of the vertex.
    pub iterations: usize,
    /// M: the last change of residuals and scale, in scales. Lp: the last change of residuals,
    /// relative to the largest.
    pub tolerance_reached: Option<f64>,
    /// s of M-estimators and trimmed squares, MAD of Lp, τ of the others; 0 for an exact fit,
    /// `None` where too few nodes tell it.
    pub scale: Option<f64>,
    /// τ in the covariance `τ² (XᵀX)⁻¹` of the unregularised estimate.
    pub dispersion: Option<f64>,
    /// What is least: Σρ(r/s), Σ|r|, Σ|r|^p, Σρ_τ(r), Σ of the h smallest r², or Jaeckel's D.
    pub objective: f64,
    /// One per counted node, in the order posted.
    pub weights: Vec<f64>,
    /// Posted nodes of weight 0.
    pub rejected: Vec<usize>,
    /// Largest dual on the vertex; at most 1 (but for rounding) proves the optimum.
    pub certificate: Option<f64>,
    pub unique: Option<bool>,
    /// Posted nodes that the surface passes through by construction.
    pub vertex: Option<Vec<usize>>,
    /// h of trimmed squares.
    pub subset_size: Option<usize>,
    pub start: Option<Start>,
    pub solution: LocalSolution,
    /// The estimate before regularisation, in the caller's terms.
    pub coefficients: Vec<f64>,
}

/// Which minimum was reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LocalSolution {
    /// Of all coefficients none do better.
    Global,
    /// The solution that the iteration reaches from its start; there may be others.
    FromStart,
    /// The best of many random starts.
    BestOfMany,
}

#[derive(Clone, Debug, PartialEq)]
pub struct LambdaCurvePoint {
    pub lambda_star: f64,
    pub condition: Option<f64>,
    pub bias_norm: f64,
    pub predicted_mse: Option<f64>,
    pub rms: f64,
    pub gcv: Option<f64>,
    pub coefficient_norm: f64,
}

/// The coefficients at one k.
#[derive(Clone, Debug, PartialEq)]
pub struct RidgeTracePoint {
    pub k: f64,
    /// In the caller's terms and order.
    pub coefficients: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arithmetic {
    Double,
    DoubleDouble,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Numerics {
    pub arithmetic: Arithmetic,
    /// Estimated correct decimal digits of the worst least-squares coefficient; errs on the low
    /// side.
    pub correct_digits: f64,
}

/// A stable code and a sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    pub code: &'static str,
    pub message: String,
}

/// A place for the text of a part, so that it is written once. Parts that are equal may differ in
/// whether they were written.
#[derive(Default)]
pub struct Written(pub OnceLock<Box<[u8]>>);

impl Clone for Written {
    /// The copy may be changed, so it has not been written yet.
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl PartialEq for Written {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}

impl std::fmt::Debug for Written {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Written").field(&self.0.get().map(|text| text.len())).finish()
    }
}
