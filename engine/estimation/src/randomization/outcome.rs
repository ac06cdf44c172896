//! Result of one repetition.

/// Result of one repetition.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// One entry for each level, in the order given.
    pub levels: Vec<LevelOutcome>,
    /// ‖e‖² less what the columns of X reach.
    pub rss: f64,
    /// uᵢᵀe along each direction.
    pub along: Vec<f64>,
}

/// Results of one level; not finite where the columns depend on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelOutcome {
    /// cond(X̃ᵀX̃).
    pub condition: f64,
    /// log₁₀ det(X̃ᵀX̃).
    pub log10_determinant: f64,
    /// ‖A − Â_R‖².
    pub error: f64,
    /// ‖y − X Â_R‖².
    pub rss: f64,
    /// ‖y − X̃ Â_R‖².
    pub fitted_rss: f64,
}
