//! The kinds of regularisation and their parameters.

#[cfg(feature = "contract")]
use flankfit_numerics::contract::{name, whole};

#[cfg(feature = "contract")]
use super::form;
use super::{
    criterion::{Criterion, Parameter},
    representative::Representative,
    scheme::Scheme,
    shrinkage::{Attraction, JamesStein},
    tikhonov::Tikhonov,
};

/// Treatment of small eigenvalues.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{
///         Attraction, Criterion, JamesStein, Model, Parameter, Regularization, ShrinkageFactor,
///         Tikhonov,
///     },
/// };
///
/// // Three columns, two of which are nearly one.
/// let t = |k: i32| f64::from(k) / 10.0 - 1.0;
/// let rows = (0..=20).flat_map(|k| [1.0, t(k), t(k) + 0.02 * t(k).powi(2)]).collect();
/// let heights = (0..=20).map(|k| 3.0 + 4.0 * t(k) + 0.1 * (37.0 * t(k)).sin()).collect();
/// let nodes = Nodes::matrix(rows, 3, heights, None, None)?;
///
/// let parameter = Parameter::Criterion(Criterion::MinMse);
/// let james_stein =
///     JamesStein { factor: ShrinkageFactor::JamesStein, positive_part: true, target: None };
/// let kinds = [
///     Regularization::None,
///     Regularization::default(),
///     Regularization::Ridge { parameter },
///     Regularization::Tikhonov(Tikhonov { order: 0, weights: None, parameter }),
///     Regularization::TruncatedSvd { rank: 2 },
///     Regularization::JamesStein(james_stein),
///     Regularization::Attraction(Attraction { target: vec![3.0, 2.0, 2.0], parameter }),
/// ];
/// for regularization in kinds {
///     let found = fit(&nodes, &FitSpec { regularization, ..FitSpec::new(Model::Linear) })?;
///     // Each says how far it has moved the estimate, and how far it can have moved it at most.
///     assert!(found.bias.norm <= found.bias.sharp_bound * (1.0 + 1e-12));
///     // The surface hardly changes.
///     assert!(found.residuals.rms < 0.5);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "form::Regularization", into = "form::Regularization")
)]
pub enum Regularization {
    /// Least squares as it is.
    None,
    /// The paper's matrix B (Eq. 40).
    Spectral {
        /// Scheme of the eigenvalues of the matrix B.
        scheme: Scheme,
        /// Number of eigenvalues that are raised, L.
        count: Count,
        /// λₙ/λᵢ above which [`Count::Auto`] regularises a direction.
        condition_limit: f64,
        /// λ*, the eigenvalue that small ones are raised to.
        lambda_star: Parameter,
    },
    /// `min ‖Y − XA‖² + k ‖A‖²` in the scaled columns.
    Ridge {
        /// k.
        parameter: Parameter,
    },
    /// A penalty on roughness.
    Tikhonov(Tikhonov),
    /// Only the `rank` largest singular values are kept.
    TruncatedSvd {
        /// Number of singular values that are kept.
        rank: usize,
    },
    /// The same, with the rank chosen by one of [`Criterion::OF_RANK`].
    TruncatedSvdBy {
        /// Criterion of the choice.
        criterion: Criterion,
    },
    /// Shrinkage by a factor that the data give.
    JamesStein(JamesStein),
    /// Shrinkage towards a target.
    Attraction(Attraction),
    /// The matrix B of a representative piece.
    Representative(Representative),
}

impl Regularization {
    /// The parameter, if it has one.
    pub(crate) fn parameter(&self) -> Option<Parameter> {
        match self {
            Regularization::Spectral { lambda_star: parameter, .. }
            | Regularization::Ridge { parameter }
            | Regularization::Tikhonov(Tikhonov { parameter, .. })
            | Regularization::Attraction(Attraction { parameter, .. }) => Some(*parameter),
            Regularization::TruncatedSvdBy { criterion } => Some(Parameter::Criterion(*criterion)),
            Regularization::None
            | Regularization::TruncatedSvd { .. }
            | Regularization::JamesStein(_)
            | Regularization::Representative(_) => None,
        }
    }

    /// The criterion that chooses its parameter, where one does.
    pub fn criterion(&self) -> Option<Criterion> {
        match self.parameter()? {
            Parameter::Criterion(criterion) => Some(criterion),
            Parameter::Fixed(_) => None,
        }
    }
}

/// Type of the regularisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = RegularizationName)
)]
pub enum RegularizationKind {
    /// Least squares as it is.
    None,
    /// The paper's matrix B (Eqs. 27–40).
    Spectral,
    /// Ridge regression.
    Ridge,
    /// A penalty on roughness.
    Tikhonov,
    /// Truncated singular value decomposition.
    TruncatedSvd,
    /// Shrinkage by a factor that the data give (James and Stein).
    JamesStein,
    /// Shrinkage towards a target.
    Attraction,
    /// The matrix B of a representative piece.
    Representative,
}

impl RegularizationKind {
    /// True if each direction of the estimate is an eigenvector of the Fisher information matrix.
    pub(crate) fn filters_eigenvectors(self) -> bool {
        match self {
            Self::None | Self::Spectral | Self::Ridge | Self::TruncatedSvd => true,
            Self::Tikhonov | Self::JamesStein | Self::Attraction | Self::Representative => false,
        }
    }
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

/// Number of the smallest eigenvalues that are regularised (L).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize), serde(untagged))]
pub enum Count {
    /// Eigenvalues with λₙ/λᵢ above the condition limit.
    #[default]
    #[cfg_attr(feature = "contract", serde(with = "auto"))]
    Auto,
    /// This many.
    Given(usize),
}

#[cfg(feature = "contract")]
flankfit_numerics::constant!(auto = "auto");

#[cfg(feature = "contract")]
flankfit_numerics::alternatives!(
    Count,
    "Number of smallest eigenvalues to regularise: a number or `auto`.",
    name("auto"),
    whole(0),
);
