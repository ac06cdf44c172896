//! Estimators: least squares, or one that gross errors cannot pull away.

#[cfg(feature = "contract")]
use super::form;
use super::{
    contamination::{Contamination, minimax_k},
    l_estimator::LEstimator,
    likelihood::Distribution,
    loss::Loss,
};

/// Estimator of the coefficients. Weights of nodes act by `√w` on rows and heights, for every
/// estimator.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{
///         Degree, Estimator, Loss, MEstimator, Model, PolynomialBasis, Regularization, Terms,
///     },
/// };
///
/// // The line 1 + 2x, and a speck of dust on one node.
/// let x: Vec<f64> = (0..=10).map(f64::from).collect();
/// let mut y: Vec<f64> = x.iter().map(|x| 1.0 + 2.0 * x).collect();
/// y[8] += 40.0;
/// let nodes = Nodes::curve(x, y, None)?;
/// let model = Model::Polynomial {
///     degree: Degree::Both(1),
///     basis: PolynomialBasis::Monomial,
///     terms: Terms::Tensor,
/// };
/// let plain = FitSpec { regularization: Regularization::None, ..FitSpec::new(model) };
/// let slope = |estimator: Estimator| {
///     let found = fit(&nodes, &FitSpec { estimator, ..plain.clone() })?;
///     Ok::<f64, flankfit_estimation::FitError>(found.coefficients[1].value)
/// };
/// // Least squares gives way by 40 · 3/110.
/// assert!((slope(Estimator::LeastSquares)? - (2.0 + 120.0 / 110.0)).abs() < 1e-12);
/// let robust = [
///     Estimator::M(MEstimator::new(Loss::TUKEY)),
///     Estimator::LeastAbsolute,
///     Estimator::Quantile { tau: 0.5 },
///     Estimator::LeastTrimmed { coverage: 0.75, seed: 1 },
///     Estimator::Rank,
/// ];
/// for estimator in robust {
///     assert!((slope(estimator)? - 2.0).abs() < 1e-9, "{estimator:?}");
/// }
/// // Lₚ lies between both.
/// let between = slope(Estimator::Lp { p: 1.5 })?;
/// assert!(2.0 < between && between < 3.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "form::Estimator", into = "form::Estimator")
)]
pub enum Estimator {
    /// Least `Σ r²` (Eq. 15).
    #[default]
    LeastSquares,
    /// Eqs. 10–12.
    M(MEstimator),
    /// Least `Σ|r|`: variationally weighted least squares (Mudrov and Kushko), solved exactly.
    LeastAbsolute,
    /// Least `Σ|r|^p`, 1 ≤ p ≤ 2.
    Lp {
        /// p.
        p: f64,
    },
    /// Regression quantile (Koenker and Bassett), 0 < tau < 1.
    Quantile {
        /// The share of nodes that lie below the function, 0.5 for the median.
        tau: f64,
    },
    /// Least sum of the smallest squares; `coverage` is the share of nodes in it, 0.5 to 1.
    LeastTrimmed {
        /// Share of the nodes whose squares are summed.
        coverage: f64,
        /// Seed of the random starts: the same seed gives the same estimate.
        seed: u64,
    },
    /// Least rank dispersion with Wilcoxon scores (Jaeckel).
    Rank,
    /// Least rank dispersion with normal scores (van der Waerden).
    NormalScores,
    /// Regression quantiles combined, trimmed or winsorized.
    L(LEstimator),
    /// Maximum likelihood for errors that are not normal.
    Likelihood(Distribution),
}

/// Share of nodes that least trimmed squares keeps, unless asked otherwise.
pub const DEFAULT_COVERAGE: f64 = 0.75;

