//! What a caller asks for: model, scaling, regularisation. Plain values; [`super::fit::fit`] checks
//! them against the nodes.

pub use super::estimator::Estimator;
pub use super::filtering::spec::Filter;
pub use super::regularized::spec::{Attraction, JamesStein, ShrinkageFactor, Tikhonov};

/// Everything about a fit but the nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct FitSpec {
    pub model: Model,
    pub scaling: Scaling,
    pub regularization: Regularization,
    pub estimator: Estimator,
    /// The box on which mapped bases live; by default the smallest box of the counted nodes.
    pub domain: Option<Domain>,
    /// `r ≥ ‖A‖` of Ineq. 51, in the scaled columns.
    pub coefficient_norm_limit: Option<f64>,
    /// What r is without it.
    pub expected_size: ExpectedSize,
    /// Standard deviation of a height of weight 1; by default estimated from the residuals.
    pub noise_sigma: Option<f64>,
    pub node_uncertainty: Option<NodeUncertainty>,
    pub include: Include,
    /// What is done to the nodes before, in this order.
    pub filters: Vec<Filter>,
}

impl FitSpec {
    /// The defaults of the contract for a model: unit-length scaling, spectral / first_order / auto
    /// / min_mse, least squares.
    pub fn new(model: Model) -> Self {
        FitSpec {
            model,
            scaling: Scaling::UnitLength,
            regularization: Regularization::default(),
            estimator: Estimator::LeastSquares,
            domain: None,
            coefficient_norm_limit: None,
            expected_size: ExpectedSize::default(),
            noise_sigma: None,
            node_uncertainty: None,
            include: Include::default(),
            filters: Vec::new(),
        }
    }
}

/// How large the coefficients are taken to be. The estimate is the plain answer, but along
/// directions with small eigenvalues it holds little but error: who chooses λ* because of that must
/// not have the result judged by it. So with anything but [`ExpectedSize::Estimated`] the mean
/// squared error that takes the estimate for real is no yardstick, and no warning is derived from
/// it.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum ExpectedSize {
    /// As the least-squares estimate: r = ‖Â‖.
    #[default]
    Estimated,
    /// As large as the heights speak for, in every direction alike: r = √n τ with τ² = ‖P y‖²/Σλᵢ,
    /// P y being the part of the heights that the columns reach; at least the norm of the
    /// regularised estimate.
    OfHeights,
    /// Within ± these, one for each coefficient in the caller's unit: r is the norm where all are
    /// reached; at least that of the regularised estimate.
    Within(Vec<f64>),
}

/// The functions whose mixture is fitted.
#[derive(Clone, Debug, PartialEq)]
pub enum Model {
    Polynomial {
        degree: Degree,
        basis: PolynomialBasis,
        terms: Terms,
    },
    BSpline {
        degree: Degree,
        knots: Knots,
        /// Of NURBS: one weight > 0 per control point (for a surface v running fastest). They are
        /// given, not fitted.
        weights: Option<Vec<f64>>,
    },
    /// The columns of a measurement matrix as they are.
    Linear,
}

