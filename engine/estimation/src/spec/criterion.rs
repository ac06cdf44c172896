//! The criteria that choose a parameter of regularisation.

#[cfg(feature = "contract")]
use super::form;

/// λ* of the spectral schemes, k of ridge.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "form::Parameter", into = "form::Parameter")
)]
pub enum Parameter {
    /// Chosen from the data.
    Criterion(Criterion),
    /// The caller's own, not negative.
    Fixed(f64),
}

/// A rule that chooses λ* or k from the data.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{ChosenBy, Criterion, Model, Parameter, Regularization},
/// };
///
/// let t = |k: i32| f64::from(k) / 10.0 - 1.0;
/// let rows = (0..=20).flat_map(|k| [1.0, t(k), t(k) + 0.1 * t(k).powi(2)]).collect();
/// let heights = (0..=20).map(|k| 3.0 + 4.0 * t(k) + 0.3 * (37.0 * t(k)).sin()).collect();
/// let nodes = Nodes::matrix(rows, 3, heights, None, None)?;
/// let ridge = |criterion: Criterion| {
///     let regularization = Regularization::Ridge { parameter: Parameter::Criterion(criterion) };
///     fit(
///         &nodes,
///         &FitSpec { regularization, noise_sigma: Some(0.3), ..FitSpec::new(Model::Linear) },
///     )
/// };
/// // Each fit says what the other rules would have chosen. (The least condition is a rule of the
/// // spectral schemes alone.)
/// let table = ridge(Criterion::MinMse)?.regularization.choices;
/// let rules =
///     Criterion::ALL.into_iter().filter(|criterion| *criterion != Criterion::MinCondition);
/// for criterion in rules.chain(Criterion::RIDGE) {
///     let chosen = ridge(criterion)?.regularization.lambda_star;
///     let foreseen = table
///         .iter()
///         .find(|choice| choice.criterion == ChosenBy::Criterion(criterion))
///         .map(|choice| choice.lambda_star);
///     assert_eq!(foreseen, Some(chosen));
/// }
/// // Hoerl, Kennard and Baldwin in closed form: pσ²/‖Â‖² in columns of unit length.
/// let found = ridge(Criterion::Hkb1975)?;
/// let norm = found.bias.coefficient_norm_limit;
/// assert!(
///     found
///         .regularization
///         .lambda_star
///         .is_some_and(|k| (k * norm * norm / (3.0 * 0.3 * 0.3) - 1.0).abs() < 1e-12)
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum Criterion {
    /// Least mean squared error of the coefficients, predicted from an estimate less its noise.
    MinMse,
    /// Least condition of the regularised Fisher information matrix (Eq. 49); of spectral schemes
    /// only.
    MinCondition,
    /// Least generalised cross-validation function `RSS/(m − Σfᵢ)²` (Golub, Heath and Wahba).
    Gcv,
    /// RSS = m σ² (Morozov's discrepancy principle).
    Discrepancy,
    /// Greatest curvature of the L-curve, log ‖residuals‖ against log ‖Â_B‖ (Hansen).
    LCurve,
    /// Ridge: (p−2)σ²/‖Â‖², the modified form of Hoerl, Kennard and Baldwin.
    Hkb,
    /// Ridge: pσ²/‖Â‖², as Hoerl, Kennard and Baldwin (1975) gave it.
    #[cfg_attr(feature = "contract", serde(rename = "hkb_1975"))]
    Hkb1975,
    /// Ridge: (p−2)σ² λ̄/ΣλᵢÂᵢ², after Lawless and Wang.
    LawlessWang,
    /// Attraction: the explicit minimiser of the predicted mean squared error.
    Optimal,
    /// Greatest restricted likelihood, the penalty read as the prior `A ~ N(0, σ²K⁻¹)`.
    Reml,
    /// Least `Σ w r²/(1 − h)²`, the penalty held (Allen's PRESS); needs the nodes.
    Press,
    /// Least `Σ w r²` of nodes left out in blocks ([`super::Folds`]), the penalty held; needs the
    /// nodes.
    BlockedCv,
    /// Least `RSS + 2σ² Σfᵢ`, Stein's unbiased estimate of the risk of the fitted heights.
    Sure,
}

