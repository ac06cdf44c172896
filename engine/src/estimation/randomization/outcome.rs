//! What one repetition found.

/// What one repetition found.
pub(super) struct Outcome {
    pub levels: Vec<LevelFigures>,
    /// ‖e‖² less what the columns of X reach, and uᵢᵀe along each direction.
    pub rss: f64,
    pub along: Vec<f64>,
}

/// Figures of one level; not finite where the columns depend on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LevelFigures {
    pub condition: f64,
    pub log10_determinant: f64,
    pub error: f64,
    pub rss: f64,
    pub fitted_rss: f64,
}