/// One degree for every axis, or one for each (`[p, q]`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Degree {
    Both(usize),
    Each(usize, usize),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PolynomialBasis {
    /// Powers of the caller's raw u and v.
    Monomial,
    /// Chebyshev polynomials on the domain mapped to [-1, 1].
    Chebyshev,
    /// Legendre polynomials on the domain mapped to [-1, 1].
    Legendre,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Terms {
    /// Every product up to the degree of each axis.
    Tensor,
    /// Products whose degrees add up to at most the degree.
    Total,
}

/// Knots of B-splines (full vectors, the last span closed on the right) or a count of equal spans
/// over the domain.
#[derive(Clone, Debug, PartialEq)]
pub enum Knots {
    /// A full knot vector for a curve.
    Curve(Vec<f64>),
    /// A full knot vector for u and one for v.
    Surface(Vec<f64>, Vec<f64>),
    /// The same number of equal spans on every axis.
    Spans(usize),
    /// Equal spans, a number for each axis.
    SpansEach(usize, usize),
}

/// Of X's columns before the eigen analysis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Scaling {
    /// Every column divided by its Euclidean length.
    #[default]
    UnitLength,
    /// The paper's: as they are.
    None,
    /// Centred and divided by √mean((x−x̄)²), the constant not penalised.
    Standardized,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Regularization {
    None,
    /// The paper's matrix B (Eq. 40).
    Spectral {
        scheme: Scheme,
        count: Count,
        condition_limit: f64,
        lambda_star: Parameter,
    },
    Ridge {
        parameter: Parameter,
    },
    Tikhonov(Tikhonov),
    /// Only the `rank` largest singular values are kept.
    TruncatedSvd {
        rank: usize,
    },
    JamesStein(JamesStein),
    Attraction(Attraction),
}

/// Condition index 30 on unit-length columns (Belsley's rule), squared.
pub const DEFAULT_CONDITION_LIMIT: f64 = 900.0;

impl Default for Regularization {
    fn default() -> Self {
        Regularization::Spectral {
            scheme: Scheme::FirstOrder,
            count: Count::Auto,
            condition_limit: DEFAULT_CONDITION_LIMIT,
            lambda_star: Parameter::Criterion(Criterion::MinMse),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Scheme {
    /// cᵢ = (λ* − λᵢ)/(2λᵢ), Eq. 40.
    #[default]
    FirstOrder,
    /// cᵢ = √(λ*/λᵢ) − 1, which makes the regularised eigenvalue λ* exactly.
    Exact,
}

/// How many of the smallest eigenvalues are regularised (L).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Count {
    /// Those with λₙ/λᵢ above the condition limit.
    #[default]
    Auto,
    Given(usize),
}

/// λ* of the spectral schemes, k of ridge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameter {
    Criterion(Criterion),
    Fixed(f64),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Criterion {
    MinMse,
    MinCondition,
    Gcv,
    Discrepancy,
    LCurve,
    /// Ridge: (p−2)σ²/‖Â‖², the modified form of Hoerl, Kennard and Baldwin.
    Hkb,
    /// Ridge: pσ²/‖Â‖², as Hoerl, Kennard and Baldwin (1975) gave it.
    Hkb1975,
    /// Ridge: (p−2)σ² λ̄/ΣλᵢÂᵢ², after Lawless and Wang.
    LawlessWang,
    /// Attraction: the explicit minimiser of the predicted mean squared error.
    Optimal,
}

impl Criterion {
    /// Those that every regularisation with a parameter may be asked for; the others belong to one
    /// kind.
    pub const ALL: [Criterion; 5] =
        [Criterion::MinMse, Criterion::MinCondition, Criterion::Gcv, Criterion::Discrepancy, Criterion::LCurve];

    /// The contract's name.
    pub fn name(self) -> &'static str {
        match self {
            Criterion::MinMse => "min_mse",
            Criterion::MinCondition => "min_condition",
            Criterion::Gcv => "gcv",
            Criterion::Discrepancy => "discrepancy",
            Criterion::LCurve => "l_curve",
            Criterion::Hkb => "hkb",
            Criterion::Hkb1975 => "hkb_1975",
            Criterion::LawlessWang => "lawless_wang",
            Criterion::Optimal => "optimal",
        }
    }

    /// The closed forms for ridge.
    pub const RIDGE: [Criterion; 3] = [Criterion::Hkb, Criterion::Hkb1975, Criterion::LawlessWang];

    /// Every criterion there is.
    pub fn every() -> impl Iterator<Item = Criterion> {
        Self::ALL.into_iter().chain(Self::RIDGE).chain([Criterion::Optimal])
    }
}

/// `u` for a curve's x, `v` only for surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Domain {
    pub u: Option<[f64; 2]>,
    pub v: Option<[f64; 2]>,
}

/// Standard uncertainties of a node, in the caller's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeUncertainty {
    /// Of each abscissa (of each entry for a measurement matrix).
    pub position: f64,
    /// Of the height.
    pub height: f64,
}

/// What is answered only when asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Include {
    pub residuals: bool,
    /// The two n×n collinearity matrices also beyond the size up to which they are always found.
    pub collinearity: bool,
    pub lambda_curve: bool,
    pub matrix_b: bool,
    /// Coefficients along k, for ridge.
    pub ridge_trace: bool,
    /// The weights of a robust estimate, node by node.
    pub robust_weights: bool,
    /// The nodes that filters took for peaks.
    pub peaks: bool,
}