/// Origin of a value of λ* or k, as results name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize), serde(untagged))]
pub enum ChosenBy {
    /// A criterion chose it.
    Criterion(Criterion),
    /// The caller gave it.
    #[cfg_attr(feature = "contract", serde(with = "fixed"))]
    Fixed,
    /// Unregularised, for comparison.
    #[cfg_attr(feature = "contract", serde(with = "least_squares"))]
    LeastSquares,
}

#[cfg(feature = "contract")]
flankfit_numerics::constant!(fixed = "fixed");
#[cfg(feature = "contract")]
flankfit_numerics::constant!(least_squares = "least_squares");

#[cfg(feature = "contract")]
impl utoipa::PartialSchema for ChosenBy {
    fn schema() -> utoipa::openapi::RefOr<utoipa::openapi::Schema> {
        let all = Criterion::every().map(ChosenBy::Criterion).chain([ChosenBy::Fixed, ChosenBy::LeastSquares]);
        let description =
            "Criterion that chose λ* or k; `fixed`: the caller gave it; `least_squares`: not regularised.";
        flankfit_numerics::contract::names(all.map(ChosenBy::name)).description(Some(description)).into()
    }
}

#[cfg(feature = "contract")]
impl utoipa::ToSchema for ChosenBy {}

impl ChosenBy {
    /// Returns the stable name.
    pub fn name(self) -> &'static str {
        match self {
            ChosenBy::Criterion(criterion) => criterion.name(),
            ChosenBy::Fixed => "fixed",
            ChosenBy::LeastSquares => "least_squares",
        }
    }
}

impl From<Option<Criterion>> for ChosenBy {
    /// Returns least squares for no criterion.
    fn from(criterion: Option<Criterion>) -> Self {
        criterion.map_or(ChosenBy::LeastSquares, ChosenBy::Criterion)
    }
}

impl From<Parameter> for ChosenBy {
    fn from(parameter: Parameter) -> Self {
        match parameter {
            Parameter::Criterion(criterion) => ChosenBy::Criterion(criterion),
            Parameter::Fixed(_) => ChosenBy::Fixed,
        }
    }
}

impl Criterion {
    /// Criteria that every regularisation with a parameter accepts, and whose choices are reported
    /// with the requested one.
    pub const ALL: [Criterion; 5] =
        [Criterion::MinMse, Criterion::MinCondition, Criterion::Gcv, Criterion::Discrepancy, Criterion::LCurve];

    /// Stable name.
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
            Criterion::Reml => "reml",
            Criterion::Press => "press",
            Criterion::BlockedCv => "blocked_cv",
            Criterion::Sure => "sure",
        }
    }

    /// The closed forms for ridge.
    pub const RIDGE: [Criterion; 3] = [Criterion::Hkb, Criterion::Hkb1975, Criterion::LawlessWang];

    /// Criteria that are evaluated only on request.
    pub const MORE: [Criterion; 4] = [Criterion::Reml, Criterion::Press, Criterion::BlockedCv, Criterion::Sure];

    /// The criteria for the rank of a truncated singular value decomposition.
    pub const OF_RANK: [Criterion; 3] = [Criterion::Gcv, Criterion::Reml, Criterion::Discrepancy];

    /// Checks that it is one for every regularisation, or one of `own`.
    pub fn check_among(self, own: &[Criterion]) -> Result<(), String> {
        if Self::ALL.contains(&self) || Self::MORE.contains(&self) || own.contains(&self) {
            return Ok(());
        }
        let name = self.name();
        Err(format!("`{name}` is for another regularisation (hkb, hkb_1975, lawless_wang: ridge; optimal: attraction)"))
    }

    /// True if the criterion uses single nodes.
    pub fn is_nodewise(self) -> bool {
        matches!(self, Criterion::Press | Criterion::BlockedCv)
    }

    /// Every criterion there is.
    pub fn every() -> impl Iterator<Item = Criterion> {
        Self::ALL.into_iter().chain(Self::RIDGE).chain([Criterion::Optimal]).chain(Self::MORE)
    }
}