/// Least `Σ ρ(r/s)` by reweighting: in each iteration scale, then weights, then solve.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Estimator, Include, Loss, MEstimator, Model, Regularization, ScaleRule, Start},
/// };
///
/// // The location of numbers about 10, one of them far off.
/// let heights = vec![9.8, 10.1, 10.4, 9.7, 10.0, 25.0];
/// let nodes = Nodes::matrix(vec![1.0; 6], 1, heights, None, None)?;
/// let (scale, start) = (ScaleRule::Fixed(0.25), Start::LeastTrimmed);
/// let tukey = MEstimator { scale, start, ..MEstimator::new(Loss::TUKEY) };
/// let spec = FitSpec {
///     estimator: Estimator::M(tukey),
///     regularization: Regularization::None,
///     include: Include { robust_weights: true, ..Include::default() },
///     ..FitSpec::new(Model::Linear)
/// };
/// let found = fit(&nodes, &spec)?;
/// // Nodes above c = 4.685 scales have no weight.
/// let robust = found.robust.expect("the estimator is a robust one");
/// assert!(robust.converged);
/// assert_eq!(robust.rejected, Some(vec![5]));
/// assert!((found.coefficients[0].value - 10.0).abs() < 0.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MEstimator {
    /// ρ.
    pub loss: Loss,
    /// Rule for the scale s of the residuals.
    pub scale: ScaleRule,
    /// The iteration stops when no residual and not the scale moves by more than this many scales.
    pub tolerance: f64,
    /// Iterations at most.
    pub max_iterations: usize,
    /// Start of the iteration.
    pub start: Start,
    /// Contamination for which `loss` is minimax; an estimated share takes its place.
    pub contamination: Option<Contamination>,
}

impl MEstimator {
    /// Tolerance near the limit of doubles: a change of 1e-13 scales.
    pub const TOLERANCE: f64 = 1e-13;
    /// Iterations allowed unless asked otherwise.
    pub const ITERATIONS: usize = 1000;
    /// `loss` with MAD/0.6745, from least squares.
    pub fn new(loss: Loss) -> Self {
        MEstimator {
            loss,
            scale: ScaleRule::default(),
            tolerance: Self::TOLERANCE,
            max_iterations: Self::ITERATIONS,
            start: Start::LeastSquares,
            contamination: None,
        }
    }

    /// Huber's minimax estimator for a share of gross errors.
    ///
    /// ```
    /// use flankfit_estimation::spec::{Contamination, Loss, MEstimator};
    ///
    /// let minimax = MEstimator::minimax(Contamination::Share(0.1));
    /// assert!(matches!(minimax.loss, Loss::Huber { k } if (k - 1.140).abs() < 1e-3));
    /// ```
    pub fn minimax(contamination: Contamination) -> Self {
        let loss = match contamination {
            Contamination::Share(share) => Loss::Huber { k: minimax_k(share) },
            Contamination::Estimated => Loss::HUBER,
        };
        MEstimator { contamination: Some(contamination), ..Self::new(loss) }
    }
}

/// Rule for the scale of the residuals in each iteration.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum ScaleRule {
    /// Median of |r| divided by 0.6745, as R's MASS has it.
    #[default]
    Mad06745,
    /// Median of |r| divided by Φ⁻¹(0.75) = 0.674489750196….
    Mad,
    /// Huber's proposal 2 with its own `k2`.
    Proposal2 {
        /// k₂, in scales.
        k2: f64,
    },
    /// The caller's, in the unit of the heights.
    Fixed(f64),
}

impl ScaleRule {
    /// k₂ of proposal 2 that can be given.
    pub const K2: [f64; 2] = [0.01, 100.0];
}

/// k₂ of proposal 2 unless asked otherwise.
pub const DEFAULT_K2: f64 = 1.345;

/// Start of an iteration; least trimmed squares of half the nodes tolerates gross errors in
/// nearly half of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum Start {
    /// The least-squares estimate.
    #[default]
    LeastSquares,
    /// Least trimmed squares of half the nodes, which up to half of them cannot spoil.
    #[cfg_attr(feature = "contract", serde(rename = "least_trimmed_squares"))]
    LeastTrimmed,
}
