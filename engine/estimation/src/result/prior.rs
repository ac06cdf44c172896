//! Effect of the prior.

/// What became of what was known before the nodes were measured.
#[derive(Clone, Debug, PartialEq)]
pub struct PriorReport {
    /// Numbers of the earlier iterations, oldest first; `None` for a prior that was given.
    pub iterations: Option<Vec<u32>>,
    /// The fits of them that stood.
    pub fit_ids: Option<Vec<String>>,
    /// The corrections whose predicted changes were taken to have come.
    pub corrections: Vec<UsedCorrection>,
    /// Standard deviation of the move of each coefficient between two iterations, in the caller's
    /// terms.
    pub move_std_error: Option<Vec<f64>>,
    /// The same in standard errors of a coefficient, where it was estimated: root mean square.
    pub move_ratio: Option<f64>,
    /// Whether the nodes contradict the prior; `None` where that cannot be told yet.
    pub conflict: Option<PriorConflict>,
    /// Share of the information on each coefficient that is the prior's: 1 less the variance over
    /// that of least squares, both for the same σ.
    pub share: Vec<f64>,
    /// σ̂ of a height of weight 1, of all residuals together; or σ that was given.
    pub sigma: Option<f64>,
    /// The degrees of freedom of all residuals together; `None` where σ was given.
    pub degrees_of_freedom: Option<usize>,
}

/// A correction between two iterations.
#[derive(Clone, Debug, PartialEq)]
pub struct UsedCorrection {
    /// The iteration that it was kept with.
    pub iteration: u32,
    /// The record that holds it.
    pub record_id: String,
    /// The changes of the settings that were entered in place of the proposed ones.
    pub entered: Option<Vec<f64>>,
}

/// How far the nodes lie from what the prior predicts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PriorConflict {
    /// `eᵀS⁻¹e/n`: about 1 where the prior holds.
    pub statistic: f64,
    /// The probability of as much or more where the prior holds, by F(n, ν).
    pub p: f64,
    /// Whether the prior was let go.
    pub let_go: bool,
}

/// σ of the nodes of now and of earlier iterations, which are not the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnequalNoise {
    /// Standard deviation from the current nodes.
    pub now: f64,
    /// Standard deviation from all earlier iterations together.
    pub earlier: f64,
    /// The probability of so different ones by chance.
    pub p: f64,
}

impl PriorReport {
    /// Whether every number is one.
    pub(crate) fn is_finite(&self) -> bool {
        let moved = self.move_std_error.iter().flatten().chain(&self.move_ratio);
        let conflict = self.conflict.iter().flat_map(|found| [&found.statistic, &found.p]);
        self.share.iter().chain(moved).chain(conflict).chain(&self.sigma).all(|x| x.is_finite())
    }
}
