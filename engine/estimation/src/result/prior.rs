//! Effect of the prior.

/// Effect of the prior. `spectrum.eigenvalues` are those of the nodes alone,
/// `spectrum.regularized` those of nodes and prior together.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = PriorResult)
)]
pub struct PriorReport {
    /// The earlier iterations, oldest first; absent with `mean`. If the list is empty, the
    /// nodes alone are used.
    pub iterations: Option<Vec<u32>>,
    /// The chosen fit of each iteration when this one was made. The nodes of the iteration are
    /// fitted by this fit's own spec.
    pub fit_ids: Option<Vec<String>>,
    /// Corrections whose predicted changes were added to the prior, in their order.
    pub corrections: Vec<UsedCorrection>,
    /// Standard deviation of the move of each coefficient from one iteration to the next.
    #[cfg_attr(feature = "contract", serde(rename = "move"))]
    pub move_std_error: Option<Vec<f64>>,
    /// The same in standard errors of the coefficient by these nodes alone, where it was
    /// estimated.
    pub move_ratio: Option<f64>,
    /// Test of the nodes against the prior; absent where it is not available (with iterations
    /// and an estimated move, before the third iteration; available from the second if the move
    /// exceeds 1,000 standard errors, the largest step allowed).
    pub conflict: Option<PriorConflict>,
    /// For each coefficient the share of the prior in the information: 1 minus the ratio of its
    /// variance to that of least squares, both for `sigma`.
    pub share: Vec<f64>,
    /// Standard deviation of a height of weight 1, from the residuals of all iterations
    /// together, or as given. Errors of the coefficients use it, unless a prior with a given
    /// `move` or `mean` is dropped.
    pub sigma: Option<f64>,
    /// Degrees of freedom of `sigma`; absent where it was given.
    pub degrees_of_freedom: Option<usize>,
}

/// A correction of the machine between two iterations.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct UsedCorrection {
    /// Its iteration.
    pub iteration: u32,
    /// Its record.
    pub record_id: String,
    /// The changes that were entered on the machine, in the order of the correction's settings;
    /// absent where the proposed changes were taken.
    pub entered: Option<Vec<f64>>,
}

/// Distance between the nodes and the prediction of the prior.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct PriorConflict {
    /// `eᵀS⁻¹e/n`, where e is the distance from the prediction and S its covariance: about 1 if
    /// the prior is correct.
    pub statistic: f64,
    /// Probability of this value or a larger one if the prior is correct.
    pub p: f64,
    /// True if p is below 1e-4: the prior is dropped, and least squares of these nodes is
    /// returned (warning `prior_conflict`). Where moves are estimated the intervals are the
    /// same as without a conflict: their coverage holds for any flank.
    pub dropped: bool,
}

impl PriorReport {
    /// True if every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        let moved = self.move_std_error.iter().flatten().chain(&self.move_ratio);
        let conflict = self.conflict.iter().flat_map(|found| [&found.statistic, &found.p]);
        self.share.iter().chain(moved).chain(conflict).chain(&self.sigma).all(|x| x.is_finite())
    }
}
